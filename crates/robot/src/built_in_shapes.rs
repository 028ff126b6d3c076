//! Capsules of the robots that ship with the crate, modelled by hand after the proportions of the makers' drawings.
//!
//! They leave out grippers, cables and the pedestal. Register a robot with shapes of its own where that matters.

use super::RobotModel;
use super::collision::LinkCapsule;
use super::shape::Segment;

/// Link, both ends and radius of a capsule, m, in the frame of the link.
type Row = (&'static str, [f64; 3], [f64; 3], f64);

const PANDA: [Row; 8] = [
    ("panda_link0", [0.0, 0.0, 0.05], [-0.055, 0.0, 0.015], 0.105),
    ("panda_link1", [0.0, 0.0, -0.14], [0.0, -0.055, 0.0], 0.077),
    ("panda_link2", [0.0, -0.14, 0.0], [0.0, 0.0, 0.055], 0.077),
    ("panda_link3", [0.083, 0.043, 0.0], [0.0, 0.0, -0.08], 0.07),
    ("panda_link4", [0.0, 0.0, 0.043], [-0.081, 0.084, 0.0], 0.07),
    ("panda_link5", [0.0, 0.064, 0.004], [0.0, 0.01, -0.245], 0.068),
    ("panda_link6", [0.087, 0.009, 0.0], [0.023, 0.007, 0.006], 0.075),
    ("panda_link7", [0.0, 0.0, 0.01], [0.0, 0.0, 0.06], 0.06),
];

const UR5E: [Row; 9] = [
    ("base", [0.0, 0.0, 0.0], [0.0, 0.0, 0.05], 0.075),
    ("shoulder_link", [0.0, 0.0, 0.1], [0.0, -0.07, 0.1625], 0.067),
    ("upper_arm_link", [0.0, 0.0, 0.138], [-0.425, 0.0, 0.138], 0.063),
    ("upper_arm_link", [-0.425, 0.0, 0.12], [-0.425, 0.0, 0.07], 0.055),
    ("forearm_link", [0.0, 0.0, 0.02], [-0.39, 0.0, 0.007], 0.055),
    ("wrist_1_link", [0.0, 0.0, 0.05], [0.0, 0.0, 0.12], 0.046),
    ("wrist_2_link", [0.0, 0.0, 0.0], [0.0, 0.0, 0.1], 0.048),
    ("wrist_3_link", [0.0, 0.0, 0.045], [0.0, 0.0, 0.06], 0.042),
    ("flange", [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], 0.04),
];

const SAWYER: [Row; 11] = [
    ("base", [0.0, 0.0, 0.0], [0.0, 0.0, 0.05], 0.11),
    ("right_l0", [0.0, 0.0, 0.05], [0.0, 0.0, 0.237], 0.085),
    ("right_l0", [0.0, 0.0, 0.237], [0.081, 0.05, 0.237], 0.075),
    ("right_l1", [0.0, 0.0, 0.02], [0.0, 0.0, 0.13], 0.07),
    ("right_l1", [0.0, -0.02, 0.1425], [0.0, -0.12, 0.1425], 0.065),
    ("right_l2", [0.0, 0.0, 0.02], [0.0, -0.03, 0.25], 0.065),
    ("right_l3", [0.0, 0.0, 0.0], [0.0, 0.0, -0.12], 0.06),
    ("right_l3", [0.0, -0.02, -0.1265], [0.0, -0.11, -0.1265], 0.055),
    ("right_l4", [0.0, 0.0, 0.02], [0.0, 0.03, 0.26], 0.055),
    ("right_l5", [0.0, 0.0, 0.0], [0.0, -0.09, 0.1], 0.05),
    ("right_l6", [0.0, 0.0, 0.0], [0.0, 0.0, 0.02], 0.04),
];

const PLANAR_3R: [Row; 3] = [
    ("upper_arm", [0.0, 0.0, 0.0], [0.5, 0.0, 0.0], 0.03),
    ("forearm", [0.0, 0.0, 0.0], [0.4, 0.0, 0.0], 0.03),
    ("hand", [0.0, 0.0, 0.0], [0.3, 0.0, 0.0], 0.03),
];

/// Returns the same robot with the capsules that belong to its name; without any if there are none.
pub fn with_built_in_shapes(robot: RobotModel) -> RobotModel {
    let rows: &[Row] = match robot.name() {
        "panda" => &PANDA,
        "ur5e" => &UR5E,
        "sawyer" => &SAWYER,
        "planar_3r" => &PLANAR_3R,
        _ => return robot,
    };
    let capsule = |&(link, from, to, radius): &Row| {
        let core = Segment { from: from.into(), to: to.into() };
        robot.link(link).map(|link| LinkCapsule { link, core, radius })
    };
    let capsules = rows.iter().filter_map(capsule).collect();
    robot.clone().with_capsules(capsules, &[]).unwrap_or(robot)
}

#[cfg(test)]
mod tests {
    use crate::collision::{CollisionModel, PlacedBody, WatchedPair};
    use crate::kinematics::Configuration;
    use crate::{RobotModel, built_in};

    /// Returns the smallest distance of a watched pair, with the pair.
    fn nearest(robot: &RobotModel, model: &CollisionModel, q: &[f64]) -> (f64, [String; 2]) {
        let body = PlacedBody::new(model, &Configuration::new(robot, q).unwrap());
        let distance = |pair: &WatchedPair| {
            let [i, j] = pair.capsules;
            let radii = model.capsules()[i].radius + model.capsules()[j].radius;
            let names = [i, j].map(|k| robot.links()[model.capsules()[k].link.index()].name.clone());
            (body.core(i).to_segment(body.core(j)).distance - radii, names)
        };
        model.pairs().iter().map(distance).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    }

    #[test]
    fn ordinary_postures_are_clear_and_folded_ones_are_not() {
        use std::f64::consts::FRAC_PI_2;
        let ordinary: [(&str, &[f64]); 4] = [
            ("panda", &[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
            ("ur5e", &[0.0, -FRAC_PI_2, 1.2, -1.2, -FRAC_PI_2, 0.0]),
            ("sawyer", &[0.0, -0.8, 0.0, 1.6, 0.0, 0.8, 0.0]),
            ("planar_3r", &[0.3, 0.6, 0.5]),
        ];
        for (name, q) in ordinary {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            let (distance, pair) = nearest(robot, robot.collision().unwrap(), q);
            assert!(distance > 0.02, "{name}: {distance} m between {pair:?}");
        }
        let folded: [(&str, &[f64]); 2] =
            [("ur5e", &[0.0, -FRAC_PI_2, 3.0, 0.0, 0.0, 0.0]), ("planar_3r", &[0.0, 2.9, 2.9])];
        for (name, q) in folded {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            let (distance, pair) = nearest(robot, robot.collision().unwrap(), q);
            assert!(distance < 0.01, "{name}: {distance} m between {pair:?}");
        }
    }

    #[test]
    fn each_capsule_is_on_a_link_of_its_robot() {
        for (name, count) in [("panda", 8), ("ur5e", 9), ("sawyer", 11), ("planar_3r", 3)] {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            assert_eq!(robot.collision().unwrap().capsules().len(), count, "{name}");
        }
        assert!(built_in()[0].collision().is_none(), "{}", built_in()[0].name());
    }
}

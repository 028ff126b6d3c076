//! Capsules of the robots that ship with the crate.
//!
//! Those of `panda`, `ur5e`, `sawyer` and `planar_3r` are modelled by hand after the proportions of the makers' drawings. `fr3` has
//! those of `panda`, whose dimensions it shares. Those of `xarm7`, `iiwa14`, `gen3` and `so101` cover meshes that others drew:
//! `fixtures/golden/make/make_capsules.py` prints them.
//!
//! They leave out grippers, cables and the pedestal; `so101` has its gripper, closed. Register a robot with shapes of its own
//! where that matters.

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

const XARM7: [Row; 15] = [
    ("link_base", [-0.013, 0.003, 0.029], [-0.001, 0.0, 0.09], 0.082),
    ("link1", [-0.003, 0.002, -0.057], [0.0, 0.018, 0.002], 0.076),
    ("link2", [0.0, -0.072, 0.097], [0.0, 0.0, 0.085], 0.049),
    ("link2", [-0.003, -0.112, 0.014], [-0.012, -0.16, 0.002], 0.064),
    ("link2", [0.0, -0.108, 0.072], [0.0, -0.082, 0.087], 0.053),
    ("link3", [0.052, -0.017, 0.0], [0.03, 0.021, -0.01], 0.066),
    ("link3", [0.0, 0.0, -0.089], [-0.002, 0.022, -0.054], 0.045),
    ("link4", [0.031, -0.033, 0.085], [0.0, 0.0, 0.076], 0.044),
    ("link4", [0.068, -0.072, 0.057], [0.053, -0.063, 0.059], 0.064),
    ("link4", [0.086, -0.093, 0.003], [0.078, -0.134, -0.001], 0.057),
    ("link5", [-0.001, 0.055, -0.042], [0.0, 0.037, 0.002], 0.051),
    ("link5", [0.0, 0.0, -0.158], [0.002, 0.064, -0.081], 0.045),
    ("link6", [0.076, 0.036, 0.001], [0.064, -0.012, 0.003], 0.051),
    ("link6", [-0.001, 0.0, 0.019], [0.024, -0.001, 0.028], 0.045),
    ("link7", [0.0, -0.013, -0.014], [0.0, 0.0, -0.014], 0.04),
];

const IIWA14: [Row; 8] = [
    ("iiwa_link_0", [0.0, 0.0, 0.055], [-0.047, 0.0, 0.056], 0.134),
    ("iiwa_link_1", [-0.004, -0.026, 0.2], [-0.003, 0.001, 0.033], 0.095),
    ("iiwa_link_2", [0.0, 0.0, 0.14], [-0.001, 0.041, -0.005], 0.095),
    ("iiwa_link_3", [-0.001, 0.039, 0.216], [0.0, 0.002, 0.037], 0.08),
    ("iiwa_link_4", [-0.002, -0.002, 0.149], [0.0, -0.042, -0.006], 0.08),
    ("iiwa_link_5", [-0.003, 0.001, 0.018], [0.001, -0.061, 0.193], 0.075),
    ("iiwa_link_6", [-0.004, -0.009, 0.037], [0.003, -0.002, -0.026], 0.077),
    ("iiwa_link_7", [0.0, 0.0, 0.006], [-0.001, 0.0, 0.008], 0.053),
];

const GEN3: [Row; 8] = [
    ("base_link", [-0.002, 0.0, 0.151], [-0.005, 0.0, 0.003], 0.052),
    ("shoulder_link", [0.0, 0.0, -0.032], [0.0, -0.008, -0.128], 0.054),
    ("half_arm_1_link", [0.0, 0.004, -0.019], [0.0, -0.213, -0.006], 0.048),
    ("half_arm_2_link", [0.0, 0.001, -0.03], [-0.001, -0.004, -0.214], 0.054),
    ("forearm_link", [-0.001, -0.197, 0.0], [0.0, 0.003, -0.02], 0.048),
    ("spherical_wrist_1_link", [0.0, -0.013, -0.106], [0.0, -0.003, -0.026], 0.044),
    ("spherical_wrist_2_link", [0.0, -0.101, 0.0], [0.0, -0.001, -0.02], 0.04),
    ("bracelet_link", [0.0, 0.0, -0.036], [0.0, -0.054, -0.055], 0.048),
];

const SO101: [Row; 12] = [
    ("base_link", [-0.022, 0.03, 0.012], [0.052, 0.041, -0.001], 0.022),
    ("base_link", [0.05, -0.039, 0.006], [-0.027, -0.03, 0.011], 0.023),
    ("base_link", [0.03, 0.005, 0.046], [-0.022, 0.0, 0.048], 0.032),
    ("base_link", [-0.007, -0.009, 0.027], [0.034, 0.011, 0.012], 0.046),
    ("shoulder_link", [0.033, 0.002, 0.006], [0.029, 0.0, 0.04], 0.031),
    ("shoulder_link", [0.009, 0.0, -0.018], [0.035, 0.0, -0.015], 0.035),
    ("upper_arm_link", [0.009, 0.018, 0.112], [-0.001, 0.02, 0.001], 0.036),
    ("lower_arm_link", [0.12, 0.02, 0.0], [0.001, 0.02, -0.001], 0.034),
    ("wrist_link", [0.013, 0.018, 0.0], [0.046, 0.028, 0.003], 0.035),
    ("gripper_link", [0.018, -0.001, 0.009], [0.025, 0.0, -0.014], 0.032),
    ("gripper_link", [0.091, 0.0, -0.006], [0.045, -0.001, -0.024], 0.016),
    ("gripper_link", [0.025, 0.0, 0.021], [0.079, 0.0, 0.01], 0.027),
];

/// Returns the same robot with the capsules that belong to its name; without any if there are none.
pub fn with_built_in_shapes(robot: RobotModel) -> RobotModel {
    let rows: &[Row] = match robot.name() {
        "panda" | "fr3" => &PANDA,
        "ur5e" => &UR5E,
        "sawyer" => &SAWYER,
        "planar_3r" => &PLANAR_3R,
        "so101" => &SO101,
        "xarm7" => &XARM7,
        "iiwa14" => &IIWA14,
        "gen3" => &GEN3,
        _ => return robot,
    };
    let capsule = |&(link, from, to, radius): &Row| {
        let core = Segment { from: from.into(), to: to.into() };
        let link = if robot.name() == "fr3" { &link.replace("panda", "fr3") } else { link };
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
        use std::f64::consts::{FRAC_PI_2, PI};
        let ordinary: [(&str, &[f64]); 9] = [
            ("panda", &[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
            ("ur5e", &[0.0, -FRAC_PI_2, 1.2, -1.2, -FRAC_PI_2, 0.0]),
            ("sawyer", &[0.0, -0.8, 0.0, 1.6, 0.0, 0.8, 0.0]),
            ("planar_3r", &[0.3, 0.6, 0.5]),
            ("so101", &[0.0, -0.2, 0.2, 0.9, 0.0]),
            ("fr3", &[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
            ("xarm7", &[0.0, -0.3, 0.0, 0.8, 0.0, 1.1, 0.0]),
            ("iiwa14", &[0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0]),
            ("gen3", &[0.0, 0.3, PI, -1.7, 0.0, -1.1, FRAC_PI_2]),
        ];
        for (name, q) in ordinary {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            let (distance, pair) = nearest(robot, robot.collision().unwrap(), q);
            // The shoulder of the smallest arm turns 15 mm above its base.
            let clear = if name == "so101" { 0.01 } else { 0.02 };
            assert!(distance > clear, "{name}: {distance} m between {pair:?}");
        }
        let folded: [(&str, &[f64]); 6] = [
            ("ur5e", &[0.0, -FRAC_PI_2, 3.0, 0.0, 0.0, 0.0]),
            ("planar_3r", &[0.0, 2.9, 2.9]),
            ("so101", &[0.0, 1.2, 1.6, 1.6, 0.0]),
            ("xarm7", &[0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0]),
            ("iiwa14", &[0.0, 1.9, 0.0, -2.0, 0.0, -2.0, 0.0]),
            ("gen3", &[0.0, 2.2, 0.0, 2.5, 0.0, 0.0, 0.0]),
        ];
        for (name, q) in folded {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            let (distance, pair) = nearest(robot, robot.collision().unwrap(), q);
            assert!(distance < 0.01, "{name}: {distance} m between {pair:?}");
        }
    }

    #[test]
    fn each_capsule_is_on_a_link_of_its_robot() {
        for (name, count) in [
            ("panda", 8),
            ("ur5e", 9),
            ("sawyer", 11),
            ("planar_3r", 3),
            ("so101", 12),
            ("fr3", 8),
            ("xarm7", 15),
            ("iiwa14", 8),
            ("gen3", 8),
        ] {
            let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
            assert_eq!(robot.collision().unwrap().capsules().len(), count, "{name}");
        }
        assert!(built_in()[0].collision().is_none(), "{}", built_in()[0].name());
    }
}

//! Gradients of distances and levers of random trees of links.

use nalgebra::{IsometryMatrix3, Vector3};
use proptest::prelude::*;
use revprio_robot::collision::{BodyPoint, LinkCapsule, PlacedBody, Segment, levers};
use revprio_robot::kinematics::Configuration;
use revprio_robot::{JointKind, JointLimits, JointMotion, RobotModel, TreeDescription, TreeJoint, TreeTip};

/// Range of a joint, rad or m.
const RANGE: f64 = 1.5;

fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    prop::array::uniform3(-size..size).prop_map(Vector3::from)
}

/// A joint: the place of its parent among the joints before it, its origin, its axis, and whether it slides.
type Joint = (prop::sample::Index, (Vector3<f64>, Vector3<f64>), Vector3<f64>, bool);

fn joint() -> impl Strategy<Value = Joint> {
    let slides = prop_oneof![4 => Just(false), 1 => Just(true)];
    (any::<prop::sample::Index>(), (vector(0.4), vector(2.0)), vector(1.0), slides)
}

/// A tree of turning and sliding joints with a capsule on each link.
fn robot() -> impl Strategy<Value = RobotModel> {
    let capsule = (vector(0.2), vector(0.2), 0.01..0.1_f64);
    prop::collection::vec((joint(), capsule), 2..9).prop_map(|described| {
        let name = |i: usize| if i == 0 { "base".to_owned() } else { format!("link{i}") };
        let limits = JointLimits { lower: -RANGE, upper: RANGE, ..JointLimits::NONE };
        let joint = |(i, ((parent, (shift, turn), axis, slides), _)): (usize, &(Joint, _))| TreeJoint {
            name: format!("joint{}", i + 1),
            parent: name(parent.index(i + 1)),
            child: name(i + 1),
            origin: IsometryMatrix3::new(*shift, *turn),
            motion: Some(JointMotion {
                kind: if *slides { JointKind::Prismatic } else { JointKind::Revolute },
                axis: if axis.norm() > 0.1 { *axis } else { Vector3::z() },
                limits,
                mimic: None,
            }),
        };
        let joints: Vec<TreeJoint> = described.iter().enumerate().map(joint).collect();
        let tips =
            vec![TreeTip { name: "tip".to_owned(), link: name(described.len()), offset: IsometryMatrix3::identity() }];
        let robot =
            RobotModel::from_tree("any", "", &TreeDescription { base: "base".to_owned(), joints, tips }).unwrap();
        let capsules = described.iter().enumerate().map(|(i, (_, (from, to, radius)))| LinkCapsule {
            link: robot.link(&name(i + 1)).unwrap(),
            core: Segment { from: *from, to: *to },
            radius: *radius,
        });
        let capsules: Vec<LinkCapsule> = capsules.collect();
        robot.with_capsules(capsules, &[]).unwrap()
    })
}

/// Returns the point of a capsule's core at `share`, seen from the frame of a joint, m.
fn point(robot: &RobotModel, q: &[f64], capsule: usize, share: f64, seen_from: Option<usize>) -> Vector3<f64> {
    let body = PlacedBody::new(robot.collision().unwrap(), &Configuration::new(robot, q).unwrap());
    let core = body.core(capsule);
    let frame = body.frame(seen_from);
    frame.inverse_transform_point(&(core.from + (core.to - core.from) * share).into()).coords
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_gradient_of_a_distance_equals_differences(
        robot in robot(),
        posture in prop::collection::vec(-RANGE..RANGE, 8),
        picked in prop::array::uniform2(any::<prop::sample::Index>()),
        direction in vector(1.0),
    ) {
        let n = robot.joint_count();
        let q = &posture[..n];
        let model = robot.collision().unwrap();
        let [a, b] = picked.map(|index| index.index(n));
        let common = revprio_robot::collision::last_common(&robot, model.joint(a), model.joint(b));
        let configuration = Configuration::new(&robot, q).unwrap();
        let body = PlacedBody::new(model, &configuration);
        let normal = direction.try_normalize(0.1).unwrap_or(Vector3::x());
        let ends = [a, b].map(|k| BodyPoint { joint: model.joint(k), position: body.core(k).from });
        let mut gradient = vec![f64::NAN; n];
        configuration.write_distance_gradient(ends, &normal, &mut gradient);

        // The direction turns with the last link that carries both.
        let local = body.frame(common).rotation.inverse() * normal;
        let apart = |q: &[f64]| local.dot(&(point(&robot, q, a, 0.0, common) - point(&robot, q, b, 0.0, common)));
        for joint in 0..n {
            let at = |step: f64| {
                let mut moved = q.to_vec();
                moved[joint] += step;
                apart(&moved)
            };
            let difference = (at(1e-6) - at(-1e-6)) / 2e-6;
            prop_assert!((difference - gradient[joint]).abs() < 1e-7, "joint {joint}: {difference}, not {}", gradient[joint]);
        }
    }

    /// No point of a shape moves further than its levers say, and none leaves its chord further than their bend.
    #[test]
    fn levers_bound_the_way_of_each_point_and_how_it_bends(
        robot in robot(),
        posture in prop::collection::vec(-1.0..1.0_f64, 8),
        step in prop::collection::vec(-0.5..0.5_f64, 8),
        picked in prop::array::uniform2(any::<prop::sample::Index>()),
        shares in prop::array::uniform2(0.0..1.0_f64),
    ) {
        let n = robot.joint_count();
        let model = robot.collision().unwrap();
        let [a, b] = picked.map(|index| index.index(n));
        let common = revprio_robot::collision::last_common(&robot, model.joint(a), model.joint(b));
        let found = levers(&robot, model, a, Some(b));
        let apart = |share: f64| {
            let q: Vec<f64> = (0..n).map(|j| posture[j] + share * step[j]).collect();
            point(&robot, &q, a, shares[0], common) - point(&robot, &q, b, shares[1], common)
        };
        let way: Vec<f64> = step[..n].iter().map(|step| step.abs()).collect();
        let (start, end) = (apart(0.0), apart(1.0));
        for k in 0..=10 {
            let share = f64::from(k) / 10.0;
            let at = apart(share);
            prop_assert!((at - start).norm() <= found.way(&way) + 1e-12);
            let chord = start + (end - start) * share;
            prop_assert!((at - chord).norm() <= found.bend(&way) + 1e-12, "{} m, not {}", (at - chord).norm(), found.bend(&way));
        }
    }
}

//! Tasks of any link, seen from any other one.

use nalgebra::{DVector, IsometryMatrix3, Vector3};
use proptest::prelude::*;
use revprio_robot::kinematics::{
    Axis, AxisSelection, BodyFrame, Configuration, Frame, TaskBody, TaskFrame, orientation_error,
};

use super::any_tree::{AnyTree, any_tree};

fn transform(entries: [f64; 6]) -> IsometryMatrix3<f64> {
    let [x, y, z, a, b, c] = entries;
    IsometryMatrix3::new(Vector3::new(x, y, z), Vector3::new(a, b, c))
}

/// A tree, and the frame of a task on one of its links, seen from the base or from another link.
fn any_task() -> impl Strategy<Value = (AnyTree, TaskFrame)> {
    let six = || prop::array::uniform6(-0.5..0.5_f64).prop_map(transform);
    let links = (0..1000_usize, 0..1000_usize, prop::bool::ANY);
    let frame = prop_oneof![Just(Frame::Base), Just(Frame::Tool), six().prop_map(Frame::Fixed)];
    (any_tree(), links, six(), six(), frame, prop::array::uniform3(-0.3..0.3_f64)).prop_map(
        |(tree, (link, observer, is_relative), offset, seen_from, frame, point)| {
            let body = BodyFrame { link: tree.link(link), offset };
            let observer = BodyFrame { link: tree.link(observer), offset: seen_from };
            let body = TaskBody { body, relative_to: is_relative.then_some(observer) };
            let frame = TaskFrame { body: Some(body), frame, reference_point: point.into() };
            (tree, frame)
        },
    )
}

fn at(tree: &AnyTree, step: f64) -> Configuration {
    Configuration::new(&tree.robot, &tree.moved(step)).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_pose_is_that_of_the_body_in_the_frame_that_sees_it((tree, frame) in any_task()) {
        let (configuration, body) = (at(&tree, 0.0), frame.body.unwrap());
        let placed = |frame: BodyFrame| configuration.link_pose(frame.link) * frame.offset;
        let expected = body.relative_to.map_or_else(IsometryMatrix3::identity, placed).inv_mul(&placed(body.body));
        let error = (frame.body_pose(&configuration).to_homogeneous() - expected.to_homogeneous()).amax();
        prop_assert!(error < 1e-13, "off by {error:e}");
    }

    /// The rows times q̇ are the rate of the pose at the reference point, along the axes of the task.
    #[test]
    fn the_rows_are_the_rate_of_the_pose((tree, frame) in any_task()) {
        let (h, configuration) = (1e-5, at(&tree, 0.0));
        let pose = |step: f64| frame.pose(&frame.body_pose(&at(&tree, step)));
        let (before, after) = (pose(-h), pose(h));
        let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
        let angular = orientation_error(&after.rotation, &before.rotation) / (2.0 * h);
        let placed = frame.at(&configuration);
        let expected = placed.components(linear, angular);

        let velocity = DVector::from_row_slice(&tree.joint_velocity);
        let twist = placed.body_twist(&tree.joint_velocity).unwrap();
        let whole = placed.jacobian().as_ref() * &velocity;
        let axes = AxisSelection::new(&[Axis::Rz, Axis::X, Axis::Y]).unwrap();
        let mut rows = nalgebra::DMatrix::repeat(3, velocity.len(), f64::NAN);
        placed.write_rows(&axes, &mut rows);
        let selected = rows * velocity;
        for (row, expected) in expected.into_iter().enumerate() {
            prop_assert!((twist[row] - expected).abs() < 1e-7, "row {row}: {} and {expected}", twist[row]);
            prop_assert!((whole[row] - twist[row]).abs() < 1e-12);
        }
        for (row, axis) in axes.axes().iter().enumerate() {
            prop_assert!((selected[row] - whole[axis.index()]).abs() < 1e-12);
        }
    }

    /// The Jacobian of the origin of a joint's frame is the rate of its position.
    #[test]
    fn origins_of_joints_move_with_the_joints_above_them(tree in any_tree()) {
        let (h, configuration) = (1e-5, at(&tree, 0.0));
        for joint in 0..tree.robot.joint_count() {
            let moved = (at(&tree, h).joint_origin(joint) - at(&tree, -h).joint_origin(joint)) / (2.0 * h);
            let columns = configuration.joint_origin_jacobian(joint);
            let rate: Vector3<f64> = columns.zip(&tree.joint_velocity).map(|(column, speed)| column * *speed).sum();
            // The frame of a prismatic joint slides along its axis, which the joint itself moves.
            let own = tree.robot.moving_joints().iter().find(|moving| !moving.is_mimic && moving.coordinate == joint);
            if own.is_none_or(|own| own.kind.is_translation()) {
                continue;
            }
            prop_assert!((moved - rate).amax() < 1e-7, "joint {joint}: {moved:?} and {rate:?}");
        }
    }
}

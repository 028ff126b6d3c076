//! Poses, Jacobians and twists of all links of random trees.

use nalgebra::{DVector, IsometryMatrix3, Point3, Vector3};
use proptest::prelude::*;
use revprio_robot::kinematics::{Configuration, Jacobian, LinkPoint, link_frames, orientation_error};
use revprio_robot::{LinkId, RobotModel, TreeDescription, TreeJoint};

use super::any_tree::{AnyTree, any_tree};

fn at(tree: &AnyTree) -> Configuration {
    Configuration::new(&tree.robot, &tree.joint_position).unwrap()
}

fn jacobian(configuration: &Configuration, point: &LinkPoint) -> Jacobian {
    let mut jacobian = Jacobian::repeat(configuration.joint_position().len(), f64::NAN);
    configuration.write_point_jacobian(point, &mut jacobian);
    jacobian
}

fn difference(a: &IsometryMatrix3<f64>, b: &IsometryMatrix3<f64>) -> f64 {
    (a.to_homogeneous() - b.to_homogeneous()).amax()
}

/// A tree, two of its links, and a point.
fn any_pair() -> impl Strategy<Value = (AnyTree, LinkPoint)> {
    let point = prop::array::uniform3(-0.5..0.5_f64);
    (any_tree(), 0..1000_usize, 0..1000_usize, point).prop_map(|(tree, link, observer, point)| {
        let point = LinkPoint::new(tree.link(link), point.into()).relative_to(tree.link(observer));
        (tree, point)
    })
}

/// Returns the twist of a point along the base axes by central differences of its pose seen from the observer.
fn twist_by_differences(tree: &AnyTree, point: &LinkPoint) -> [f64; 6] {
    // Truncation error h² and rounding error are both near 1e-10 for robots of a few metres.
    let h = 1e-5;
    let seen = |step: f64| {
        let poses = tree.poses(&tree.moved(step));
        poses[tree.name(point.relative_to)].inv_mul(&poses[tree.name(point.link)])
    };
    let (before, after) = (seen(-h), seen(h));
    let place = |pose: &IsometryMatrix3<f64>| (pose * Point3::from(point.point)).coords;
    let observer = tree.poses(&tree.joint_position)[tree.name(point.relative_to)].rotation;
    let linear = observer * ((place(&after) - place(&before)) / (2.0 * h));
    let angular = observer * (orientation_error(&after.rotation, &before.rotation) / (2.0 * h));
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// Returns the joints from the base to a link.
fn path(tree: &AnyTree, link: LinkId) -> Vec<TreeJoint> {
    let ancestors = std::iter::successors(Some(link), |link| tree.robot.links()[link.index()].parent);
    let above = |link| tree.description.joints.iter().find(|joint| joint.child == tree.name(link)).cloned();
    let mut joints: Vec<TreeJoint> = ancestors.filter_map(above).collect();
    joints.reverse();
    joints
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn poses_of_all_links_are_the_products_of_their_transforms(tree in any_tree()) {
        let (configuration, poses) = (at(&tree), tree.poses(&tree.joint_position));
        prop_assert_eq!(tree.robot.links().len(), poses.len());
        for link in tree.robot.links() {
            let pose = configuration.link_pose(tree.robot.link(&link.name).unwrap());
            let error = difference(&pose, &poses[&link.name]);
            prop_assert!(error < 1e-13, "{} is off by {error:e}", link.name);
        }
    }

    #[test]
    fn the_first_tip_is_the_tool(tree in any_tree()) {
        let (configuration, tip) = (at(&tree), &tree.robot.tips()[0]);
        prop_assert!(difference(&configuration.tip_pose(tip), configuration.tool_pose()) < 1e-13);
        let point = LinkPoint::new(tip.link, tip.offset.translation.vector);
        prop_assert!((jacobian(&configuration, &point) - configuration.jacobian()).amax() < 1e-13);
        let twist = configuration.twist(&tree.joint_velocity);
        let expected = configuration.point_twist(&point, &tree.joint_velocity);
        prop_assert!(twist.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn twists_of_points_seen_from_any_link_match_finite_differences((tree, point) in any_pair()) {
        let twist = DVector::from_row_slice(&at(&tree).point_twist(&point, &tree.joint_velocity));
        let error = (twist - DVector::from_row_slice(&twist_by_differences(&tree, &point))).amax();
        prop_assert!(error < 1e-7, "off by {error:e}");
    }

    #[test]
    fn the_twist_is_the_jacobian_times_the_joint_velocity((tree, point) in any_pair()) {
        let configuration = at(&tree);
        let product = jacobian(&configuration, &point) * DVector::from_row_slice(&tree.joint_velocity);
        let twist = DVector::from_row_slice(&configuration.point_twist(&point, &tree.joint_velocity));
        prop_assert!((product - twist).amax() < 1e-12);
    }

    #[test]
    fn a_relative_jacobian_is_the_difference_of_two((tree, point) in any_pair()) {
        let configuration = at(&tree);
        let from_base = point.relative_to(LinkId::BASE);
        let place = configuration.point_pose(&from_base).translation.vector;
        let observer = configuration.link_pose(point.relative_to);
        let carried = LinkPoint::new(point.relative_to, observer.inverse_transform_point(&place.into()).coords);
        let expected = jacobian(&configuration, &from_base) - jacobian(&configuration, &carried);
        prop_assert!((jacobian(&configuration, &point) - expected).amax() < 1e-12);
        let seen = observer.inv_mul(&configuration.point_pose(&from_base));
        prop_assert!(difference(&configuration.point_pose(&point), &seen) < 1e-14);
    }

    #[test]
    fn a_link_does_not_move_seen_from_itself(tree in any_tree(), link in 0..1000_usize) {
        let link = tree.link(link);
        let point = LinkPoint::new(link, Vector3::new(0.1, 0.2, 0.3)).relative_to(link);
        prop_assert_eq!(jacobian(&at(&tree), &point).amax(), 0.0);
    }

    #[test]
    fn the_tool_of_a_tree_is_that_of_the_serial_chain_which_leads_to_it(tree in any_tree()) {
        let mut joints = path(&tree, tree.robot.tips()[0].link);
        joints.iter_mut().filter_map(|joint| joint.motion.as_mut()).for_each(|motion| motion.mimic = None);
        let TreeDescription { base, tips, .. } = tree.description.clone();
        let chain = RobotModel::from_tree("chain", "", &TreeDescription { base, joints, tips }).unwrap();
        let moving = |name: &str| tree.robot.moving_joints().iter().find(|joint| joint.name == name).unwrap();
        let positions: Vec<f64> =
            chain.joints().iter().map(|joint| moving(&joint.name).position(&tree.joint_position)).collect();
        let (serial, whole) = (Configuration::new(&chain, &positions).unwrap(), at(&tree));
        prop_assert!(difference(serial.tool_pose(), whole.tool_pose()) < 1e-13);
        let mut expected = Jacobian::zeros(tree.robot.joint_count());
        for (joint, column) in chain.joints().iter().zip(serial.jacobian().column_iter()) {
            let joint = moving(&joint.name);
            let mut sum = expected.column_mut(joint.coordinate);
            sum += column * joint.multiplier;
        }
        prop_assert!((whole.jacobian() - expected).amax() < 1e-13);
        prop_assert!((chain.reach() - tree.robot.reach()).abs() < 1e-13);
    }

    #[test]
    fn an_update_gives_the_bits_of_a_new_configuration((tree, point) in any_pair()) {
        let mut configuration = Configuration::new(&tree.robot, &tree.moved(1.0)).unwrap();
        configuration.update(&tree.robot, &tree.joint_position).unwrap();
        prop_assert_eq!(&configuration, &at(&tree));
        prop_assert_eq!(jacobian(&configuration, &point), jacobian(&at(&tree), &point));
    }

    #[test]
    fn frames_of_joints_with_a_coordinate_are_at_their_origins(tree in any_tree()) {
        let (configuration, frames) = (at(&tree), link_frames(&tree.robot, &tree.joint_position).unwrap());
        prop_assert_eq!(frames.len(), tree.robot.joint_count());
        for (i, frame) in frames.iter().enumerate() {
            let z = frame.rotation * Vector3::z();
            let away = frame.translation.vector - configuration.joint_origin(i);
            prop_assert!((away - z * z.dot(&away)).amax() < 1e-13, "joint {i}");
        }
    }

    #[test]
    fn a_tool_offset_moves_the_tool_alone(tree in any_tree(), shift in prop::array::uniform3(-0.5..0.5_f64)) {
        let offset = IsometryMatrix3::new(shift.into(), Vector3::new(0.3, -0.2, 0.1));
        let moved = std::sync::Arc::new(tree.robot.clone()).with_tool_offset(&offset).unwrap();
        let mut configuration = at(&tree);
        let expected = configuration.tool_pose() * offset;
        let link = configuration.link_pose(tree.link(900));
        configuration.update(&moved, &tree.joint_position).unwrap();
        prop_assert!(difference(configuration.tool_pose(), &expected) < 1e-13);
        prop_assert!(difference(&configuration.tip_pose(&moved.tips()[0]), &expected) < 1e-13);
        prop_assert!(difference(&configuration.link_pose(tree.link(900)), &link) < 1e-13);
    }
}

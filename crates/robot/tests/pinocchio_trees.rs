//! Two arms and a humanoid's upper body compared with Pinocchio (fixtures/golden/README.md).

use nalgebra::{Matrix3, Vector3};
use revprio_robot::kinematics::{Configuration, Jacobian, LinkPoint};
use revprio_robot::{LinkId, RobotModel, UrdfTreeOptions};

/// Maximum deviation of positions (m), rotation matrices and Jacobians.
const TOLERANCE: f64 = 1e-12;

/// Compares each number of a golden file; returns the largest deviation.
struct Comparison<'a> {
    expected: std::vec::IntoIter<f64>,
    configuration: &'a Configuration,
    largest: f64,
}

impl Comparison<'_> {
    fn next<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|_| self.expected.next().unwrap())
    }

    fn pose(&mut self, point: &LinkPoint) {
        let pose = self.configuration.point_pose(point);
        let (position, rotation) = (Vector3::from(self.next::<3>()), Matrix3::from_row_slice(&self.next::<9>()));
        self.largest = self.largest.max((pose.translation.vector - position).amax());
        self.largest = self.largest.max((pose.rotation.matrix() - rotation).amax());
    }

    fn jacobian(&mut self, point: &LinkPoint) {
        let n = self.configuration.joint_position().len();
        let mut jacobian = Jacobian::zeros(n);
        self.configuration.write_point_jacobian(point, &mut jacobian);
        let expected: Vec<f64> = self.expected.by_ref().take(6 * n).collect();
        self.largest = self.largest.max((jacobian - Jacobian::from_row_slice(&expected)).amax());
    }
}

/// Asserts that poses and Jacobians of points of links are those of Pinocchio, and the last Jacobian that of the first
/// point seen from the link of the second one.
fn assert_equals_pinocchio(urdf: &str, golden: &str, joints: usize, points: &[(&str, [f64; 3])]) -> RobotModel {
    let robot = RobotModel::from_urdf_tree(urdf, &UrdfTreeOptions::default()).unwrap();
    let link = |name: &str| robot.link(name).unwrap();
    let points: Vec<LinkPoint> =
        points.iter().map(|(name, point)| LinkPoint::new(link(name), (*point).into())).collect();
    assert_eq!((robot.joint_count(), golden.lines().count()), (joints, 100));
    let mut configuration = Configuration::new(&robot, &vec![0.0; joints]).unwrap();
    let mut largest = 0.0_f64;
    for line in golden.lines() {
        let mut numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let expected = numbers.split_off(joints);
        configuration.update(&robot, &numbers).unwrap();
        let mut comparison = Comparison { expected: expected.into_iter(), configuration: &configuration, largest };
        for point in &points {
            comparison.pose(point);
            comparison.jacobian(point);
        }
        comparison.jacobian(&points[0].relative_to(points[1].link));
        assert_eq!(comparison.expected.len(), 0);
        largest = comparison.largest;
    }
    println!("{}: largest deviation {largest:e}", robot.name());
    assert!(largest <= TOLERANCE, "{} is off by {largest:e}", robot.name());
    robot
}

#[test]
fn two_arms_with_14_joints_equal_pinocchio() {
    let robot = assert_equals_pinocchio(
        include_str!("../../../fixtures/golden/two_arms.urdf"),
        include_str!("../../../fixtures/golden/pinocchio/two_arms.csv"),
        14,
        &[("left_tool", [0.0; 3]), ("right_tool", [0.1, -0.2, 0.05]), ("left_link_4", [-0.03, 0.02, 0.1])],
    );
    let tips: Vec<&str> = robot.tips().iter().map(|tip| tip.name.as_str()).collect();
    assert_eq!(tips, ["left_tool", "right_tool"]);
}

#[test]
fn the_upper_body_of_a_humanoid_with_mimic_joints_equals_pinocchio() {
    let robot = assert_equals_pinocchio(
        include_str!("../../../fixtures/golden/upper_body.urdf"),
        include_str!("../../../fixtures/golden/pinocchio/upper_body.csv"),
        22,
        &[
            ("left_hand", [0.0; 3]),
            ("right_thumb", [0.02, 0.01, -0.03]),
            ("left_finger_tip", [0.03, 0.0, 0.0]),
            ("camera", [0.0; 3]),
        ],
    );
    let tips: Vec<&str> = robot.tips().iter().map(|tip| tip.name.as_str()).collect();
    assert_eq!((tips, robot.moving_joints().len()), (vec!["left_hand", "right_hand"], 26));
    assert_eq!(robot.links()[LinkId::BASE.index()].name, "pelvis");
}

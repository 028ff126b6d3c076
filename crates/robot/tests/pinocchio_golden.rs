//! The URDF robots compared with Pinocchio (fixtures/golden/README.md), and the two descriptions of Sawyer with each
//! other.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix3, Vector3};
use revprio_robot::kinematics::{Configuration, Jacobian};
use revprio_robot::{RobotModel, UrdfOptions, built_in};

/// Maximum deviation of positions (m), rotation matrices and Jacobians.
const TOLERANCE: f64 = 1e-12;

/// The map q_dh = s q_urdf + o between the two descriptions of Sawyer.
const SIGN: [f64; 7] = [1.0, -1.0, 1.0, 1.0, 1.0, -1.0, 1.0];
const OFFSET: [f64; 7] = [PI, -FRAC_PI_2, PI, 0.0, PI, 0.0, 0.0];

struct Posture {
    q: Vec<f64>,
    position: Vector3<f64>,
    rotation: Matrix3<f64>,
    jacobian: Jacobian,
}

/// Reads the lines of a golden file: q, position, rotation and Jacobian row by row.
fn postures(text: &str, joints: usize) -> Vec<Posture> {
    let posture = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        assert_eq!(numbers.len(), joints + 12 + 6 * joints);
        let (q, rest) = numbers.split_at(joints);
        let (tool, jacobian) = rest.split_at(12);
        Posture {
            q: q.to_vec(),
            position: Vector3::from_column_slice(&tool[..3]),
            rotation: Matrix3::from_row_slice(&tool[3..]),
            jacobian: Jacobian::from_row_slice(jacobian),
        }
    };
    let postures: Vec<Posture> = text.lines().map(posture).collect();
    assert_eq!(postures.len(), 1000);
    postures
}

/// Returns the largest deviation of the robot from the postures; q → s q + o maps their joints to those of the robot.
fn deviation(robot: &RobotModel, postures: &[Posture], sign: &[f64], offset: &[f64]) -> f64 {
    let deviation_at = |posture: &Posture| {
        let q: Vec<f64> = posture.q.iter().zip(sign).zip(offset).map(|((q, s), o)| s * q + o).collect();
        let ours = Configuration::new(robot, &q).unwrap();
        let mut jacobian = ours.jacobian().clone();
        for (mut column, s) in jacobian.column_iter_mut().zip(sign) {
            column *= *s;
        }
        let position = (ours.tool_pose().translation.vector - posture.position).amax();
        let rotation = (ours.tool_pose().rotation.matrix() - posture.rotation).amax();
        position.max(rotation).max((jacobian - &posture.jacobian).amax())
    };
    postures.iter().map(deviation_at).fold(0.0, f64::max)
}

fn robot(name: &str) -> &'static RobotModel {
    built_in().iter().find(|robot| robot.name() == name).unwrap()
}

fn assert_equals_pinocchio(robot: &RobotModel, golden: &str) {
    let n = robot.joint_count();
    let worst = deviation(robot, &postures(golden, n), &vec![1.0; n], &vec![0.0; n]);
    assert!(worst <= TOLERANCE, "{} is off by {worst:e}", robot.name());
}

const SAWYER: &str = include_str!("../../../fixtures/golden/pinocchio/sawyer.csv");

#[test]
fn built_in_urdf_robots_equal_pinocchio() {
    for (name, golden) in [
        ("sawyer", SAWYER),
        ("ur5e", include_str!("../../../fixtures/golden/pinocchio/ur5e.csv")),
        ("panda", include_str!("../../../fixtures/golden/pinocchio/panda.csv")),
        ("planar_3r", include_str!("../../../fixtures/golden/pinocchio/planar_3r.csv")),
    ] {
        assert_equals_pinocchio(robot(name), golden);
    }
}

#[test]
fn oblique_axes_of_every_joint_type_equal_pinocchio() {
    let text = include_str!("../../../fixtures/golden/oblique.urdf");
    let options = UrdfOptions { tip: Some("tool"), ..UrdfOptions::default() };
    let oblique = RobotModel::from_urdf(text, &options).unwrap();
    assert_equals_pinocchio(&oblique, include_str!("../../../fixtures/golden/pinocchio/oblique.csv"));
}

#[test]
fn sawyer_of_table_1_equals_the_manufacturers_description_under_the_map() {
    let golden = postures(SAWYER, 7);
    let worst = deviation(robot("sawyer_dh"), &golden, &SIGN, &OFFSET);
    assert!(worst <= TOLERANCE, "off by {worst:e}");
    let unmapped = deviation(robot("sawyer_dh"), &golden, &SIGN, &[0.0; 7]);
    assert!(unmapped > 0.1, "the map must matter");
}

#[test]
fn limits_of_both_sawyers_are_the_same_under_the_map() {
    for (i, (urdf, dh)) in robot("sawyer").joints().iter().zip(robot("sawyer_dh").joints()).enumerate() {
        assert_eq!(urdf.name, format!("right_j{i}"));
        let mut range = [urdf.limits.lower, urdf.limits.upper].map(|q| SIGN[i] * q + OFFSET[i]);
        range.sort_by(f64::total_cmp);
        assert!((dh.limits.lower - range[0]).abs() <= TOLERANCE && (dh.limits.upper - range[1]).abs() <= TOLERANCE);
        assert_eq!((urdf.limits.velocity, urdf.limits.acceleration), (dh.limits.velocity, dh.limits.acceleration));
    }
}

#[test]
fn every_built_in_robot_has_all_limits_and_a_unique_name() {
    for (i, robot) in built_in().iter().enumerate() {
        assert!(built_in()[..i].iter().all(|other| other.name() != robot.name()));
        for joint in robot.joints() {
            let limits = joint.limits;
            let turns_without_end =
                robot.name() == "gen3" && ["joint_1", "joint_3", "joint_5", "joint_7"].contains(&joint.name.as_str());
            let range = [limits.lower, limits.upper];
            assert!(
                range.iter().all(|limit| limit.is_finite() != turns_without_end),
                "{} {}",
                robot.name(),
                joint.name
            );
            let all = [limits.velocity, limits.acceleration];
            assert!(all.iter().all(|limit| limit.is_finite()), "{} {}", robot.name(), joint.name);
        }
    }
}

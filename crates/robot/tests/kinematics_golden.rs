//! Forward kinematics and Jacobian compared with an independent program (fixtures/golden/README.md), with textbook
//! matrices, with finite differences, and with results by hand.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix4, Rotation3, Vector3};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use revprio_robot::kinematics::{Configuration, Jacobian};
use revprio_robot::{JointKind, RobotModel, built_in, from_json, from_toml};
use serde::Deserialize;
use serde_json::json;

#[derive(Deserialize)]
struct Golden {
    postures: Vec<Posture>,
}

#[derive(Deserialize)]
struct Posture {
    q: Vec<f64>,
    tool: Vec<Vec<f64>>,
    jacobian: Vec<Vec<f64>>,
}

fn at(robot: &RobotModel, q: &[f64]) -> Configuration {
    Configuration::new(robot, q).unwrap()
}

#[test]
fn pose_and_jacobian_equal_the_independent_program() {
    let golden: Golden = serde_json::from_str(include_str!("../../../fixtures/golden/kinematics.json")).unwrap();
    assert_eq!(golden.postures.len(), 50);
    let (mut pose_error, mut jacobian_error) = (0.0_f64, 0.0_f64);
    for posture in &golden.postures {
        let configuration = at(&built_in()[0], &posture.q);
        let tool = Matrix4::from_fn(|i, j| posture.tool[i][j]);
        let jacobian = Jacobian::from_fn(7, |i, j| posture.jacobian[i][j]);
        pose_error = pose_error.max((configuration.tool_pose().to_homogeneous() - tool).amax());
        jacobian_error = jacobian_error.max((configuration.jacobian() - jacobian).amax());
    }
    println!("largest deviation: pose {pose_error:e}, Jacobian {jacobian_error:e}");
    assert!(pose_error <= 1e-13, "pose off by {pose_error:e}");
    assert!(jacobian_error <= 1e-12, "Jacobian off by {jacobian_error:e}");
}

/// One row of Denavit-Hartenberg parameters.
#[derive(Debug, Clone)]
struct Link {
    prismatic: bool,
    d: f64,
    a: f64,
    alpha: f64,
    theta: f64,
}

impl Link {
    /// Returns the matrix as textbooks print it.
    fn matrix(&self, q: f64) -> Matrix4<f64> {
        let (d, theta) = if self.prismatic { (self.d + q, self.theta) } else { (self.d, self.theta + q) };
        let ((s, c), (sa, ca)) = (theta.sin_cos(), self.alpha.sin_cos());
        Matrix4::new(
            c,
            -s * ca,
            s * sa,
            self.a * c, //
            s,
            c * ca,
            -c * sa,
            self.a * s, //
            0.0,
            sa,
            ca,
            d, //
            0.0,
            0.0,
            0.0,
            1.0,
        )
    }
}

fn robot(links: &[Link]) -> RobotModel {
    let joint = |(i, link): (usize, &Link)| {
        let kind = if link.prismatic { "prismatic" } else { "revolute" };
        let dh = json!({ "d": link.d, "a": link.a, "alpha": link.alpha, "theta": link.theta });
        json!({ "name": format!("j{}", i + 1), "kind": kind, "dh": dh })
    };
    let joints: Vec<_> = links.iter().enumerate().map(joint).collect();
    from_json(&json!({ "name": "random", "joints": joints }).to_string()).unwrap()
}

fn any_link() -> impl Strategy<Value = Link> {
    (prop::bool::ANY, -0.5..0.5, -0.5..0.5, -PI..PI, -PI..PI).prop_map(|(prismatic, d, a, alpha, theta)| Link {
        prismatic,
        d,
        a,
        alpha,
        theta,
    })
}

/// 1 to 10 links, with a position and a velocity for each joint.
fn any_arm() -> impl Strategy<Value = (Vec<Link>, Vec<f64>, Vec<f64>)> {
    let joint = (any_link(), -3.0..3.0_f64, -2.0..2.0_f64);
    prop::collection::vec(joint, 1..=10).prop_map(|joints| {
        let (links, motion): (Vec<_>, Vec<_>) = joints.into_iter().map(|(link, q, v)| (link, (q, v))).unzip();
        let (q, v) = motion.into_iter().unzip();
        (links, q, v)
    })
}

/// Returns the rotation vector of a small rotation from the sine in its skew-symmetric part.
fn small_rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let skew = (rotation.matrix() - rotation.matrix().transpose()) / 2.0;
    let sine = Vector3::new(skew[(2, 1)], skew[(0, 2)], skew[(1, 0)]);
    if sine.norm() == 0.0 { sine } else { sine * (sine.norm().asin() / sine.norm()) }
}

/// Returns the twist by central differences of the pose, (x(q + h v) − x(q − h v)) / 2h.
fn twist_by_differences(robot: &RobotModel, q: &[f64], v: &[f64]) -> [f64; 6] {
    // Truncation error h² and rounding error are both near 1e-10 for arms of a few metres.
    let h = 1e-5;
    let moved = |step: f64| {
        let q: Vec<f64> = q.iter().zip(v).map(|(q, v)| q + step * v).collect();
        *at(robot, &q).tool_pose()
    };
    let (before, after) = (moved(-h), moved(h));
    let linear = (after.translation.vector - before.translation.vector) / (2.0 * h);
    let angular = small_rotation_vector(&(after.rotation * before.rotation.inverse())) / (2.0 * h);
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Returns the largest deviation of any column from central differences.
fn jacobian_error(robot: &RobotModel, q: &[f64]) -> f64 {
    let jacobian = at(robot, q).jacobian().clone();
    let column = |i: usize| {
        let unit: Vec<f64> = (0..q.len()).map(|j| f64::from(u8::from(i == j))).collect();
        largest_difference(jacobian.column(i).as_slice(), &twist_by_differences(robot, q, &unit))
    };
    (0..q.len()).map(column).fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::with_cases(500)
    })]

    #[test]
    fn sawyer_jacobian_matches_finite_differences(q in prop::collection::vec(-PI..PI, 7)) {
        let error = jacobian_error(&built_in()[0], &q);
        prop_assert!(error < 1e-9, "off by {error:e}");
    }

    #[test]
    fn jacobian_of_any_arm_matches_finite_differences((links, q, _) in any_arm()) {
        let error = jacobian_error(&robot(&links), &q);
        prop_assert!(error < 1e-8, "off by {error:e}");
    }

    #[test]
    fn twist_is_the_jacobian_times_the_joint_velocity((links, q, v) in any_arm()) {
        let robot = robot(&links);
        let configuration = at(&robot, &q);
        let product = configuration.jacobian() * nalgebra::DVector::from_row_slice(&v);
        let twist = configuration.twist(&v);
        prop_assert!(largest_difference(product.as_slice(), &twist) < 1e-12);
        let error = largest_difference(&twist_by_differences(&robot, &q, &v), &twist);
        prop_assert!(error < 1e-7, "off by {error:e}");
    }

    #[test]
    fn pose_of_any_arm_is_the_product_of_textbook_matrices((links, q, _) in any_arm()) {
        let product = links.iter().zip(&q).fold(Matrix4::identity(), |pose, (link, &q)| pose * link.matrix(q));
        let error = (at(&robot(&links), &q).tool_pose().to_homogeneous() - product).amax();
        prop_assert!(error < 1e-13, "off by {error:e}");
    }
}

fn revolute(a: f64, theta: f64) -> Link {
    Link { prismatic: false, d: 0.0, a, alpha: 0.0, theta }
}

fn assert_pose_and_jacobian(robot: &RobotModel, q: &[f64], position: [f64; 3], columns: &[[f64; 6]]) {
    let configuration = at(robot, q);
    let tool = configuration.tool_pose().translation.vector;
    assert!(largest_difference(tool.as_slice(), &position) < 1e-15, "{tool}");
    assert_eq!(configuration.jacobian().ncols(), columns.len());
    for (i, column) in columns.iter().enumerate() {
        let computed = configuration.jacobian().column(i);
        assert!(largest_difference(computed.as_slice(), column) < 1e-15, "column {i}: {computed}");
    }
}

#[test]
fn a_planar_arm_bent_at_a_right_angle_has_the_expected_pose_and_jacobian() {
    // Upper arm 1 m straight up along y, forearm 0.5 m to the right along x.
    let columns = [[-1.0, 0.5, 0.0, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 0.0, 0.0, 1.0]];
    let plain = robot(&[revolute(1.0, 0.0), revolute(0.5, 0.0)]);
    assert_pose_and_jacobian(&plain, &[FRAC_PI_2, -FRAC_PI_2], [0.5, 1.0, 0.0], &columns);
    assert!((at(&plain, &[FRAC_PI_2, -FRAC_PI_2]).tool_pose().rotation.angle()).abs() < 1e-7);
    let offset = robot(&[revolute(1.0, FRAC_PI_2), revolute(0.5, -FRAC_PI_2)]);
    assert_pose_and_jacobian(&offset, &[0.0, 0.0], [0.5, 1.0, 0.0], &columns);
}

#[test]
fn a_telescope_on_a_turntable_has_the_expected_pose_and_jacobian() {
    // α = −90° turns z of the second joint to y of the base. It points at the tool, which is 2 m away.
    let turntable = Link { prismatic: false, d: 0.3, a: 0.0, alpha: -FRAC_PI_2, theta: 0.0 };
    let telescope = Link { prismatic: true, d: 0.5, a: 0.0, alpha: 0.0, theta: 0.0 };
    let columns = [[-2.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0]];
    assert_pose_and_jacobian(&robot(&[turntable, telescope]), &[0.0, 1.5], [0.0, 2.0, 0.3], &columns);
}

#[test]
fn an_arm_may_have_one_joint() {
    let crank = robot(&[revolute(2.0, 0.0)]);
    assert_pose_and_jacobian(&crank, &[FRAC_PI_2], [0.0, 2.0, 0.0], &[[-2.0, 0.0, 0.0, 0.0, 0.0, 1.0]]);
    let slide = robot(&[Link { prismatic: true, ..revolute(2.0, 0.0) }]);
    assert_pose_and_jacobian(&slide, &[0.7], [2.0, 0.0, 0.7], &[[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]]);
}

#[test]
fn sawyer_is_the_same_robot_in_toml_and_in_json() {
    let text = include_str!("../../../fixtures/robots/sawyer_dh.toml");
    let json = toml::from_str::<serde_json::Value>(text).unwrap().to_string();
    let (from_toml, from_json) = (from_toml(text).unwrap(), from_json(&json).unwrap());
    assert_eq!(from_toml, from_json);
    assert_eq!(from_toml, *built_in()[0]);
    assert!(from_json.joints().iter().all(|joint| joint.kind == JointKind::Revolute));
    let q = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
    assert_eq!(at(&from_toml, &q), at(&from_json, &q));
}

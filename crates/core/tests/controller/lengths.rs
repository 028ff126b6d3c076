//! The characteristic length: arms of all sizes behave alike.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use proptest::prelude::*;
use revprio_core::controller::{ControllerConfig, Limits, Measurement, Memory, Stepper, TaskConfig};
use revprio_core::law::{Law, VelocityBounds};
use revprio_core::limits::LimitKind;
use revprio_core::resolution::{Method, Resolution};
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{RobotModel, built_in};

use super::arms::{Random, controller, position, task, tool_rows};

fn enlarged(pose: &IsometryMatrix3<f64>, size: f64) -> IsometryMatrix3<f64> {
    IsometryMatrix3::from_parts((pose.translation.vector * size).into(), pose.rotation)
}

/// Returns a Panda that is `size` times as large.
fn panda(size: f64) -> Arc<RobotModel> {
    let panda = built_in().iter().find(|robot| robot.name() == "panda").unwrap();
    let mut joints = panda.joints().to_vec();
    for joint in &mut joints {
        joint.placement = enlarged(&joint.placement, size);
    }
    Arc::new(RobotModel::new("enlarged", "", joints, enlarged(panda.tool(), size)).unwrap())
}

/// Answers at random postures, half of them nearly outstretched, with targets that are `size` times as far away.
fn answers(size: f64, length: f64, method: Method, seed: u64) -> Vec<Resolution> {
    let robot = panda(size);
    let mut random = Random(seed);
    let mut answers = Vec::new();
    for number in 0..4 {
        let q: Vec<f64> = (0..7)
            .map(|joint| {
                let limits = &robot.joints()[joint].limits;
                let q =
                    f64::midpoint(limits.lower, limits.upper) + 0.4 * (limits.upper - limits.lower) * random.signed();
                if joint == 3 && number % 2 == 0 { -0.08 } else { q }
            })
            .collect();
        let tool = *Configuration::new(&robot, &q).unwrap().tool_pose();
        let away = Vector3::from_fn(|_, _| random.signed()) * size;
        let goal = IsometryMatrix3::from_parts((tool.translation.vector + away).into(), tool.rotation);
        let to_goal = |axes: &[Axis]| {
            let rows = ToolRows { target_pose: TargetPose::Fixed(goal), ..tool_rows(axes) };
            TaskConfig { rows: TaskRows::Tool(rows), ..task(axes, position(axes.len(), 2.0)) }
        };
        let slow = VelocityBounds::new(vec![-0.1 * size], vec![0.1 * size]).unwrap();
        let tasks = vec![
            TaskConfig { name: "slow".to_owned(), ..task(&[Axis::Z], Law::Bounds(slow)) },
            to_goal(&[Axis::X, Axis::Y, Axis::Rz]),
            to_goal(&[Axis::Z, Axis::Rx, Axis::Ry]),
        ];
        let config = ControllerConfig {
            method,
            characteristic_length_m: length,
            limits: Limits::Robot(LimitKind::PositionVelocity),
            ..ControllerConfig::new(Arc::clone(&robot), 0.01, tasks)
        };
        let mut memory: Option<Memory> = None;
        let wrench = [0.0; 6];
        let measured = Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s: 0.0,
            joint_position: q,
            joint_velocity: None,
            wrench,
            targets: Vec::new(),
        };
        let mut stepper = Stepper::new(controller(config)).unwrap();
        answers.push(stepper.step(&mut memory, &measured).unwrap().resolution.clone());
    }
    answers
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// With the characteristic length in proportion, an arm of any size gets the same joint velocities.
    #[test]
    fn arms_of_all_sizes_move_alike(exponent in -6_i32..7, seed: u64, method in 0_usize..4) {
        let methods =
            [Method::ReversePriority, Method::StrictReversePriority, Method::TaskPriority, Method::DampedLeastSquares];
        let (size, method) = (2.0_f64.powi(exponent), methods[method]);
        let rows = [vec![true], vec![true, true, false], vec![true, false, false]];
        for (one, other) in answers(1.0, 1.0, method, seed).iter().zip(answers(size, size, method, seed)) {
            let difference = (&one.joint_velocity - &other.joint_velocity).amax();
            prop_assert!(difference <= 1e-9, "{difference} rad/s, {one:?}, {other:?}");
            prop_assert_eq!(one.active_limits().count(), other.active_limits().count());
            for (rows, (one, other)) in rows.iter().zip(one.tasks.iter().zip(&other.tasks)) {
                for (row, linear) in rows.iter().enumerate() {
                    let unit = if *linear { size } else { 1.0 };
                    prop_assert!((one.achieved[row] * unit - other.achieved[row]).abs() <= 1e-9 * unit);
                }
            }
        }
    }
}

#[test]
fn without_its_length_a_small_arm_is_damped_everywhere() {
    let difference = |length| {
        let pairs = answers(1.0, 1.0, Method::ReversePriority, 3).into_iter().zip(answers(
            0.05,
            length,
            Method::ReversePriority,
            3,
        ));
        pairs.map(|(one, other)| (one.joint_velocity - other.joint_velocity).amax()).fold(0.0, f64::max)
    };
    assert!(difference(1.0) > 0.1 && difference(0.05) < 1e-9, "{} {}", difference(1.0), difference(0.05));
}

#[test]
fn residuals_are_in_the_units_of_the_task() {
    for answer in answers(0.5, 0.2, Method::StrictReversePriority, 1) {
        let [slow, ..] = &answer.tasks[..] else { unreachable!() };
        let outside = (slow.achieved[0].abs() - 0.05).max(0.0);
        assert!((slow.residual_norm - outside).abs() < 1e-12, "{slow:?}");
    }
}

#[test]
fn lengths_must_be_positive_numbers() {
    for length in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let config = ControllerConfig::new(panda(1.0), 0.01, vec![task(&[Axis::X], position(1, 1.0))]);
        let refused =
            revprio_core::controller::Controller::new(ControllerConfig { characteristic_length_m: length, ..config });
        assert!(refused.unwrap_err().to_string().contains("characteristic length"));
    }
}

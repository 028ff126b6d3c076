//! Long chains that start stretched, where every task is at a singular posture.

use std::fmt::Write as _;
use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, Measurement, Stepper, TaskConfig};
use revprio_core::law::{Law, VelocityBounds};
use revprio_core::streaming::{StreamedTarget, StreamedValue, Streaming};
use revprio_robot::kinematics::Axis;
use revprio_robot::{RobotModel, UrdfOptions};

use super::arms::{Random, joint_rows, position, task};

/// T, s.
const PERIOD: f64 = 8e-3;

/// Returns a chain of joints whose axes alternate, stretched at the posture zero.
fn snake(joints: usize) -> Arc<RobotModel> {
    let mut urdf = "<robot name='snake'><link name='l0'/>".to_owned();
    for i in 0..joints {
        let axis = if i % 2 == 1 { "0 1 0" } else { "1 0 0" };
        let _ = write!(
            urdf,
            "<link name='l{}'/><joint name='q{i}' type='revolute'><parent link='l{i}'/><child link='l{}'/><origin xyz='0 0 0.06'/>\
             <axis xyz='{axis}'/><limit lower='-1' upper='1' velocity='2' effort='10' acceleration='8'/></joint>",
            i + 1,
            i + 1
        );
    }
    Arc::new(RobotModel::from_urdf(&(urdf + "</robot>"), &UrdfOptions::default()).unwrap())
}

/// Runs twelve periods, and returns the largest number of working sets and the longest time of a step, ms.
fn run(joints: usize, seed: u64) -> (u32, f64) {
    let (robot, mut random) = (snake(joints), Random(seed));
    let target: Vec<f64> = (0..joints).map(|_| 0.9 * random.signed()).collect();
    let posture = TaskConfig {
        name: "posture".to_owned(),
        rows: joint_rows(&target),
        law: position(joints, 2.0),
        scaled: false,
        streaming: Streaming::default(),
    };
    let slow = Law::Bounds(VelocityBounds::new(vec![-0.01], vec![0.01]).unwrap());
    let tasks = vec![task(&[Axis::X, Axis::Y, Axis::Z], position(3, 2.0)), posture, task(&[Axis::X], slow)];
    let mut stepper = Stepper::new(Controller::new(ControllerConfig::new(robot, PERIOD, tasks)).unwrap()).unwrap();
    let (mut q, mut memory, mut worst) = (vec![0.0; joints], None, (0, 0.0_f64));
    for i in 0..12_u32 {
        let value = StreamedValue::Pose {
            position: Some(Vector3::new(0.5, 0.3, 1.2)),
            orientation: Some(UnitQuaternion::identity()),
        };
        let target = StreamedTarget { task: 0, time_s: 0.0, value, velocity: None, ahead: Vec::new() };
        let measured = Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s: f64::from(i) * PERIOD,
            joint_position: q.clone(),
            joint_velocity: None,
            wrench: [0.0; 6],
            targets: if i == 0 { vec![target] } else { Vec::new() },
        };
        let begin = std::time::Instant::now();
        let command = stepper.step(&mut memory, &measured).unwrap();
        worst.1 = worst.1.max(1e3 * begin.elapsed().as_secs_f64());
        worst.0 = worst.0.max(command.resolution.solver.working_sets);
        q.iter_mut().zip(command.resolution.joint_velocity.iter()).for_each(|(q, v)| *q += PERIOD * v);
    }
    worst
}

/// A joint at its limit without a force may count as held or as free, and working sets repeat until rounding decides it.
#[test]
fn stretched_chains_at_their_limits_need_few_working_sets() {
    let sets = |joints: usize| (0..10).map(|seed| run(joints, seed).0).max();
    assert!(sets(20) <= Some(80) && sets(32) <= Some(90), "{:?} {:?}", sets(20), sets(32));
}

/// Prints the longest steps, for docs/performance.md.
#[test]
#[ignore = "asserts nothing; prints a table of docs/performance.md"]
fn long_chains_table() {
    for joints in [7, 10, 14, 20, 24, 28, 32] {
        let (sets, ms) = (0..10).map(|seed| run(joints, seed)).fold((0, 0.0_f64), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        println!("{joints} joints: {sets} working sets, {ms:.1} ms");
    }
}

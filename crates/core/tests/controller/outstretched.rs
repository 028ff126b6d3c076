//! The default damping, where an arm is stretched out after a target that is out of its reach.

use std::f64::consts::PI;
use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{
    ControllerConfig, JointRows, JointTarget, Measurement, Memory, Stepper, StreamedTarget, StreamedValue, TaskConfig,
    TaskRows,
};
use revprio_core::limits::Drive;
use revprio_core::linalg::Damping;
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{RobotModel, built_in};

use super::arms::{constant, controller, position, task};
use super::drives::LaggingArm;

const HOME: [f64; 7] = [0.0, -PI / 4.0, 0.0, -0.75 * PI, 0.0, PI / 2.0, PI / 4.0];
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
/// T, s.
const PERIOD: f64 = 0.01;
const DRIVE: Drive = Drive { lag_s: 0.02, delay_periods: 1 };
const NOISE: f64 = 1e-4;

/// Moves from 0 to 1 between two times, at rest and without acceleration at both ends.
fn smooth_step(time_s: f64, start_s: f64, end_s: f64) -> f64 {
    let s = ((time_s - start_s) / (end_s - start_s)).clamp(0.0, 1.0);
    s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)
}

/// Returns a displacement of 0.75 m forwards, up and down there, and back: the arm can follow for 0.4 m.
fn displacement(time_s: f64) -> Vector3<f64> {
    let away = smooth_step(time_s, 1.0, 4.0) - smooth_step(time_s, 7.0, 10.0);
    let weave = smooth_step(time_s, 3.5, 4.0) - smooth_step(time_s, 7.0, 7.5);
    Vector3::new(0.75 * away, 0.0, 0.15 * weave * (PI * (time_s - 3.5)).sin())
}

fn panda() -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == "panda").unwrap())
}

/// Returns the largest acceleration of a command as a multiple of the joint's limit, and the distance of the tool from
/// the target at the end, m.
fn run(damping: Damping) -> (f64, f64) {
    let robot = panda();
    let rows = TaskRows::Joints(JointRows { joints: (0..7).collect(), target: JointTarget::Position(constant(&HOME)) });
    let posture = TaskConfig {
        name: "posture".to_owned(),
        rows,
        law: position(7, 1.0),
        scaled: false,
        streaming: Streaming::default(),
    };
    let config = ControllerConfig::new(Arc::clone(&robot), PERIOD, vec![task(&AXES, position(6, 8.0)), posture]);
    let mut stepper =
        Stepper::new(controller(ControllerConfig { drive: DRIVE, damping: Some(damping), ..config })).unwrap();
    let mut memory: Option<Memory> = None;
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, NOISE, 17);
    let start = *Configuration::new(&robot, &HOME).unwrap().tool_pose();
    let limits: Vec<f64> = robot.joints().iter().map(|joint| joint.limits.acceleration).collect();
    let (mut last, mut largest) = (vec![0.0; 7], 0.0_f64);
    for time_s in (0..1200).map(|i| f64::from(i) * PERIOD) {
        let value = StreamedValue::Pose {
            position: Some(start.translation.vector + displacement(time_s)),
            orientation: Some(UnitQuaternion::from_rotation_matrix(&start.rotation)),
        };
        let targets = vec![StreamedTarget { task: 0, time_s, value, velocity: None }];
        let measured = Measurement { targets, ..arm.measure(time_s) };
        let command = stepper.step(&mut memory, &measured).unwrap().resolution.joint_velocity.as_slice().to_vec();
        for ((new, old), limit) in command.iter().zip(&last).zip(&limits) {
            largest = largest.max((new - old).abs() / (PERIOD * limit));
        }
        arm.follow(&command, PERIOD);
        last = command;
    }
    let tool = *Configuration::new(&robot, &arm.q).unwrap().tool_pose();
    (largest, (tool.translation.vector - start.translation.vector).norm())
}

#[test]
fn the_default_damping_keeps_an_outstretched_arm_smooth() {
    let robot = panda();
    let default = ControllerConfig::new(robot, PERIOD, Vec::new()).damping.unwrap();
    let [(default, distance), (paper, _)] = [run(default), run(Damping::STANDARD)];
    println!("largest acceleration / limit: default {default}, damping of the paper {paper}");
    assert!(default < 0.9, "the acceleration reaches {default} of its limit");
    assert!(distance < 1e-3, "the tool is {distance} m from its target");
}

//! After streamed targets stop, no joint goes on moving: the null-space motion rests too.

use nalgebra::{DVector, Vector3};
use revprio_core::controller::{Command, ControllerConfig, Measurement, NullSpaceMotion, Stepper, TaskConfig};
use revprio_core::limits::{Drive, braking_deceleration};
use revprio_core::streaming::{StreamedTarget, StreamedValue};
use revprio_robot::kinematics::{Axis, Configuration};

use super::arms::{NOMINAL, controller, position, sawyer, task};
use super::drives::LaggingArm;

/// Time of the last target before the drop-out, and of the first one after it, s.
const LOST: f64 = 1.5;
const FOUND: f64 = 3.0;

/// Largest speed of a joint at rest, rad/s.
const AT_REST: f64 = 5e-3;

/// What a run shows.
#[derive(Debug)]
struct Findings {
    /// Time from the last target until the commands of all joints rest, s.
    rests_after: f64,
    /// Largest change of a command, in multiples of A T.
    change: f64,
    /// Norm of the part of the command at the last target, and at the end, that no target asks for, rad/s.
    inner_motion: [f64; 2],
}

/// Returns the norm of the joint velocities that the task does not see, rad/s.
fn inner_motion(config: &ControllerConfig, q: &[f64], command: &Command) -> f64 {
    let configuration = Configuration::new(&config.robot, q).unwrap();
    let jacobian = configuration.jacobian().rows(0, 3).into_owned();
    let velocity = DVector::from_column_slice(command.resolution.joint_velocity.as_slice());
    let seen = jacobian.clone().pseudo_inverse(1e-6).unwrap() * (&jacobian * &velocity);
    (velocity - seen).norm()
}

/// Streams a motion with a drop-out to an arm that starts away from the posture that its null-space motion wants.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
fn run(config: &ControllerConfig) -> Findings {
    let (period, robot) = (config.period_s, &config.robot);
    let mut stepper = Stepper::new(controller(config.clone())).unwrap();
    let mut arm = LaggingArm::at_rest(&NOMINAL, config.drive, 0.0, 1);
    let start = Configuration::new(robot, &NOMINAL).unwrap().tool_pose().translation.vector;
    let (mut memory, mut last) = (None, vec![0.0; robot.joint_count()]);
    let mut found = Findings { rests_after: 0.0, change: 0.0, inner_motion: [0.0; 2] };
    let (mut sent, mut moved_at) = (-1.0, 0.0);
    for number in 0..(4.0 / period) as u32 {
        let time_s = f64::from(number) * period;
        let is_due = (!(LOST..FOUND).contains(&time_s) && time_s - sent > 1.0 / 60.0).then(|| sent = time_s);
        let position = start + Vector3::new(0.1 * (3.0 * time_s).sin(), 0.15 * (2.0 * time_s).sin(), 0.0);
        let value = StreamedValue::Pose { position: Some(position), orientation: None };
        let targets = is_due
            .map(|()| StreamedTarget { task: 0, time_s, value, velocity: None, ahead: Vec::new() })
            .into_iter()
            .collect();
        let measured = Measurement { targets, ..arm.measure(time_s) };
        let command = stepper.step(&mut memory, &measured).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice();
        for ((joint, now), last) in robot.joints().iter().zip(velocity).zip(&last) {
            found.change = found.change.max((now - last).abs() / braking_deceleration(&joint.limits) / period);
        }
        if time_s < LOST {
            found.inner_motion[0] = inner_motion(config, &arm.q, command);
        }
        found.inner_motion[1] = inner_motion(config, &arm.q, command);
        if (LOST..FOUND).contains(&time_s) && velocity.iter().any(|speed| speed.abs() > AT_REST) {
            moved_at = time_s;
        }
        last = velocity.to_vec();
        arm.follow(&last, period);
    }
    found.rests_after = moved_at - LOST;
    found
}

fn streamed(gain: f64, period: f64, drive: Drive, motion: Option<NullSpaceMotion>) -> ControllerConfig {
    let hand = TaskConfig { name: "hand".to_owned(), ..task(&[Axis::X, Axis::Y, Axis::Z], position(3, gain)) };
    let default = ControllerConfig::new(sawyer(), period, vec![hand]);
    ControllerConfig { drive, null_space: motion.or(default.null_space.clone()), ..default }
}

#[test]
fn no_joint_moves_after_the_targets_stop_until_they_come_again() {
    let away = NOMINAL.map(|q| q - 0.8).to_vec();
    let motions = [
        None,
        Some(NullSpaceMotion::JointLimits { gain: 2.0 }),
        Some(NullSpaceMotion::Posture { joint_position: away, gain: 2.0 }),
    ];
    let drives = [Drive::IDEAL, Drive::CONSERVATIVE];
    for (number, (period, drive)) in
        [0.001, 0.01].into_iter().flat_map(|period| drives.map(|drive| (period, drive))).enumerate()
    {
        for motion in &motions {
            let gain = [2.0, 8.0][number % 2];
            let found = run(&streamed(gain, period, drive, motion.clone()));
            println!("T {period} s, {drive:?}, {motion:?}, gain {gain}: {found:?}");
            assert!(found.rests_after < 0.55, "{found:?}");
            assert!(found.change < 1.0 + 1e-6, "{found:?}");
            assert!(found.inner_motion.iter().all(|speed| *speed > 2.0 * AT_REST), "nothing to stop: {found:?}");
        }
    }
}

//! Position laws behind a drive with lag and dead time: how closely they follow targets that move.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Vector3;
use revprio_core::controller::{ControllerConfig, Measurement, Stepper, TaskConfig};
use revprio_core::law::Profile;
use revprio_core::limits::Drive;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::{StreamedTarget, StreamedValue};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{JointLimits, RobotModel, built_in};

use super::arms::{config, controller, gantry, joint_rows, position, task, tool_rows};
use super::drives::LaggingArm;

const PERIOD: f64 = 0.01;
const RADIUS: f64 = 0.1;
/// r, m.
const REACH: f64 = 0.5;
const START: [f64; 7] = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];

/// The drive of the arm and the one that the controller states.
const DRIVES: [(&str, Drive, Drive); 3] = [
    ("stated exactly", Drive { lag_s: 0.02, delay_periods: 1 }, Drive { lag_s: 0.02, delay_periods: 1 }),
    ("stated by default", Drive { lag_s: 0.02, delay_periods: 1 }, Drive::CONSERVATIVE),
    ("no lag, stated by default", Drive::IDEAL, Drive::CONSERVATIVE),
];

/// The same arms with laws that do not predict, because they know of no drive.
const WITHOUT_PREDICTION: [(&str, Drive, Drive); 2] = [
    ("lag, no prediction", Drive { lag_s: 0.02, delay_periods: 1 }, Drive::IDEAL),
    ("no lag, no prediction", Drive::IDEAL, Drive::IDEAL),
];

/// How the task gets the circle.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Source {
    /// The profile of the task, with its velocity.
    Profile,
    /// 45 targets per second.
    Stream,
}

fn panda() -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == "panda").unwrap())
}

/// Returns the displacement on the circle that starts at its lowest point with a period (s).
fn circle(time_s: f64, lap: f64) -> Vector3<f64> {
    let angle = TAU * time_s / lap;
    RADIUS * Vector3::new(angle.sin(), 0.0, 1.0 - angle.cos())
}

/// Returns the tasks along x, and along y and z, that follow the circle.
fn tasks(source: Source, gain: f64, lap: f64) -> Vec<TaskConfig> {
    let along = |axes: &[Axis], offset: &[f64], amplitude: &[f64], phase: f64| {
        let sine = Profile::sine(offset.to_vec(), amplitude.to_vec(), TAU / lap, phase).unwrap();
        let displacement = (source == Source::Profile).then_some(sine);
        let rows = TaskRows::Tool(ToolRows { target_displacement: displacement, ..tool_rows(axes) });
        TaskConfig { rows, ..task(axes, position(axes.len(), gain)) }
    };
    vec![
        along(&[Axis::X], &[0.0], &[RADIUS], 0.0),
        along(&[Axis::Y, Axis::Z], &[0.0, RADIUS], &[0.0, RADIUS], -0.5 * PI),
    ]
}

/// Returns the RMS of the distance to the circle's point after the first lap, m.
fn tracking_error(source: Source, gain: f64, lap: f64, drive: Drive, stated: Drive) -> f64 {
    let robot = panda();
    let config = ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks(source, gain, lap));
    let mut stepper = Stepper::new(controller(ControllerConfig { drive: stated, ..config })).unwrap();
    let mut arm = LaggingArm::at_rest(&START, drive, 0.0, 1);
    let place = |q: &[f64]| Configuration::new(&robot, q).unwrap().tool_pose().translation.vector;
    let start = place(&START);
    let (mut memory, mut squares, mut count, mut sent) = (None, 0.0, 0.0, -1.0);
    let mut time_s = 0.0;
    while time_s < 2.0 * lap {
        let due = (time_s * 45.0_f64).floor();
        let is_due = source == Source::Stream && due > sent;
        let target = |task| {
            let position = Some(start + circle(due / 45.0, lap));
            let value = StreamedValue::Pose { position, orientation: None };
            StreamedTarget { task, time_s: due / 45.0, value, velocity: None, ahead: Vec::new() }
        };
        let targets = if is_due { vec![target(0), target(1)] } else { Vec::new() };
        sent = due;
        let measurement = Measurement { targets, ..arm.measure(time_s) };
        if time_s >= lap {
            squares += (place(&arm.q) - start - circle(time_s, lap)).norm_squared();
            count += 1.0;
        }
        let command = stepper.step(&mut memory, &measurement).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
        time_s += PERIOD;
    }
    (squares / count).sqrt()
}

/// Without prediction, the law would be behind by (L + D T + T/2)/K times the acceleration of the target. An arm that is
/// faster than stated gets commands for a posture that it has later: an error of v²/r Δ(L + D T) in velocity, with the
/// distance r of the tool from the joints.
#[test]
fn the_prediction_leaves_the_tool_as_close_to_a_moving_target() {
    for lap in [8.0, 3.0] {
        let acceleration = RADIUS * (TAU / lap).powi(2);
        for (name, drive, stated) in DRIVES {
            for gain in [2.0, 5.0, 10.0, 20.0] {
                let error = tracking_error(Source::Profile, gain, lap, drive, stated);
                let behind = (drive.time_to_rest(PERIOD) + 0.5 * PERIOD) / gain;
                let early = stated.time_to_rest(PERIOD) - drive.time_to_rest(PERIOD);
                let turned = (RADIUS * TAU / lap).powi(2) / REACH * early / gain;
                let bound = turned + acceleration * (behind + 0.5 * stated.time_to_rest(PERIOD).powi(2));
                assert!(error <= bound, "lap of {lap} s, {name}, gain {gain}: {error} m, not {bound} m");
            }
        }
    }
}

/// Returns the largest change of a command in the last 100 of 3000 periods, relative to the first command. A joint without
/// limits moves from 0 to 1 with the gain K = `share`/T; a brake holds it where there is no `drive`.
fn unrest(share: f64, period: f64, stated: Drive, drive: Option<Drive>) -> f64 {
    let robot = gantry(JointLimits::NONE);
    let tasks = vec![TaskConfig { rows: joint_rows(&[1.0; 3]), ..task(&[Axis::X], position(3, share / period)) }];
    let config = ControllerConfig { period_s: period, drive: stated, ..config(&robot, tasks) };
    let mut stepper = Stepper::new(controller(config)).unwrap();
    let mut arm = LaggingArm::at_rest(&[0.0; 3], drive.unwrap_or(Drive::IDEAL), 0.0, 1);
    let (mut memory, mut commands) = (None, Vec::new());
    for i in 0..3000 {
        let command = stepper.step(&mut memory, &arm.measure(f64::from(i) * period)).unwrap();
        commands.push(command.resolution.joint_velocity[0]);
        if drive.is_some() {
            arm.follow(command.resolution.joint_velocity.as_slice(), period);
        }
    }
    let changes = commands[2900..].windows(2).map(|pair| (pair[1] - pair[0]).abs());
    changes.fold(0.0, f64::max) / commands[0]
}

/// Let c = K T, and let M and M̂ be the transfer functions of the drive of the arm and of the stated one. The poles solve
/// z − 1 + c (1 + M − M̂) = 0, and |M̂| ≤ 1 on the unit circle.
///
/// - M = 1, an arm that follows at once: |z − 1 + 2c| ≥ 2 − 2c > c for c < 2/3, so no pole crosses the circle as c grows. A
///   long dead time in M̂ comes close to this bound.
/// - M = 0, an arm that a brake holds: |z − 1 + c| ≥ c for c < 1, with equality at z = 1 alone, where M̂ = 1. With M̂ = z⁻ᴰ
///   the product of all poles is c, so a larger c is unstable.
#[test]
fn gains_below_two_thirds_of_the_rate_become_calm_on_faster_and_on_braked_arms_and_larger_gains_need_not() {
    let stated = [(0.03, 2), (0.0, 2), (0.03, 0), (0.005, 1), (0.0, 10)];
    for (lag_s, delay_periods) in stated {
        let stated = Drive { lag_s, delay_periods };
        for period in [1e-3, 1e-2, 5e-2] {
            for drive in [None, Some(Drive::IDEAL), Some(stated)] {
                for share in [0.1, 0.3, 0.5, 0.65] {
                    let unrest = unrest(share, period, stated, drive);
                    assert!(unrest < 1e-6, "K T = {share}, T = {period} s, {stated:?}, arm {drive:?}: {unrest}");
                }
            }
        }
    }
    let late = |delay_periods| Drive { lag_s: 0.0, delay_periods };
    let unstable = [
        ("an arm that follows at once", 0.7, 10, Some(Drive::IDEAL)),
        ("an arm that follows at once", 0.8, 2, Some(Drive::IDEAL)),
        ("an arm that a brake holds", 1.05, 2, None),
    ];
    for (name, share, delay, drive) in unstable {
        let unrest = unrest(share, 1e-2, late(delay), drive);
        println!("{name}, K T = {share}, stated with {delay} periods: {unrest:.1e} of the first command");
        assert!(unrest > 1.0, "{name}, K T = {share}, stated with {delay} periods: {unrest}");
    }
    for share in [0.9, 1.2, 1.5, 1.9] {
        let unrest = unrest(share, 1e-2, late(2), Some(late(2)));
        assert!(unrest < 1e-6, "K T = {share} with the drive as stated: {unrest}");
    }
}

/// Prints the table of docs/guides/choose-gains.md.
#[test]
#[ignore = "asserts nothing; prints the table of docs/guides/choose-gains.md"]
fn tracking_table() {
    for lap in [8.0, 3.0] {
        for source in [Source::Profile, Source::Stream] {
            for (name, drive, stated) in DRIVES.into_iter().chain(WITHOUT_PREDICTION) {
                let errors = [2.0, 5.0, 10.0, 20.0].map(|gain| 1e3 * tracking_error(source, gain, lap, drive, stated));
                println!("{source:?}, lap of {lap} s, {name}: {errors:.3?} mm");
            }
        }
    }
}

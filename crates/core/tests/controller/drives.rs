//! Joint limits and planes behind a drive with lag and dead time, with noisy positions: calm, and never far outside.

use std::collections::VecDeque;
use std::sync::Arc;

use revprio_core::constraint::{APPROACH_RATE, Constraint, PlanePoint, VirtualPlane};
use revprio_core::controller::{Controller, ControllerConfig, Limits, Measurement, Stepper, TaskConfig};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::rows::{JointRows, JointTarget, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Axis, Configuration};

use super::arms::{NOMINAL, Random, constant, controller, position, ranged_arms, sawyer, task, tool_rows};
use super::hold::{mid_ranges, middle};

/// Bounds of the claim: distance outside, swing at rest (rad, plus 10 times the noise), command at rest (RMS, rad/s).
pub(super) const OVERSHOOT: f64 = 1e-3;
pub(super) const SWING: f64 = 1e-4;
pub(super) const COMMAND: f64 = 0.02;

/// Largest error of a measured position, rad.
pub(super) const NOISE: f64 = 1e-4;

const KINDS: [LimitKind; 2] = [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration];

/// An arm behind a drive, whose positions are measured with noise.
#[derive(Clone)]
pub(super) struct LaggingArm {
    pub(super) q: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    drive: Drive,
    sent: VecDeque<Vec<f64>>,
    random: Random,
    /// Largest error of a measured position, rad.
    noise: f64,
}

impl LaggingArm {
    pub(super) fn at_rest(q: &[f64], drive: Drive, noise: f64, seed: u64) -> Self {
        let velocity = vec![0.0; q.len()];
        let sent = std::iter::repeat_n(velocity.clone(), drive.delay_periods).collect();
        Self { q: q.to_vec(), velocity, drive, sent, random: Random(seed), noise }
    }

    pub(super) fn measure(&mut self, time_s: f64) -> Measurement {
        let joint_position = self.q.iter().map(|q| q + self.noise * self.random.signed()).collect();
        Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s,
            joint_position,
            joint_velocity: None,
            wrench: [0.0; 6],
            targets: Vec::new(),
        }
    }

    pub(super) fn follow(&mut self, command: &[f64], period: f64) {
        self.sent.push_back(command.to_vec());
        let acting = self.sent.pop_front().unwrap();
        let (lag, remaining) = (self.drive.lag_s, (-period / self.drive.lag_s).exp());
        for ((q, v), u) in self.q.iter_mut().zip(&mut self.velocity).zip(acting) {
            *q += period * u + (*v - u) * lag * (1.0 - remaining);
            *v = u + (*v - u) * remaining;
        }
    }
}

/// What a run into a limit shows.
#[derive(Debug, Default)]
pub(super) struct Calm {
    /// Largest distance outside, rad or m.
    pub(super) overshoot: f64,
    /// Largest minus smallest position at rest, rad or m.
    pub(super) swing: f64,
    /// RMS of the fastest joint's command at rest, rad/s.
    pub(super) command: f64,
    pub(super) conflicts: usize,
    /// Distance beyond the limit or plane at the end, rad or m.
    pub(super) distance: f64,
}

impl Calm {
    pub(super) fn add(&mut self, other: &Self) {
        self.overshoot = self.overshoot.max(other.overshoot);
        self.swing = self.swing.max(other.swing);
        self.command = self.command.max(other.command);
        self.conflicts += other.conflicts;
    }
}

/// Runs a controller for 2.5 s; `beyond`: distance beyond the limit or plane at a posture, rad or m.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
pub(super) fn run(controller: &Controller, arm: &mut LaggingArm, beyond: impl Fn(&[f64]) -> f64) -> Calm {
    let period = controller.config().period_s;
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let (mut memory, mut calm) = (None, Calm::default());
    let (mut lowest, mut highest, mut squares) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    let resting = (0.5 / period).round() as u32;
    let periods = 7 * resting;
    for number in 0..periods {
        let measurement = arm.measure(f64::from(number) * period);
        let command = stepper.step(&mut memory, &measurement).unwrap();
        calm.conflicts += usize::from(!command.limit_conflicts.is_empty());
        arm.follow(command.resolution.joint_velocity.as_slice(), period);
        let distance = beyond(&arm.q);
        calm.overshoot = calm.overshoot.max(distance);
        if number >= periods - resting {
            (lowest, highest) = (lowest.min(distance), highest.max(distance));
            squares += command.resolution.joint_velocity.amax().powi(2);
        }
    }
    let command = (squares / f64::from(resting)).sqrt();
    Calm { swing: highest - lowest, command, distance: beyond(&arm.q), ..calm }
}

/// Returns a controller that drives one joint of a robot beyond its limit.
pub(super) fn posture(
    robot: &Arc<RobotModel>,
    joint: usize,
    target: f64,
    kind: LimitKind,
    drive: Drive,
    period: f64,
) -> Controller {
    let rows = TaskRows::Joints(JointRows { target: JointTarget::Position(constant(&[target])), joints: vec![joint] });
    let task = TaskConfig {
        name: "posture".to_owned(),
        law: position(1, 5.0),
        rows,
        scaled: false,
        streaming: Streaming::default(),
    };
    let config = ControllerConfig::new(Arc::clone(robot), period, vec![task]);
    controller(ControllerConfig { limits: Limits::Robot(kind), drive, ..config })
}

/// Returns the drives of the stated range.
pub(super) fn drives() -> impl Iterator<Item = Drive> {
    let lags = [0.0, 0.001, 0.005, 0.01, 0.02, 0.03];
    lags.into_iter().flat_map(|lag_s| (0..=2).map(move |delay_periods| Drive { lag_s, delay_periods }))
}

/// Asserts the bounds of runs without noise and with noise.
fn assert_calm(without_noise: &Calm, with_noise: &Calm) {
    println!("without noise: {without_noise:?}\nwith noise: {with_noise:?}");
    assert_eq!([without_noise.conflicts, with_noise.conflicts], [0, 0]);
    for (calm, noise) in [(without_noise, 0.0), (with_noise, NOISE)] {
        assert!(calm.overshoot <= OVERSHOOT + 10.0 * noise, "{calm:?}");
        assert!(calm.swing <= SWING + 10.0 * noise, "{calm:?}");
        assert!(calm.command <= COMMAND, "{calm:?}");
    }
}

/// Returns how a drive may be stated, exactly or by default, and the limits that may hold.
fn stated_as(drive: Drive) -> impl Iterator<Item = (Drive, LimitKind)> {
    [Drive::CONSERVATIVE, drive].into_iter().flat_map(|stated| KINDS.map(|kind| (stated, kind)))
}

#[test]
fn joints_approach_their_limits_and_rest_there_behind_every_drive() {
    let [mut without_noise, mut with_noise] = [Calm::default(), Calm::default()];
    let (mut runs, arms) = (0, ranged_arms());
    for (drive, period) in drives().flat_map(|drive| [0.001, 0.004, 0.01].map(|period| (drive, period))) {
        for (stated, kind) in stated_as(drive) {
            for (worst, noise) in [(&mut without_noise, 0.0), (&mut with_noise, NOISE)] {
                runs += 1;
                let robot = &arms[runs % arms.len()];
                let joint = runs % robot.joint_count();
                let [lowest, highest] = robot.joints()[joint].limits.resting_range();
                let (end, outwards) = if runs % 3 == 0 { (lowest, -1.0) } else { (highest, 1.0) };
                let controller = posture(robot, joint, end + outwards, kind, stated, period);
                let mut start = mid_ranges(robot);
                start[joint] = end - 0.4 * outwards;
                let mut arm = LaggingArm::at_rest(&start, drive, noise, runs as u64);
                let calm = run(&controller, &mut arm, |q| (q[joint] - highest).max(lowest - q[joint]));
                let name = format!("{} {joint}, T {period}, {drive:?} stated as {stated:?}, {kind:?}", robot.name());
                assert!(calm.distance.abs() < 1e-3, "{name}: still {} from its limit", calm.distance);
                worst.add(&calm);
            }
        }
    }
    assert_calm(&without_noise, &with_noise);
}

/// A target that jumps back and forth across a limit must not shake the joint out of its range either.
#[test]
fn jumping_targets_do_not_drive_a_joint_out_of_its_range() {
    let (mut overshoot, mut conflicts, mut near) = ([f64::NEG_INFINITY; 2], [0; 2], 0);
    let arms = ranged_arms();
    for (number, drive) in drives().enumerate() {
        for (period, kind) in [0.001, 0.01].into_iter().flat_map(|period| KINDS.map(|kind| (period, kind))) {
            for (which, stated) in [drive, Drive::CONSERVATIVE].into_iter().enumerate() {
                for hold in [2, 7, 30, 80] {
                    let robot = &arms[number % arms.len()];
                    let joint = number % robot.joint_count();
                    let limits = robot.joints()[joint].limits;
                    let controllers = [limits.upper + 1.0, limits.upper - 0.05]
                        .map(|target| posture(robot, joint, target, kind, stated, period));
                    let mut q = middle(robot);
                    q[joint] = limits.upper - 0.1;
                    let mut arm = LaggingArm::at_rest(&q, drive, 0.0, number as u64);
                    let mut memory = None;
                    let mut random = Random(number as u64);
                    let mut steppers = controllers.map(|controller| Stepper::new(controller).unwrap());
                    let mut current = 0;
                    for number in 0..1500 {
                        if random.below(hold) == 0 {
                            current = 1 - current;
                        }
                        let measurement = arm.measure(f64::from(number) * period);
                        let command = steppers[current].step(&mut memory, &measurement).unwrap();
                        conflicts[which] += usize::from(!command.limit_conflicts.is_empty());
                        arm.follow(command.resolution.joint_velocity.as_slice(), period);
                        overshoot[which] = overshoot[which].max(arm.q[joint] - limits.upper);
                        near += usize::from((arm.q[joint] - limits.upper).abs() < 1e-3);
                    }
                }
            }
        }
    }
    println!("stated exactly, conservatively: outside {overshoot:?} rad, conflicts {conflicts:?}, {near} near");
    assert!(near > 50_000, "{near}");
    assert!(overshoot[0] <= 1e-9 && overshoot[1] <= OVERSHOOT, "{overshoot:?}");
    assert_eq!(conflicts[0], 0);
}

/// Returns a controller that drives the tool up through a ceiling at a height.
fn into_ceiling(kind: LimitKind, drive: Drive, period: f64, ceiling: f64) -> Controller {
    let plane = VirtualPlane::new("ceiling", [0.0, 0.0, 1.0], ceiling, PlanePoint::Tool, APPROACH_RATE).unwrap();
    let rows = ToolRows { target_displacement: Some(constant(&[0.6])), ..tool_rows(&[Axis::Z]) };
    let up = TaskConfig {
        name: "up".to_owned(),
        law: position(1, 3.0),
        rows: TaskRows::Tool(rows),
        scaled: false,
        streaming: Streaming::default(),
    };
    let hold = task(&[Axis::X, Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz], position(5, 2.0));
    let config = ControllerConfig::new(sawyer(), period, vec![up, hold]);
    controller(ControllerConfig {
        constraints: vec![Constraint::Plane(plane)],
        limits: Limits::Robot(kind),
        drive,
        ..config
    })
}

#[test]
fn the_tool_approaches_a_plane_and_rests_there_behind_every_drive() {
    let robot = sawyer();
    let height = |q: &[f64]| Configuration::new(&robot, q).unwrap().tool_pose().translation.z;
    let ceiling = height(&NOMINAL) + 0.15;
    let [mut without_noise, mut with_noise] = [Calm::default(), Calm::default()];
    for (number, (drive, period)) in drives().flat_map(|drive| [0.001, 0.01].map(|period| (drive, period))).enumerate()
    {
        for (stated, kind) in stated_as(drive) {
            for (worst, noise) in [(&mut without_noise, 0.0), (&mut with_noise, NOISE)] {
                let controller = into_ceiling(kind, stated, period, ceiling);
                let mut arm = LaggingArm::at_rest(&NOMINAL, drive, noise, number as u64);
                let calm = run(&controller, &mut arm, |q| height(q) - ceiling);
                assert!(calm.distance.abs() < 1e-3, "still {} from the ceiling", calm.distance);
                worst.add(&calm);
            }
        }
    }
    assert_calm(&without_noise, &with_noise);
}

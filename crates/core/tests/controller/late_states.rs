//! States that come late: the arm holds its command and brakes, as its watchdog says, and the controller knows it.

use std::sync::Arc;

use revprio_core::controller::{Command, ControllerConfig, Limits, Memory, Stepper, TaskConfig};
use revprio_core::limits::{Drive, LimitKind, braking_deceleration};
use revprio_robot::kinematics::Axis;
use revprio_robot::{Joint, RobotModel, built_in};

use super::arms::{Random, config, controller, joint_rows, position, task};
use super::drives::LaggingArm;
use super::hold::middle;

/// The drives of the runs.
const DRIVES: [Drive; 5] = [
    Drive::IDEAL,
    Drive { lag_s: 0.0, delay_periods: 2 },
    Drive { lag_s: 0.02, delay_periods: 1 },
    Drive::CONSERVATIVE,
    Drive { lag_s: 0.06, delay_periods: 3 },
];

/// Which states of a run come late.
#[derive(Debug, Clone, Copy)]
struct Lateness {
    /// Percentage of states that are late.
    percent: u64,
    /// Most extra periods.
    most: u64,
    /// Whether the program of the arm dies now and then, for up to 1 s.
    kills: bool,
}

/// A client of a controller: it sends the commands of an arm, and those of its watchdog.
struct Client {
    arm: LaggingArm,
    sent: Vec<f64>,
    /// Whether the commands return to the answers, after a ramp.
    resumes: bool,
}

impl Client {
    /// Sends a command for some periods, as docs/limits.md says.
    fn hold(&mut self, robot: &RobotModel, command: &Command, periods: u64, period: f64, mut each: impl FnMut(&[f64])) {
        let valid = command.hold.valid_for_ms(100) as f64 / 1e3;
        for k in 1..=periods {
            // Commands are valid for longer than a period, except where their drive contradicts.
            let late = if k == 1 { 0.0 } else { k as f64 * period - valid };
            self.resumes |= late > 1e-9;
            let mut arrived = true;
            for (joint, (sent, answer)) in
                robot.joints().iter().zip(self.sent.iter_mut().zip(command.resolution.joint_velocity.iter()))
            {
                let deceleration = braking_deceleration(&joint.limits);
                let ramp = (answer.abs() - (deceleration * late.max(0.0)).min(f64::MAX)).max(0.0).copysign(*answer);
                let reach = if self.resumes { deceleration * period } else { f64::INFINITY };
                *sent = ramp.max(*sent - reach).min(*sent + reach);
                arrived &= *sent == ramp;
            }
            self.resumes &= !arrived;
            self.arm.follow(&self.sent, period);
            each(&self.arm.q);
        }
    }
}

/// Returns controllers that drive all joints beyond random ends of their ranges.
fn controllers(robot: &Arc<RobotModel>, drive: Drive, period: f64, random: &mut Random) -> Vec<Stepper> {
    let beyond = |joint: &Joint, upper: bool| {
        let (lower, upper_end) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
        if upper { upper_end + 1.0 } else { lower - 1.0 }
    };
    (0..12)
        .map(|_| {
            let target: Vec<f64> = robot.joints().iter().map(|joint| beyond(joint, random.below(2) == 0)).collect();
            let gain = [2.0, 10.0, 50.0][random.below(if period < 0.01 { 3 } else { 2 })];
            let posture = TaskConfig { rows: joint_rows(&target), ..task(&[Axis::X], position(target.len(), gain)) };
            let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
            let config = config(robot, vec![posture]);
            Stepper::new(controller(ControllerConfig { limits, drive, period_s: period, ..config })).unwrap()
        })
        .collect()
}

/// Runs an arm for 5 s and returns the largest distance outside the ranges, rad.
fn outside(robot: &Arc<RobotModel>, drive: Drive, period: f64, lateness: Lateness, seed: u64, knows: bool) -> f64 {
    let mut random = Random(seed);
    let mut steppers = controllers(robot, drive, period, &mut random);
    let arm = LaggingArm::at_rest(&middle(robot), drive, 0.0, seed);
    let mut client = Client { arm, sent: vec![0.0; robot.joint_count()], resumes: false };
    let (mut memory, mut passed, mut worst) = (None::<Memory>, 0_u64, f64::NEG_INFINITY);
    while (passed as f64) * period < 5.0 {
        let current = (passed as f64 * period / 0.4) as usize % steppers.len();
        let measurement = client.arm.measure(passed as f64 * period);
        if let Some(memory) = memory.as_mut().filter(|_| !knows) {
            memory.answered = None;
        }
        let command = steppers[current].step(&mut memory, &measurement).unwrap();
        let is_late = (random.below(100) as u64) < lateness.percent;
        let late = if is_late { 1 + random.below(lateness.most as usize) as u64 } else { 0 };
        let dies = lateness.kills && random.below((0.5 / period) as usize) == 0;
        let killed = if dies { random.below((1.0 / period) as usize) as u64 } else { 0 };
        let periods = 1 + late + killed;
        client.hold(robot, command, periods, period, |q| {
            for (joint, q) in robot.joints().iter().zip(q) {
                worst = worst.max((q - joint.limits.upper).max(joint.limits.lower - q));
            }
        });
        passed += periods;
    }
    worst
}

#[test]
fn late_states_lead_no_joint_out_of_its_range_behind_a_drive() {
    let mut runs = 0;
    for period in [0.001, 0.004, 0.01] {
        for (percent, most, kills) in [(0, 1, true), (3, 1, false), (10, 1, true), (10, 3, false), (30, 3, true)] {
            let lateness = Lateness { percent, most, kills };
            for drive in DRIVES {
                let mut worst = [f64::NEG_INFINITY; 2];
                for robot in built_in() {
                    runs += 1;
                    for k in [0, 1] { worst[k] = worst[k].max(outside(robot, drive, period, lateness, runs, k == 0)); }
                }
                println!("T {period} {drive:?} {lateness:?}: {:.1e} {:.1e}", worst[0], worst[1]);
            }
        }
    }
}

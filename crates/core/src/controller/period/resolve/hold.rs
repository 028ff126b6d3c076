//! How long the answer may be held before a watchdog brakes, as far as joints and contacts say.

use revprio_robot::kinematics::Configuration;

use super::super::aim::{PressingAxis, Requests};
use crate::arm_state::ArmState;
use crate::constraint;
use crate::controller::config::ControllerConfig;
use crate::law::{ContactPhase, ContactSettings};
use crate::limits::{Hold, braking_deceleration, spare_time};
use crate::linalg::{Matrix, row_times};
use crate::task::TaskStack;

/// Time over which the acceleration of a tool on its arc is computed, s: the joints turn little in it.
const ARC_TIME: f64 = 0.05;

/// Steps in which a ramp to rest is followed.
const RAMP_STEPS: u32 = 8;

/// Where a held command has moved the arm after [`ARC_TIME`].
pub(super) struct HeldMotion {
    configuration: Configuration,
    position: Vec<f64>,
    /// Jacobians there of the tasks that press, along the axes that their frames have now; empty for the others.
    jacobians: Vec<Matrix>,
}

impl HeldMotion {
    /// Allocates the memory of a checked configuration; `None` if no task presses.
    pub fn new(config: &ControllerConfig, arm: &ArmState) -> Option<Self> {
        let configuration = arm.measured().configuration.clone();
        let position = configuration.joint_position().to_vec();
        let rows = config.tasks.iter().map(|task| task.law.contact().map_or(0, |_| task.rows.len()));
        let jacobians: Vec<Matrix> = rows.map(|rows| Matrix::zeros(rows, position.len())).collect();
        jacobians.iter().any(|jacobian| jacobian.nrows() > 0).then_some(Self { configuration, position, jacobians })
    }

    /// Moves the arm by a command (n) from its posture of rest.
    fn update(&mut self, command: &[f64], config: &ControllerConfig, arm: &ArmState) {
        let rest = arm.at_rest().configuration.joint_position();
        for (q, (rest, u)) in self.position.iter_mut().zip(rest.iter().zip(command)) {
            *q = rest + ARC_TIME * u;
        }
        // Positions that overflow are no posture; the arc of the period before serves as well as none.
        if self.configuration.update(&config.robot, &self.position).is_err() {
            return;
        }
        for (task, jacobian) in
            config.tasks.iter().zip(&mut self.jacobians).filter(|(_, jacobian)| jacobian.nrows() > 0)
        {
            task.rows.write_jacobian_along(arm.later(&self.configuration, 0.0), arm.at_rest(), jacobian);
        }
    }

    /// Returns the mean acceleration of a tool along its pressing direction, m/s² or rad/s²; `speed`: its speed now.
    fn acceleration(&self, axis: &PressingAxis, command: &[f64], speed: f64) -> f64 {
        let later = axis.direction * row_times(&self.jacobians[axis.task], axis.row, command);
        (later - speed) / ARC_TIME
    }
}

/// What bounds the hold of a command in this period.
pub(super) struct Holding<'a> {
    pub config: &'a ControllerConfig,
    pub arm: &'a ArmState,
    pub requests: Requests<'a>,
    pub held: Option<&'a mut HeldMotion>,
}

impl Holding<'_> {
    /// Updates the hold of a command (n): joints that brake afterwards stop inside their ranges, and no tool presses much harder.
    /// `tasks`: with the Jacobians of the period.
    pub fn update(&mut self, hold: &mut Hold, command: &[f64], tasks: &TaskStack) {
        let Self { config, arm, .. } = *self;
        match config.kept_limits() {
            Some(kind) => hold.update(&config.robot, kind, arm.motion(), &arm.joint_velocity, command, config.period_s),
            None => *hold = Hold::default(),
        }
        if let Some(held) = &mut self.held {
            held.update(command, config, arm);
        }
        let pressing = self.pressing_time(command, tasks);
        if self.stops_together(command, hold.time_s.min(pressing), tasks) {
            hold.stop_together(&config.robot, config.kept_limits(), arm.motion(), command, config.period_s);
        }
        hold.shorten(pressing, config.period_s);
    }

    /// Returns whether joints that stop together, after a command was held for a time (s), press less than joints that brake as fast as each
    /// can. The distances of obstacles count with the latter.
    fn stops_together(&self, command: &[f64], time: f64, tasks: &TaskStack) -> bool {
        if constraint::distances(&self.config.constraints).is_some() {
            return false;
        }
        let joints = self.config.robot.joints();
        let own = |joint: usize| command[joint].abs() / braking_deceleration(&joints[joint].limits);
        let longest = (0..command.len()).map(own).fold(0.0, f64::max);
        let held = (time.min(ARC_TIME), longest);
        self.force_of_ramp(command, held, |_| longest, tasks) < self.force_of_ramp(command, held, own, tasks)
    }

    /// Returns the largest force, relative to its target, that joints add while they brake from a command.
    ///
    /// - `held`: how long they have kept it before, and how long the longest ramp takes, s.
    /// - `stop_time`: how long the ramp of each joint takes, s.
    fn force_of_ramp(
        &self,
        command: &[f64],
        held: (f64, f64),
        stop_time: impl Fn(usize) -> f64,
        tasks: &TaskStack,
    ) -> f64 {
        let Requests { contacts, targets, .. } = self.requests;
        let forces =
            contacts.axes().iter().filter(|axis| targets[axis.task].released_by.is_none()).filter_map(|axis| {
                let motion = self.held.as_ref()?;
                let now = &tasks.tasks()[axis.task].jacobian;
                let weight = self.config.weight(axis.task, axis.row);
                let speed_at = |joint: usize, after: f64| {
                    let (now, later) =
                        (now[(axis.row, joint)] / weight, motion.jacobians[axis.task][(axis.row, joint)]);
                    axis.direction * command[joint] * (now + (later - now) * after / ARC_TIME)
                };
                Some(self.stiffness(axis)? / axis.target * way_in(command.len(), held, &stop_time, speed_at))
            });
        forces.fold(0.0, f64::max)
    }

    /// Returns the settings of an axis; `None` for a task without the law `contact`.
    fn settings(&self, axis: &PressingAxis) -> Option<&ContactSettings> {
        Some(&self.config.tasks[axis.task].law.contact()?.axes()[axis.row])
    }

    /// Returns an upper bound of the stiffness that an axis presses on, N/m or N·m/rad; `None` for a task without the law `contact`.
    fn stiffness(&self, axis: &PressingAxis) -> Option<f64> {
        let settings = self.settings(axis)?;
        let upper = axis.memory.estimate.upper;
        let is_known = axis.memory.phase != ContactPhase::Approach && upper > 0.0;
        Some(if is_known { upper } else { settings.stiffest })
    }

    /// Returns the time after which a command has added its target to a force, or max(2 T, 10 ms) if that is more, s; infinite without a tool
    /// that presses or approaches, that least time while a tool may be pushed by the retreat of a lower task. A loop whose answers take up to
    /// a period does not brake between two of them.
    ///
    /// Joints that keep their speeds lead a tool on an arc. One that slides along a surface presses harder although it does not move towards
    /// it now.
    fn pressing_time(&self, command: &[f64], tasks: &TaskStack) -> f64 {
        let Self { config, requests: Requests { contacts, targets, .. }, .. } = *self;
        let shortest = spare_time(2.0 * config.period_s);
        let times = contacts.axes().iter().filter_map(|axis| {
            let stiffness = self.stiffness(axis)?;
            if targets[axis.task].released_by.is_some() {
                // A released task has no rows in this problem.
                return Some(shortest);
            }
            let along = axis.along(command, config, tasks);
            // A tool that follows a surface presses no harder. One that has lost it may meet it at rest.
            let is_held =
                axis.memory.phase == ContactPhase::Contact && axis.memory.force >= self.settings(axis)?.release();
            let speed = along - if is_held { axis.memory.motion.velocity.max(0.0) } else { 0.0 };
            let acceleration = self.held.as_ref().map_or(0.0, |held| held.acceleration(axis, command, along));
            let time = time_of_way(axis.target / stiffness, speed, (acceleration, self.time_to_rest(command)));
            time.map(|time| time.max(shortest))
        });
        times.fold(f64::INFINITY, f64::min)
    }

    /// Returns how long joints go on at the speeds of a command (n) after its hold, s: the drive follows late, and a ramp to rest counts half.
    fn time_to_rest(&self, command: &[f64]) -> f64 {
        let config = self.config;
        let ramps =
            command.iter().zip(config.robot.joints()).map(|(u, joint)| u.abs() / braking_deceleration(&joint.limits));
        config.drive.lag_s + config.drive.delay_periods as f64 * config.period_s + 0.5 * ramps.fold(0.0, f64::max)
    }
}

/// Returns how far a tool moves in at most, m or rad, while `joints` joints brake evenly, each within its stop time (s).
///
/// - `held`: how long they have kept their speeds before, and the longest stop time, s.
/// - `speed_at`: part of a joint at full speed in the speed of the tool, after a time on the arc.
fn way_in(
    joints: usize,
    (held, longest): (f64, f64),
    stop_time: impl Fn(usize) -> f64,
    speed_at: impl Fn(usize, f64) -> f64,
) -> f64 {
    let step = longest / f64::from(RAMP_STEPS);
    let (mut way, mut farthest) = (0.0, 0.0_f64);
    for k in 0..RAMP_STEPS {
        let time = (f64::from(k) + 0.5) * step;
        let braking = (0..joints).map(|joint| (joint, stop_time(joint))).filter(|(_, stop)| *stop > time);
        way += step * braking.map(|(joint, stop)| speed_at(joint, held + time) * (1.0 - time / stop)).sum::<f64>();
        farthest = farthest.max(way);
    }
    farthest
}

/// Returns when a tool has moved by a way of at least 0 (m or rad) at a speed, and by its acceleration also in the time `rest` (s) after that:
/// way = v t + a (t + rest)²/2, with a ≥ 0; `None`: never.
fn time_of_way(way: f64, speed: f64, (acceleration, rest): (f64, f64)) -> Option<f64> {
    if !(acceleration > 0.0) {
        return (speed > 0.0).then(|| way / speed);
    }
    let speed = speed + acceleration * rest;
    let way = (way - 0.5 * acceleration * rest * rest).max(0.0);
    let root = (speed * speed + 2.0 * acceleration * way).sqrt();
    Some(if speed > 0.0 { 2.0 * way / (speed + root) } else { (root - speed) / acceleration })
}

//! How long the answer may be held before a watchdog brakes, as far as joints and contacts say.

use revprio_robot::kinematics::Configuration;

use super::super::aim::{PressingAxis, Requests};
use crate::arm_state::ArmState;
use crate::constraint;
use crate::controller::config::ControllerConfig;
use crate::law::ContactPhase;
use crate::limits::{Hold, braking_deceleration, spare_time};
use crate::linalg::{Matrix, row_times};
use crate::task::TaskStack;

/// Time over which the acceleration of a tool on its arc is computed, s: the joints turn little in it.
const ARC_TIME: f64 = 0.05;

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
        if self.stops_together() {
            hold.stop_together(&config.robot, config.kept_limits(), arm.motion(), command, config.period_s);
        }
        if let Some(held) = &mut self.held {
            held.update(command, config, arm);
        }
        hold.shorten(self.pressing_time(command, tasks), config.period_s);
    }

    /// Returns whether a watchdog is to keep the direction of a tool that may touch. The distances of obstacles count with joints that brake
    /// at their own decelerations.
    fn stops_together(&self) -> bool {
        constraint::distances(&self.config.constraints).is_none()
            && self.config.tasks.iter().any(|task| task.law.reads_wrench())
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
            let law = config.tasks[axis.task].law.contact()?;
            if targets[axis.task].released_by.is_some() {
                // A released task has no rows in this problem.
                return Some(shortest);
            }
            let upper = axis.memory.estimate.upper;
            let is_known = axis.memory.phase != ContactPhase::Approach && upper > 0.0;
            let stiffness = if is_known { upper } else { law.axes()[axis.row].stiffest };
            let along = axis.along(command, config, tasks);
            // A tool that follows a surface presses no harder.
            let speed = along - axis.memory.motion.velocity.max(0.0);
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

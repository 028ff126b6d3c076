//! States that come late: what the arm did in the periods without an answer.
//!
//! A state that is n = round(Δt/T) > 1 periods after the one before finds an arm that got the last command for one period,
//! and then n − 1 times the command of its watchdog: the last command while it was valid, then a ramp to rest. The
//! modelled drive follows these commands, so the position of rest p is that of the arm. The ramp is also the last command
//! from which the next one accelerates. After the ramp has begun, the watchdog limits the change to the next answer to a T. So the
//! answer keeps that itself, also where the limits of the controller let joints jump: the arm gets what the service assumes.
//!
//! The clock of the states may jump. Measured positions tell: if they fit clearly better to an arm that moved for one period,
//! one period passed.

use super::watchdog::{Unanswered, Watchdog};
use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::state::{AnsweredState, Measurement, Memory};
use crate::limits::{Drive, DriveState};
use crate::linalg::{Matrix, Vector};

/// Largest number of missed periods that is told from more. All joints rest long before, and distances stay finite.
const MAX_MISSED: f64 = 1e9;

/// Distance by which the measured positions must fit better to a single period, rad and m, norm over the joints. It covers
/// noise.
const CLOCK_TOLERANCE: f64 = 1e-3;

/// What the joints did in the periods without a state.
pub(super) struct Missed {
    /// How far they moved behind the modelled drive, n, rad or m.
    pub way: Vector,
    /// For how long, s.
    pub time: f64,
}

impl AnsweredState {
    /// Returns how many periods passed until a measurement without a state; 0 if it comes in time or earlier.
    fn missed_periods(&self, time_s: f64, period: f64) -> usize {
        let missed = ((time_s - self.time_s) / period).round() - 1.0;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to MAX_MISSED; NaN gives 0")]
        let missed = missed.clamp(0.0, MAX_MISSED) as usize;
        missed
    }
}

impl Memory {
    /// Returns the memory after the periods that passed without a state before `measurement`, and how far the joints moved in
    /// them; `None`: none passed.
    pub(super) fn after_missed_periods(
        &self,
        config: &ControllerConfig,
        measurement: &Measurement,
    ) -> Option<(Self, Missed)> {
        let answered = self.answered.as_ref()?;
        let period = config.period_s;
        let missed = answered.missed_periods(measurement.time_s, period);
        if missed == 0 {
            return None;
        }
        let watchdog =
            Watchdog { robot: &config.robot, command: &self.last_command, answered, drive: config.drive, period };
        let Unanswered { drive, command, rest_moved } = watchdog.follow(&self.drive, missed);
        let to_rest = |state: &DriveState| state.distances_to_rest(config.drive, period);
        let travelled = to_rest(&self.drive) + rest_moved - to_rest(&drive);
        // Beyond what one period explains.
        let moved = Vector::from_row_slice(&measurement.joint_position) - &answered.joint_position;
        let further = match &answered.way {
            Some(way) => moved - way,
            None => moved - &self.drive.velocity * period,
        };
        let fits_one_period = further.norm() + CLOCK_TOLERANCE;
        if fits_one_period < (further - &travelled).norm() {
            return None;
        }
        let jumps = config.limits_let_joints_jump();
        let in_transition = self.in_transition || jumps && watchdog.brakes_within(missed);
        let mut later = Self { drive, last_command: command, in_transition, ..self.clone() };
        if let Some(jerk) = &mut later.jerk {
            jerk.acceleration.fill(0.0);
        }
        Some((later, Missed { way: travelled, time: missed as f64 * period }))
    }

    /// Lets the laws continue from what the ramp has left of their velocities, at the posture of rest.
    pub(super) fn continue_from_ramp(&mut self, config: &ControllerConfig, arm: &ArmState) {
        for (task, velocity) in config.tasks.iter().zip(&mut self.task_velocities) {
            let mut jacobian = Matrix::zeros(task.rows.len(), self.last_command.len());
            task.rows.write_jacobian(arm.at_rest(), &mut jacobian);
            jacobian.mul_to(&self.last_command, velocity);
        }
    }
}

impl DriveState {
    /// Returns p − q, n, rad or m; `period`: T, s.
    fn distances_to_rest(&self, drive: Drive, period: f64) -> Vector {
        Vector::from_fn(self.velocity.len(), |joint, _| self.distance_to_rest(drive, joint, period))
    }
}

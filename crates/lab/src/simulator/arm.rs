//! The simulated arm with its inner velocity loop.

use std::collections::VecDeque;

use revprio_api::wire::integer;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::drive_limits::DriveLimits;
use super::field_error::{FieldError, between, not_negative};

/// Largest delay of a command, periods.
const MAX_DELAY: usize = 10_000;

/// How the arm follows a commanded velocity. The default is an ideal arm.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VelocityLoop {
    /// Time constant τ of a first-order lag, s.
    pub lag_s: f64,
    /// Delay of a command, whole periods.
    #[serde(deserialize_with = "integer::deserialize")]
    pub delay_periods: usize,
    /// Whether the drives clamp the command of each joint at the limits of the controller.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub clamp: bool,
}

impl VelocityLoop {
    /// Checks the values; `pointer` is the JSON pointer of this object.
    pub fn check(&self, pointer: &str) -> Result<(), FieldError> {
        not_negative(self.lag_s, &format!("{pointer}/lag_s"))?;
        between(self.delay_periods, 0, MAX_DELAY, &format!("{pointer}/delay_periods"))?;
        Ok(())
    }
}

/// Joint positions and velocities of the simulated arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    position: Vec<f64>,
    velocity: Vec<f64>,
    lag_s: f64,
    drive_limits: Option<DriveLimits>,
    /// Delayed commands, the oldest first.
    queue: VecDeque<Vec<f64>>,
    /// The command in force.
    active: Vec<f64>,
}

impl Arm {
    /// Returns an arm at rest; `position`: n, rad or m; `drive_limits` clamp its commands, if given.
    pub fn at_rest(position: Vec<f64>, inner_loop: VelocityLoop, drive_limits: Option<DriveLimits>) -> Self {
        let velocity = vec![0.0; position.len()];
        let queue = std::iter::repeat_n(velocity.clone(), inner_loop.delay_periods).collect();
        let active = velocity.clone();
        Self { position, velocity, lag_s: inner_loop.lag_s, drive_limits, queue, active }
    }

    /// Returns q, n, rad or m.
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// Returns q̇, n, rad/s or m/s.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Accepts a commanded velocity (n) and activates the command of `delay_periods` before for the next period.
    pub fn command(&mut self, velocity: &[f64]) {
        self.queue.push_back(velocity.to_vec());
        let Some(mut active) = self.queue.pop_front() else { return };
        if let Some(limits) = &self.drive_limits {
            limits.clamp(&mut active, &self.position, &self.active);
        }
        self.active = active;
    }

    /// Advances by a time t (s) under the active command u with the exact solution: q̇ → u + (q̇ − u) e^(−t/τ), and q its
    /// integral; for τ = 0: q → q + t u.
    pub fn advance(&mut self, time: f64) {
        let tau = self.lag_s;
        let remaining = if tau > 0.0 { (-time / tau).exp() } else { 0.0 };
        for ((q, qdot), u) in self.position.iter_mut().zip(&mut self.velocity).zip(&self.active) {
            let gap = *qdot - u;
            *q += time * u + gap * tau * (1.0 - remaining);
            *qdot = u + gap * remaining;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm(position: f64, lag_s: f64, delay_periods: usize) -> Arm {
        Arm::at_rest(vec![position], VelocityLoop { lag_s, delay_periods, clamp: false }, None)
    }

    #[test]
    fn ideal_arm_moves_at_the_commanded_velocity() {
        let mut arm = arm(1.0, 0.0, 0);
        arm.command(&[0.5]);
        arm.advance(0.01);
        assert_eq!((arm.position(), arm.velocity()), ([1.005].as_slice(), [0.5].as_slice()));
    }

    #[test]
    fn lag_gives_the_exact_step_response_for_any_step_length() {
        for steps in [100, 10] {
            let mut arm = arm(0.0, 0.05, 0);
            arm.command(&[2.0]);
            (0..steps).for_each(|_| arm.advance(0.1 / f64::from(steps)));
            let t: f64 = 0.1;
            assert!((arm.velocity()[0] - 2.0 * (1.0 - (-t / 0.05).exp())).abs() < 1e-12);
            assert!((arm.position()[0] - 2.0 * (t - 0.05 * (1.0 - (-t / 0.05).exp()))).abs() < 1e-12);
        }
    }

    #[test]
    fn delayed_command_acts_after_whole_periods() {
        let mut arm = arm(0.0, 0.0, 2);
        let speeds: Vec<f64> = (1..=4)
            .map(|i| {
                arm.command(&[f64::from(i)]);
                arm.advance(0.1);
                arm.velocity()[0]
            })
            .collect();
        assert_eq!(speeds, [0.0, 0.0, 1.0, 2.0]);
    }
}

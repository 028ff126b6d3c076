//! The arm behind its inner velocity loop.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::drive_limits::DriveLimits;
use super::field_error::{FieldError, between, not_negative};

/// Longest delay of a command, periods.
const LONGEST_DELAY: usize = 10_000;

/// How the arm follows a commanded velocity; ideal if nothing is set.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VelocityLoop {
    /// τ of a first-order lag, s.
    pub lag_s: f64,
    /// Whole periods that a command waits before it acts.
    pub delay_periods: usize,
    /// Whether the drives cut commands at the limits that the controller is given, each joint by itself.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub clamp: bool,
}

impl VelocityLoop {
    /// Whether the numbers make sense; `pointer` says where they stand.
    pub fn check(&self, pointer: &str) -> Result<(), FieldError> {
        not_negative(self.lag_s, &format!("{pointer}/lag_s"))?;
        between(self.delay_periods, 0, LONGEST_DELAY, &format!("{pointer}/delay_periods"))?;
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
    waiting: VecDeque<Vec<f64>>,
    acting: Vec<f64>,
}

impl Arm {
    /// An arm at rest; `position`: n, rad or m; `drive_limits` cut its commands, if given.
    pub fn at_rest(position: Vec<f64>, inner_loop: VelocityLoop, drive_limits: Option<DriveLimits>) -> Self {
        let velocity = vec![0.0; position.len()];
        let waiting = std::iter::repeat_n(velocity.clone(), inner_loop.delay_periods).collect();
        let acting = velocity.clone();
        Self { position, velocity, lag_s: inner_loop.lag_s, drive_limits, waiting, acting }
    }

    /// q, n, rad or m.
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// q̇, n, rad/s or m/s.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Takes a commanded velocity (n) for the period that begins, in which the command of `delay_periods` before acts.
    pub fn command(&mut self, velocity: &[f64]) {
        self.waiting.push_back(velocity.to_vec());
        let Some(mut acting) = self.waiting.pop_front() else { return };
        if let Some(limits) = &self.drive_limits {
            limits.cut(&mut acting, &self.position, &self.acting);
        }
        self.acting = acting;
    }

    /// Moves for a time (s) under the acting command u, exactly: q̇ → u + (q̇ − u) e^(−t/τ), and q its integral; for τ = 0:
    /// q → q + t u.
    pub fn advance(&mut self, time: f64) {
        let tau = self.lag_s;
        let remaining = if tau > 0.0 { (-time / tau).exp() } else { 0.0 };
        for ((q, qdot), u) in self.position.iter_mut().zip(&mut self.velocity).zip(&self.acting) {
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
    fn an_ideal_arm_does_what_it_is_told() {
        let mut arm = arm(1.0, 0.0, 0);
        arm.command(&[0.5]);
        arm.advance(0.01);
        assert_eq!((arm.position(), arm.velocity()), ([1.005].as_slice(), [0.5].as_slice()));
    }

    #[test]
    fn a_lagging_arm_follows_the_exact_step_response_in_steps_of_any_length() {
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
    fn a_delayed_command_acts_later_by_whole_periods() {
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

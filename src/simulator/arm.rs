//! The arm behind its inner velocity loop.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How the arm follows a commanded velocity; ideal if both are zero.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VelocityLoop {
    /// τ of a first-order lag, s.
    pub lag_s: f64,
    /// Whole periods that a command waits before it acts.
    pub delay_periods: usize,
}

/// Joint positions and velocities of the simulated arm.
#[derive(Debug, Clone, PartialEq)]
pub struct Arm {
    position: Vec<f64>,
    velocity: Vec<f64>,
    inner_loop: VelocityLoop,
    waiting: VecDeque<Vec<f64>>,
}

impl Arm {
    /// An arm at rest; `position`: n, rad or m.
    pub fn at_rest(position: Vec<f64>, inner_loop: VelocityLoop) -> Self {
        let velocity = vec![0.0; position.len()];
        let waiting = std::iter::repeat_n(velocity.clone(), inner_loop.delay_periods).collect();
        Self { position, velocity, inner_loop, waiting }
    }

    /// q, n, rad or m.
    pub fn position(&self) -> &[f64] {
        &self.position
    }

    /// q̇, n, rad/s or m/s.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Moves for one period T (s) under a commanded velocity (n), exactly for a command held over the period:
    /// q̇ → u + (q̇ − u) e^(−T/τ), and q its integral; for τ = 0: q → q + T u.
    pub fn advance(&mut self, command: &[f64], period: f64) {
        self.waiting.push_back(command.to_vec());
        let Some(acting) = self.waiting.pop_front() else { return };
        let tau = self.inner_loop.lag_s;
        let remaining = if tau > 0.0 { (-period / tau).exp() } else { 0.0 };
        for ((q, qdot), u) in self.position.iter_mut().zip(&mut self.velocity).zip(acting) {
            let gap = *qdot - u;
            *q += period * u + gap * tau * (1.0 - remaining);
            *qdot = u + gap * remaining;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ideal_arm_does_what_it_is_told() {
        let mut arm = Arm::at_rest(vec![1.0], VelocityLoop::default());
        arm.advance(&[0.5], 0.01);
        assert_eq!((arm.position(), arm.velocity()), ([1.005].as_slice(), [0.5].as_slice()));
    }

    #[test]
    fn a_lagging_arm_follows_the_exact_step_response() {
        let mut arm = Arm::at_rest(vec![0.0], VelocityLoop { lag_s: 0.05, delay_periods: 0 });
        (0..100).for_each(|_| arm.advance(&[2.0], 0.001));
        let t: f64 = 0.1;
        assert!((arm.velocity()[0] - 2.0 * (1.0 - (-t / 0.05).exp())).abs() < 1e-12);
        assert!((arm.position()[0] - 2.0 * (t - 0.05 * (1.0 - (-t / 0.05).exp()))).abs() < 1e-12);
    }

    #[test]
    fn a_delayed_command_acts_later_by_whole_periods() {
        let mut arm = Arm::at_rest(vec![0.0], VelocityLoop { lag_s: 0.0, delay_periods: 2 });
        let speeds: Vec<f64> = (1..=4)
            .map(|i| {
                arm.advance(&[f64::from(i)], 0.1);
                arm.velocity()[0]
            })
            .collect();
        assert_eq!(speeds, [0.0, 0.0, 1.0, 2.0]);
    }
}

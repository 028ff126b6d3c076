//! The drive between a command and a joint: a dead time, then a first-order lag.
//!
//! # Where the joint goes
//!
//! A joint is at q with the velocity v. Its drive has the lag L and a dead time of D periods T; the commands u₁ … u_D are
//! still on their way. If all later commands are zero, the joint comes to rest at
//!
//! p = q + L v + T (u₁ + … + u_D),
//!
//! because v̇ = (u − v)/L integrates to L v + ∫u dt. This position of rest has neither lag nor dead time: one period with
//! the command u moves it to p + T u, exactly.
//!
//! # Why limits that hold for p hold for q
//!
//! Let P(t) be the integral of the commands, so p = P at every period. The joint is q(t) = ∫ h(s) P(t − s) ds with the
//! response h of the drive: h ≥ 0, and its integral is 1. So q is a weighted mean of earlier values of P. If P never
//! exceeds q_hi, then neither does q.
//!
//! # A drive that is faster than stated
//!
//! Let M be the transfer function of the real drive and M̂ that of the stated one. Near a limit the box is the command
//! u = −k (p − q_hi) with k ≤ 1/τ and p = q + (1 − M̂) P, so the poles solve s + k (1 + M − M̂) = 0. While the real part of
//! 1 + M − M̂ is positive on the imaginary axis, no pole can cross it as k grows from 0.
//!
//! - Without lag and dead time M = 1, and the real part of M̂ is at most 1.
//! - With the stated dead time and a smaller lag L', |M − M̂| = |M| |(L − L') s/(1 + L s)| < 1.
//!
//! `tests/controller/drives.rs` covers the drives between.

use crate::linalg::Vector;

/// Maximum D. More is no arm but a network, whose delay varies.
pub const MAX_DRIVE_DELAY: usize = 64;

/// How the joints follow a command: after a dead time, with a first-order lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// L, time constant of the lag, s.
    pub lag_s: f64,
    /// D, dead time, whole periods; at most [`MAX_DRIVE_DELAY`].
    pub delay_periods: usize,
}

impl Drive {
    /// A drive that follows at once.
    pub const IDEAL: Self = Self { lag_s: 0.0, delay_periods: 0 };

    /// The drive of an arm about which nothing is known. Most arms are faster, and then they brake a little early.
    pub const CONSERVATIVE: Self = Self { lag_s: 0.03, delay_periods: 2 };

    /// Returns L + D T, the time for which joints at a constant velocity move on after the last command, s; `period`: T, s.
    pub fn time_to_rest(self, period: f64) -> f64 {
        self.lag_s + period * self.delay_periods as f64
    }
}

/// The commands that a drive still has to follow, and the velocity that it has reached.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveState {
    /// v, velocity of the joints behind the modelled drive, n, rad/s or m/s.
    pub velocity: Vector,
    /// u₁ … u_D, the commands on their way, n each, the oldest first.
    pub pending: Vec<Vector>,
}

impl DriveState {
    /// Returns the state of joints that have moved at a constant velocity (n) for long.
    pub fn moving(drive: Drive, velocity: &Vector) -> Self {
        Self { velocity: velocity.clone(), pending: vec![velocity.clone(); drive.delay_periods] }
    }

    /// Returns p − q of a joint: how far it moves on if all later commands are zero, rad or m; `period`: T, s.
    pub fn distance_to_rest(&self, drive: Drive, joint: usize, period: f64) -> f64 {
        let pending: f64 = self.pending.iter().map(|command| command[joint]).sum();
        drive.lag_s * self.velocity[joint] + period * pending
    }

    /// Returns how far a joint moves in a period T (s) in which `command` (n) is sent, rad or m.
    pub fn way(&self, drive: Drive, joint: usize, command: &Vector, period: f64) -> f64 {
        let acting = self.pending.first().unwrap_or(command)[joint];
        period * acting - (self.velocity[joint] - acting) * drive.lag_s * (-period / drive.lag_s).exp_m1()
    }

    /// Advances by one period T (s) in which `command` (n) is sent.
    pub fn advance(&mut self, drive: Drive, command: &Vector, period: f64) {
        let remaining = (-period / drive.lag_s).exp();
        let acting = self.pending.first().unwrap_or(command);
        self.velocity.zip_apply(acting, |v, u| *v = u + (*v - u) * remaining);
        if let Some(oldest) = self.pending.first_mut() {
            oldest.copy_from(command);
            self.pending.rotate_left(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const T: f64 = 0.004;

    #[test]
    fn an_ideal_drive_is_at_rest_at_once() {
        let mut state = DriveState::moving(Drive::IDEAL, &Vector::from_element(1, 2.0));
        assert_eq!(state.distance_to_rest(Drive::IDEAL, 0, T), 0.0);
        state.advance(Drive::IDEAL, &Vector::from_element(1, -1.0), T);
        assert_eq!(state.velocity[0], -1.0);
    }

    proptest! {
        /// The position of rest moves by T u, and the joint ends there.
        #[test]
        fn the_position_of_rest_integrates_the_commands(
            lag_s in 1e-4..0.1_f64,
            delay_periods in 0_usize..5,
            commands in prop::collection::vec(-2.0..2.0_f64, 30),
        ) {
            let drive = Drive { lag_s, delay_periods };
            let mut state = DriveState::moving(drive, &Vector::from_element(1, commands[0]));
            let (mut q, mut v) = (0.0, commands[0]);
            let mut sent = vec![commands[0]; delay_periods];
            let mut rest = q + state.distance_to_rest(drive, 0, T);
            for &command in commands.iter().chain(&[0.0; 400]) {
                sent.push(command);
                let acting = sent[sent.len() - 1 - delay_periods];
                let remaining = (-T / lag_s).exp();
                q += T * acting + (v - acting) * lag_s * (1.0 - remaining);
                v = acting + (v - acting) * remaining;
                state.advance(drive, &Vector::from_element(1, command), T);
                rest += T * command;
                prop_assert!((q + state.distance_to_rest(drive, 0, T) - rest).abs() < 1e-12);
            }
            prop_assert!((q - rest).abs() < 1e-6);
        }
    }
}

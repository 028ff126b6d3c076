//! The position law: `pose` on rows of the tool, `posture` on joints.

use super::motion_path::MotionPath;
use super::task_state::TaskState;
use super::task_vector::TaskVector;
use crate::linalg::Vector;

/// The position law ẋ = ẋ_d + f K (x_d − x), K diagonal, 1/s, with the factor f ≤ 1 of the braking profile.
///
/// On rows of the tool it is closed-loop inverse kinematics; on joints it is q̇ = q̇_d + f K (q_d − q). Near the target
/// f is 1, and the distance of each axis to its target decays as e^(−K t), exactly as (1 − K T)^i after i periods.
///
/// # Behind a drive
///
/// A controller whose [`Drive`](crate::limits::Drive) has a lag L or a dead time D T evaluates the law where its limits hold,
/// at the position of rest p: x is J (p − q) further than measured, and x_d is where the target will be, ẋ_d (L + D T)
/// further. In p the arm has neither lag nor dead time, so the decay above is exact for any K with K T < 2, to first order
/// in p − q. On a target at constant velocity p − q = (L + D T) q̇, so nothing is left behind.
///
/// Let M be the transfer function of the real drive and M̂ that of the stated one. The poles solve
/// s + K (1 + M − M̂) = 0, as those of a joint near a limit, with the same claims about drives that are faster than stated.
///
/// # The braking profile
///
/// The law ẋ = ẋ_d + K (x_d − x) alone demands the deceleration K |K (x_d − x)|. A distant target therefore demands more
/// than the joints can give, and the arm passes the target. So the law slows its feedback v = K (x_d − x) down to f v. Let
/// a be the deceleration that the joints can give, d = |v|/K the distance, and s(d) = f |v| the speed:
///
/// s(d) = K d up to the speed s_0 = φ a/K; beyond, d = s_0/K + θ (s − s_0) + (s² − s_0²)/2a with θ = (1 − φ)/K.
///
/// - Up to s_0 the factor is 1: small errors are corrected by the bare gain, exactly.
/// - Beyond, s is the speed from which the arm stops at a, after it has moved on for the reaction time θ.
/// - Both parts have the slope K where they meet, so s is continuously differentiable.
/// - A point that moves at s(d) decelerates by s s′: K² d ≤ φ a on the first part, and a s/(s + θ a) < a on the second.
///
/// φ follows from the reaction time τ of the controller, φ = 1 − K τ, but is at least 0.1. Without
/// reaction time, φ = 1 and s = √(2 a (d − a/2K²)). With ρ = a/(K |v|), the available deceleration over the demanded one,
///
/// f(ρ) = ρ (φ − 1 + √(1 + 2/ρ − 2φ)) for ρ φ < 1, otherwise 1.
///
/// For joints with a jerk limit, τ is longer and a may be smaller, so that the profile keeps the jerk too.
///
/// The controller finds a: see [`BRAKING_SHARE`](crate::controller::BRAKING_SHARE).
///
/// # Looking ahead
///
/// A law with a [path](MotionPath) does not wait for its feedback: the controller moves a virtual arm to the targets ahead, and the joints
/// follow it with all of their acceleration. The velocity above remains for periods in which the virtual arm jumps, and for predicted
/// motions that the joints cannot follow. `docs/fast.md` in the repository has the rule and what was measured.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLaw {
    gain: Vector,
    braking: Braking,
    path: Option<MotionPath>,
}

/// How a position law slows down before its target.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Braking {
    /// With the acceleration limits of the joints.
    #[default]
    Joints,
    /// With the acceleration limits of the joints, and at most with these accelerations, one entry per row, m/s² and
    /// rad/s².
    AtMost(Vector),
    /// Not at all: the bare gain, f = 1. On an arm whose joints have acceleration limits it may pass its target.
    None,
}

/// Why a position law is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum PositionLawError {
    /// A gain is negative or not finite.
    #[error("{value} is out of range; a gain must not be negative")]
    Gain {
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// A maximum acceleration is not positive or not finite.
    #[error("{value} is out of range; a maximum acceleration must be positive")]
    Acceleration {
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
    /// The number of accelerations is not the number of gains.
    #[error("{given} accelerations for {expected} rows; give one per row")]
    Size {
        /// Rows of the law.
        expected: usize,
        /// Accelerations given.
        given: usize,
    },
}

impl PositionLaw {
    /// Checks and builds a law with K = `gain`, one entry per row, 1/s. It brakes with the limits of the joints.
    pub fn new(gain: Vec<f64>) -> Result<Self, PositionLawError> {
        Self::with_braking(gain, Braking::default())
    }

    /// Checks and builds a law with K = `gain`, one entry per row, 1/s, that brakes in this way.
    pub fn with_braking(gain: Vec<f64>, braking: Braking) -> Result<Self, PositionLawError> {
        if let Some((row, &value)) = gain.iter().enumerate().find(|(_, value)| !(value.is_finite() && **value >= 0.0)) {
            return Err(PositionLawError::Gain { row, value });
        }
        if let Braking::AtMost(accelerations) = &braking {
            let (expected, given) = (gain.len(), accelerations.len());
            if given != expected {
                return Err(PositionLawError::Size { expected, given });
            }
            let mut values = accelerations.iter().enumerate();
            if let Some((row, &value)) = values.find(|(_, value)| !(value.is_finite() && **value > 0.0)) {
                return Err(PositionLawError::Acceleration { row, value });
            }
        }
        Ok(Self { gain: Vector::from_vec(gain), braking, path: None })
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.gain.len()
    }

    /// Returns the diagonal of K, 1/s.
    pub fn gain(&self) -> &Vector {
        &self.gain
    }

    /// Returns how the law slows down before its target.
    pub fn braking(&self) -> &Braking {
        &self.braking
    }

    /// Returns the law that looks ahead and moves along a path.
    #[must_use]
    pub fn along(self, path: MotionPath) -> Self {
        Self { path: Some(path), ..self }
    }

    /// Returns the path on which the law looks ahead; `None`: it does not.
    pub fn path(&self) -> Option<MotionPath> {
        self.path
    }

    /// Returns v = −K ΔX, the feedback before braking, m/s and rad/s.
    pub fn feedback(&self, state: &TaskState) -> TaskVector {
        TaskVector::from_fn(self.rows(), |row| -self.gain[row] * state.displacement[row])
    }

    /// Returns ẋ_d − K ΔX, the velocity before braking, m/s and rad/s.
    pub fn velocity(&self, state: &TaskState) -> TaskVector {
        let velocity = |row: usize| state.target_velocity[row] - self.gain[row] * state.displacement[row];
        TaskVector::from_fn(self.rows(), velocity)
    }
}

/// Minimum of φ: at this share of its usual range the bare gain remains in force, however large K is.
const MIN_LINEAR_SHARE: f64 = 0.1;

/// Returns φ of [`PositionLaw`]; `gain`: K, 1/s; `reaction`: τ, s.
pub(crate) fn linear_share(gain: f64, reaction: f64) -> f64 {
    (1.0 - gain * reaction).max(MIN_LINEAR_SHARE)
}

/// Returns f(ρ) of [`PositionLaw`], from the available deceleration over the demanded one (`ratio`: ρ ≥ 0) and φ (`linear`).
pub(crate) fn braking_factor(ratio: f64, linear: f64) -> f64 {
    if ratio * linear < 1.0 {
        // ρ √(1 + 2/ρ − 2φ), also for ρ = 0.
        let root = (ratio * (ratio * (1.0 - 2.0 * linear) + 2.0)).sqrt();
        (root - ratio * (1.0 - linear)).min(1.0)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// s(d) for a gain, a deceleration and φ.
    fn speed(distance: f64, gain: f64, deceleration: f64, linear: f64) -> f64 {
        let bare = gain * distance;
        bare * braking_factor(deceleration / (gain * bare), linear)
    }

    #[test]
    fn near_the_target_the_speed_is_that_of_the_bare_gain_to_the_last_bit() {
        let (gain, a) = (10.0, 4.0);
        for linear in [0.2, 0.7, 1.0] {
            for share in [0.0, 1e-9, 0.1, 0.999] {
                let distance = share * linear * a / gain / gain;
                assert_eq!(speed(distance, gain, a, linear), gain * distance);
            }
        }
    }

    #[test]
    fn far_from_the_target_the_arm_can_stop_after_its_reaction_time() {
        let (gain, a) = (10.0, 4.0);
        for linear in [0.2, 0.7, 1.0] {
            let (start, reaction) = (linear * a / gain, (1.0 - linear) / gain);
            for distance in [1.001 * start / gain, 0.1, 1.0, 100.0] {
                let s = speed(distance, gain, a, linear);
                let stop = start / gain + reaction * (s - start) + (s * s - start * start) / (2.0 * a);
                assert!((stop / distance - 1.0).abs() < 1e-12, "{linear} {distance}: {stop}");
            }
        }
        assert_eq!(braking_factor(0.0, 1.0), 0.0);
    }

    #[test]
    fn speed_and_slope_are_continuous_where_the_parts_meet() {
        for (gain, a, linear) in [(2.0, 5.0, 1.0), (50.0, 3.0, 0.2), (10.0, 0.1, 0.6)] {
            let meeting = linear * a / gain / gain;
            let at = |share: f64| speed(share * meeting, gain, a, linear);
            assert!((at(1.0) - gain * meeting).abs() < 1e-12 * at(1.0));
            for (from, to) in [(1.0 - 1e-6, 1.0), (1.0, 1.0 + 1e-6)] {
                let slope = (at(to) - at(from)) / (to - from) / meeting;
                assert!((slope / gain - 1.0).abs() < 1e-4, "{slope} {gain}");
            }
        }
    }

    #[test]
    fn a_long_reaction_time_leaves_a_tenth_of_the_linear_range() {
        assert_eq!([linear_share(10.0, 0.0), linear_share(10.0, 0.02), linear_share(50.0, 1.0)], [1.0, 0.8, 0.1]);
    }

    #[test]
    fn impossible_laws_do_not_exist() {
        let at_most = |values: &[f64]| {
            PositionLaw::with_braking(vec![1.0, 2.0], Braking::AtMost(Vector::from_row_slice(values))).unwrap_err()
        };
        assert_eq!(PositionLaw::new(vec![1.0, -2.0]), Err(PositionLawError::Gain { row: 1, value: -2.0 }));
        assert_eq!(at_most(&[1.0]), PositionLawError::Size { expected: 2, given: 1 });
        assert_eq!(at_most(&[1.0, 0.0]), PositionLawError::Acceleration { row: 1, value: 0.0 });
        assert!(matches!(at_most(&[f64::NAN, 1.0]), PositionLawError::Acceleration { row: 0, .. }));
    }
}

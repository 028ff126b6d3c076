//! The position law: `pose` on rows of the tool, `posture` on joints.

use super::TaskState;
use crate::linalg::{TaskVector, Vector};

/// The position law ẋ = ẋ_d + K (x_d − x), K diagonal, 1/s.
///
/// On rows of the tool it is closed-loop inverse kinematics; on joints it is q̇ = q̇_d + K (q_d − q). The distance of
/// each axis to its target decays as e^(−K t), exactly as (1 − K T)^i after i periods.
#[derive(Debug, Clone, PartialEq)]
pub struct PositionLaw {
    gain: Vector,
}

/// Error: a gain is negative or not finite.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{value} is out of range; a gain must not be negative")]
pub struct GainRangeError {
    /// Row, from 0.
    pub row: usize,
    /// The value.
    pub value: f64,
}

impl PositionLaw {
    /// Checks and builds a law with K = `gain`, one entry per row, 1/s.
    pub fn new(gain: Vec<f64>) -> Result<Self, GainRangeError> {
        match gain.iter().enumerate().find(|(_, value)| !(value.is_finite() && **value >= 0.0)) {
            Some((row, &value)) => Err(GainRangeError { row, value }),
            None => Ok(Self { gain: Vector::from_vec(gain) }),
        }
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.gain.len()
    }

    /// Returns the diagonal of K, 1/s.
    pub fn gain(&self) -> &Vector {
        &self.gain
    }

    /// Returns ẋ_d − K ΔX, m/s and rad/s.
    pub fn velocity(&self, state: &TaskState) -> TaskVector {
        let velocity = |row: usize| state.target_velocity[row] - self.gain[row] * state.displacement[row];
        TaskVector::from_fn(self.rows(), velocity)
    }
}

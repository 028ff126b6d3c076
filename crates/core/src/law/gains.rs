//! Inertia, damping and stiffness of a law.

use super::task_vector::TaskVector;
use crate::linalg::Vector;

/// Inertia M_d, damping B_d and stiffness K_d of one task, diagonal, m entries each.
///
/// Linear rows: kg, N·s/m, N/m; angular rows: kg·m², N·m·s/rad, N·m/rad.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    inertia: Vector,
    damping: Vector,
    stiffness: Vector,
}

/// Why gains are refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GainError {
    /// The number of values is not the number of axes.
    #[error("{given} values for {expected} axes; give one per axis")]
    Size {
        /// The gain: `inertia`, `damping` or `stiffness`.
        gain: &'static str,
        /// Axes of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A value is not finite, an inertia is not positive, or a damping or stiffness is negative.
    #[error("{value} is out of range; inertia must be positive, damping and stiffness must not be negative")]
    Range {
        /// The gain: `inertia`, `damping` or `stiffness`.
        gain: &'static str,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
}

impl Gains {
    /// Checks and builds the gains for `rows` axes; each slice has one value per axis.
    pub fn new(rows: usize, inertia: &[f64], damping: &[f64], stiffness: &[f64]) -> Result<Self, GainError> {
        check("inertia", rows, inertia, |value| value > 0.0)?;
        check("damping", rows, damping, |value| value >= 0.0)?;
        check("stiffness", rows, stiffness, |value| value >= 0.0)?;
        Ok(Self {
            inertia: Vector::from_row_slice(inertia),
            damping: Vector::from_row_slice(damping),
            stiffness: Vector::from_row_slice(stiffness),
        })
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.inertia.len()
    }

    /// Returns the diagonal of B_d.
    pub fn damping(&self) -> &Vector {
        &self.damping
    }

    /// Returns the diagonal of K_d.
    pub fn stiffness(&self) -> &Vector {
        &self.stiffness
    }

    /// Returns M_d⁻¹ f, where `force` gives the entry of f on each row.
    pub(super) fn accelerate(&self, force: impl Fn(usize) -> f64) -> TaskVector {
        TaskVector::from_fn(self.rows(), |row| force(row) / self.inertia[row])
    }
}

fn check(gain: &'static str, rows: usize, values: &[f64], valid: impl Fn(f64) -> bool) -> Result<(), GainError> {
    if values.len() != rows {
        return Err(GainError::Size { gain, expected: rows, given: values.len() });
    }
    match values.iter().enumerate().find(|(_, value)| !(value.is_finite() && valid(**value))) {
        Some((row, &value)) => Err(GainError::Range { gain, row, value }),
        None => Ok(()),
    }
}

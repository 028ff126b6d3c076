//! Inertia, damping and stiffness that a law gives the arm to feel like.

use crate::linalg::{TaskVector, Vector};

/// Diagonal M_d, B_d, K_d of one task, m entries each.
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
    /// One value per axis.
    #[error("{given} values for {expected} axes; give one per axis")]
    Size {
        /// Which gain: `inertia`, `damping` or `stiffness`.
        gain: &'static str,
        /// Axes of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A mass must be positive; damping and stiffness must not be negative; all must be finite.
    #[error("{value} is out of range; inertia must be positive, damping and stiffness must not be negative")]
    Range {
        /// Which gain.
        gain: &'static str,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
}

impl Gains {
    /// Gains for `rows` axes; each slice has one value per axis.
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

    /// m.
    pub fn rows(&self) -> usize {
        self.inertia.len()
    }

    /// B_d, diagonal.
    pub fn damping(&self) -> &Vector {
        &self.damping
    }

    /// K_d, diagonal.
    pub fn stiffness(&self) -> &Vector {
        &self.stiffness
    }

    /// M_d⁻¹ f, of the force on each row.
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

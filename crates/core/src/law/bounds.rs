//! Bounds of a velocity in place of a velocity.

use super::task_state::TaskState;
use super::task_vector::TaskVector;
use crate::linalg::Vector;

/// Constant bounds lower ≤ ẋ ≤ upper, m entries each, m/s and rad/s; infinite where there is no bound.
///
/// They make the task an inequality task. Inside its bounds it asks for nothing, and lower tasks are free.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityBounds {
    lower: Vector,
    upper: Vector,
}

/// Why bounds are refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VelocityBoundsError {
    /// The numbers of lower and upper bounds differ.
    #[error("{lower} lower and {upper} upper bounds; give one of each per row")]
    Size {
        /// Lower bounds given.
        lower: usize,
        /// Upper bounds given.
        upper: usize,
    },
    /// No finite velocity lies between the bounds of a row, or a bound is NaN.
    #[error("lower bound {lower} is not at or below upper bound {upper}")]
    Empty {
        /// Row, from 0.
        row: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

impl VelocityBounds {
    /// Checks and builds bounds with one lower and one upper bound per row; −∞ and +∞ are no bounds.
    pub fn new(lower: Vec<f64>, upper: Vec<f64>) -> Result<Self, VelocityBoundsError> {
        if lower.len() != upper.len() {
            return Err(VelocityBoundsError::Size { lower: lower.len(), upper: upper.len() });
        }
        // False for NaN.
        let allows =
            |row: usize| lower[row] <= upper[row] && lower[row] < f64::INFINITY && upper[row] > f64::NEG_INFINITY;
        match (0..lower.len()).find(|&row| !allows(row)) {
            Some(row) => Err(VelocityBoundsError::Empty { row, lower: lower[row], upper: upper[row] }),
            None => Ok(Self { lower: Vector::from_vec(lower), upper: Vector::from_vec(upper) }),
        }
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.lower.len()
    }

    /// Returns the lower bounds, m.
    pub fn lower(&self) -> &Vector {
        &self.lower
    }

    /// Returns the upper bounds, m.
    pub fn upper(&self) -> &Vector {
        &self.upper
    }

    /// Returns the allowed velocity nearest to `velocity`, m entries each.
    pub fn nearest(&self, velocity: &[f64]) -> TaskVector {
        TaskVector::from_fn(self.rows(), |row| velocity[row].max(self.lower[row]).min(self.upper[row]))
    }

    /// Returns the allowed velocity nearest to the measured one.
    pub(super) fn velocity(&self, state: &TaskState) -> TaskVector {
        self.nearest(&state.velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_without_a_velocity_between_them_are_refused() {
        let new = |lower: f64, upper: f64| VelocityBounds::new(vec![0.0, lower], vec![0.0, upper]);
        assert_eq!(new(0.1, 0.0), Err(VelocityBoundsError::Empty { row: 1, lower: 0.1, upper: 0.0 }));
        assert!(matches!(new(f64::NAN, 0.0), Err(VelocityBoundsError::Empty { row: 1, .. })));
        assert!(new(f64::INFINITY, f64::INFINITY).is_err() && new(f64::NEG_INFINITY, f64::NEG_INFINITY).is_err());
        assert!(new(f64::NEG_INFINITY, f64::INFINITY).is_ok() && new(0.1, 0.1).is_ok());
        assert_eq!(VelocityBounds::new(vec![0.0], vec![]), Err(VelocityBoundsError::Size { lower: 1, upper: 0 }));
    }

    #[test]
    fn the_nearest_allowed_velocity_is_on_the_exceeded_bound() {
        let bounds = VelocityBounds::new(vec![-1.0, f64::NEG_INFINITY, 0.5], vec![1.0, 0.0, f64::INFINITY]).unwrap();
        assert_eq!(&bounds.nearest(&[2.0, -3.0, 0.0])[..], &[1.0, -3.0, 0.5]);
    }
}

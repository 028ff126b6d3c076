//! The velocity box: lower and upper bounds of the joint velocities.

use crate::Vector;

/// Why a box is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VelocityBoxError {
    /// The numbers of lower and upper bounds differ.
    #[error("{lower} lower and {upper} upper bounds; give one of each per joint")]
    Size {
        /// Lower bounds given.
        lower: usize,
        /// Upper bounds given.
        upper: usize,
    },
    /// No finite velocity lies between the bounds, or a bound is NaN.
    #[error("lower bound {lower} is not at or below upper bound {upper}")]
    Empty {
        /// Joint index, from 0.
        joint: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

/// The box lo ≤ q̇ ≤ hi, never empty; rad/s (m/s for prismatic joints); infinite where there is no limit.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityBox {
    lower: Vector,
    upper: Vector,
}

impl VelocityBox {
    /// Checks and builds a box from its bounds, n each.
    pub fn new(lower: &[f64], upper: &[f64]) -> Result<Self, VelocityBoxError> {
        if lower.len() != upper.len() {
            return Err(VelocityBoxError::Size { lower: lower.len(), upper: upper.len() });
        }
        // False for NaN, and for a bound that only an infinite velocity satisfies.
        let allows = |i: usize| lower[i] <= upper[i] && lower[i] < f64::INFINITY && upper[i] > f64::NEG_INFINITY;
        if let Some(joint) = (0..lower.len()).find(|&i| !allows(i)) {
            return Err(VelocityBoxError::Empty { joint, lower: lower[joint], upper: upper[joint] });
        }
        Ok(Self { lower: Vector::from_row_slice(lower), upper: Vector::from_row_slice(upper) })
    }

    /// Returns the box without bounds, for n joints.
    pub fn unbounded(n: usize) -> Self {
        Self { lower: Vector::repeat(n, f64::NEG_INFINITY), upper: Vector::repeat(n, f64::INFINITY) }
    }

    /// Copies a box for the same number of joints, without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.lower.as_mut_slice().copy_from_slice(other.lower.as_slice());
        self.upper.as_mut_slice().copy_from_slice(other.upper.as_slice());
    }

    /// Overwrites the bounds of a joint: a number, or infinite on its own side, with lower ≤ upper.
    pub fn set_joint(&mut self, joint: usize, lower: f64, upper: f64) {
        debug_assert!(lower <= upper, "{lower} to {upper} is empty");
        (self.lower[joint], self.upper[joint]) = (lower, upper);
    }

    /// Returns lo, n.
    pub fn lower(&self) -> &Vector {
        &self.lower
    }

    /// Returns hi, n.
    pub fn upper(&self) -> &Vector {
        &self.upper
    }

    /// Returns n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.lower.len()
    }

    /// Returns the point of the box nearest to `velocity`.
    pub fn clamp(&self, velocity: &Vector) -> Vector {
        velocity.zip_zip_map(&self.lower, &self.upper, |v, lo, hi| v.max(lo).min(hi))
    }

    /// Returns whether `velocity` (n) lies inside; false if an entry is NaN.
    pub fn allows(&self, velocity: &[f64]) -> bool {
        let bounds = self.lower.iter().zip(self.upper.iter());
        velocity.iter().zip(bounds).all(|(v, (lower, upper))| lower <= v && v <= upper)
    }

    /// Returns the largest distance of an entry of `velocity` from the box, rad/s; 0 inside.
    pub fn violation(&self, velocity: &Vector) -> f64 {
        (velocity - self.clamp(velocity)).amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_allows_its_bounds_and_nothing_outside() {
        let bounds = VelocityBox::new(&[-1.0, 0.0], &[2.0, 0.0]).unwrap();
        let entries = |vector: &Vector| vector.iter().copied().collect::<Vec<_>>();
        assert_eq!((entries(bounds.lower()), entries(bounds.upper())), (vec![-1.0, 0.0], vec![2.0, 0.0]));
        for inside in [[-1.0, 0.0], [0.5, 0.0], [2.0, 0.0]] {
            assert!(bounds.allows(&inside) && bounds.violation(&Vector::from_vec(inside.into())) == 0.0, "{inside:?}");
        }
        for outside in [[-1.5, 0.0], [2.5, 0.0], [0.0, 0.5], [0.0, -0.5]] {
            assert!(!bounds.allows(&outside), "{outside:?}");
            assert_eq!(bounds.violation(&Vector::from_vec(outside.into())), 0.5, "{outside:?}");
        }
        assert!(!bounds.allows(&[f64::NAN, 0.0]));
    }

    #[test]
    fn empty_boxes_are_refused() {
        assert!(matches!(VelocityBox::new(&[0.0, 1.0], &[0.0, 0.5]), Err(VelocityBoxError::Empty { joint: 1, .. })));
        assert!(matches!(VelocityBox::new(&[f64::NAN], &[0.0]), Err(VelocityBoxError::Empty { joint: 0, .. })));
        assert!(matches!(VelocityBox::new(&[0.0], &[]), Err(VelocityBoxError::Size { .. })));
    }
}

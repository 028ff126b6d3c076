//! Linear inequalities on the joint velocities.

use std::sync::Arc;

use crate::Vector;

/// The inequality a·q̇ ≤ b, for example a virtual wall or a coupling of joints: a constraint, or one of its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Inequality {
    name: Arc<str>,
    row: usize,
    coefficients: Vector,
    bound: f64,
    level: u8,
}

/// The level of an inequality that states none. Levels are counted from 0, the highest: an inequality yields to those of higher levels.
pub const LOWEST_CONSTRAINT_LEVEL: u8 = 2;

/// Why an inequality is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum InequalityError {
    /// A coefficient or the bound is NaN or infinite.
    #[error("coefficients and bound must be finite numbers")]
    NotFinite,
    /// All coefficients are zero.
    #[error("at least one coefficient must differ from zero")]
    Zero,
}

impl Inequality {
    /// Checks and builds an inequality from a (`coefficients`, one per joint, any unit) and b (`bound`, in that unit
    /// times rad/s, or m/s for prismatic joints).
    pub fn new(name: impl Into<Arc<str>>, coefficients: Vec<f64>, bound: f64) -> Result<Self, InequalityError> {
        let coefficients = Vector::from_vec(coefficients);
        if !(bound.is_finite() && coefficients.iter().all(|a| a.is_finite())) {
            return Err(InequalityError::NotFinite);
        }
        let norm = coefficients.norm();
        if !(norm.is_normal() || norm.is_infinite()) {
            return Err(InequalityError::Zero);
        }
        Ok(Self { name: name.into(), row: 0, coefficients, bound, level: LOWEST_CONSTRAINT_LEVEL })
    }

    /// Returns 0·q̇ ≤ ∞ for n joints, which always holds, as row `row` (from 0) of the constraint with this name.
    pub fn always_satisfied(name: Arc<str>, row: usize, n: usize) -> Self {
        let coefficients = Vector::zeros(n);
        Self { name, row, coefficients, bound: f64::INFINITY, level: LOWEST_CONSTRAINT_LEVEL }
    }

    /// Overwrites a and b without allocating. `write` overwrites a, n entries, and returns b. The checks of [`Self::new`] are not
    /// repeated: `write` must return finite numbers, or zeros and ∞ for an inequality that always holds.
    pub fn overwrite(&mut self, write: impl FnOnce(&mut [f64]) -> f64) {
        self.bound = write(self.coefficients.as_mut_slice());
    }

    /// Gives the row another name.
    pub fn rename(&mut self, name: &Arc<str>) {
        if !Arc::ptr_eq(&self.name, name) {
            self.name = Arc::clone(name);
        }
    }

    /// Puts the row into a level, 0 to [`LOWEST_CONSTRAINT_LEVEL`].
    pub fn set_level(&mut self, level: u8) {
        self.level = level.min(LOWEST_CONSTRAINT_LEVEL);
    }

    /// Copies name, level and numbers of another row for as many joints, without allocating. The index of the row stays.
    pub fn copy_from(&mut self, other: &Self) {
        self.rename(&other.name);
        self.level = other.level;
        self.coefficients.copy_from(&other.coefficients);
        self.bound = other.bound;
    }

    /// Returns the name that answers use.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the name that answers use, without copying its text.
    pub fn shared_name(&self) -> Arc<str> {
        Arc::clone(&self.name)
    }

    /// Returns the index of this row in its constraint, from 0. A constraint of one row has the row 0.
    pub fn row(&self) -> usize {
        self.row
    }

    /// Returns the level among the constraints, 0 for the highest.
    pub fn level(&self) -> u8 {
        self.level
    }

    /// Returns a, n.
    pub fn coefficients(&self) -> &Vector {
        &self.coefficients
    }

    /// Returns b.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Returns a·q̇, for q̇ of n entries.
    pub fn value(&self, joint_velocity: &Vector) -> f64 {
        self.coefficients.dot(joint_velocity)
    }

    /// Returns the excess of a·q̇ over b in units of joint speed, (a·q̇ − b)/‖a‖; 0 if it is not above rounding.
    pub fn violation(&self, joint_velocity: &Vector) -> f64 {
        let norm = self.coefficients.norm();
        if norm == 0.0 {
            return 0.0;
        }
        let excess = (self.value(joint_velocity) - self.bound) / norm;
        if excess > ROUNDING * (joint_velocity.norm() + self.bound.abs() / norm) { excess } else { 0.0 }
    }
}

/// Relative excess that counts as rounding of a·q̇.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inequalities_without_content_are_refused() {
        assert_eq!(Inequality::new("", vec![0.0, 0.0], 1.0), Err(InequalityError::Zero));
        assert_eq!(Inequality::new("", vec![1.0, f64::NAN], 1.0), Err(InequalityError::NotFinite));
        assert_eq!(Inequality::new("", vec![1.0], f64::INFINITY), Err(InequalityError::NotFinite));
    }

    #[test]
    fn a_violation_is_measured_as_joint_speed() {
        let wall = Inequality::new("wall", vec![3.0, 4.0], 5.0).unwrap();
        assert_eq!(wall.name(), "wall");
        assert_eq!(wall.violation(&Vector::from_vec(vec![3.0, 4.0])), 4.0);
        assert_eq!(wall.violation(&Vector::from_vec(vec![0.6, 0.8])), 0.0);
    }

    #[test]
    fn rounding_of_fast_joints_is_no_violation() {
        let sum = Inequality::new("sum", vec![1.0, 1.0], 0.0).unwrap();
        let excess = |difference: f64| sum.violation(&Vector::from_vec(vec![1e3, difference - 1e3]));
        assert_eq!(excess(1e-10), 0.0);
        assert!(excess(1e-6) > 0.0);
        // A short row: its bound is that of a fast joint.
        let short = Inequality::new("short", vec![1e-3, 0.0], 1.0).unwrap();
        let excess = |relative: f64| short.violation(&Vector::from_vec(vec![1e3 * (1.0 + relative), 0.0]));
        assert_eq!(excess(1.5e-12), 0.0);
        assert!(excess(3e-12) > 0.0);
    }
}

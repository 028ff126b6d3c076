//! Linear inequalities beside the box.

use crate::linalg::Vector;

/// a·q̇ ≤ b: a virtual wall, an elbow plane, a coupling of joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Inequality {
    pub(super) name: String,
    pub(super) coefficients: Vector,
    pub(super) bound: f64,
}

/// Why an inequality is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum InequalityError {
    /// A coefficient or the bound is NaN or infinite.
    #[error("coefficients and bound must be finite numbers")]
    NotFinite,
    /// Without a coefficient, it says nothing about any joint.
    #[error("at least one coefficient must differ from zero")]
    Zero,
}

impl Inequality {
    /// `coefficients`: a, one per joint, any unit; `bound`: b, in that unit times rad/s (m/s for prismatic joints).
    pub fn new(name: impl Into<String>, coefficients: Vec<f64>, bound: f64) -> Result<Self, InequalityError> {
        let coefficients = Vector::from_vec(coefficients);
        if !(bound.is_finite() && coefficients.iter().all(|a| a.is_finite())) {
            return Err(InequalityError::NotFinite);
        }
        if !coefficients.norm().is_normal() {
            return Err(InequalityError::Zero);
        }
        Ok(Self { name: name.into(), coefficients, bound })
    }

    /// 0·q̇ ≤ ∞ for n joints: holds always.
    pub(super) fn without_content(name: String, n: usize) -> Self {
        Self { name, coefficients: Vector::zeros(n), bound: f64::INFINITY }
    }

    /// Name, for people and answers.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// a, n.
    pub fn coefficients(&self) -> &Vector {
        &self.coefficients
    }

    /// b.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// a·q̇, for q̇ of n entries.
    pub fn value(&self, joint_velocity: &Vector) -> f64 {
        self.coefficients.dot(joint_velocity)
    }

    /// By how much a·q̇ exceeds b, in units of joint speed, (a·q̇ − b)/‖a‖; 0 where it does not by more than rounding.
    pub fn violation(&self, joint_velocity: &Vector) -> f64 {
        let norm = self.coefficients.norm();
        if norm == 0.0 {
            return 0.0;
        }
        let excess = (self.value(joint_velocity) - self.bound) / norm;
        if excess > ROUNDING * (joint_velocity.norm() + self.bound.abs() / norm) { excess } else { 0.0 }
    }
}

/// Relative excess that is rounding of a·q̇.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inequalities_that_say_nothing_do_not_exist() {
        assert_eq!(Inequality::new("", vec![0.0, 0.0], 1.0), Err(InequalityError::Zero));
        assert_eq!(Inequality::new("", vec![1.0, f64::NAN], 1.0), Err(InequalityError::NotFinite));
        assert_eq!(Inequality::new("", vec![1.0], f64::INFINITY), Err(InequalityError::NotFinite));
    }

    #[test]
    fn a_violation_counts_in_joint_speed() {
        let wall = Inequality::new("wall", vec![3.0, 4.0], 5.0).unwrap();
        assert_eq!(wall.violation(&Vector::from_vec(vec![3.0, 4.0])), 4.0);
        assert_eq!(wall.violation(&Vector::from_vec(vec![0.6, 0.8])), 0.0);
    }
}

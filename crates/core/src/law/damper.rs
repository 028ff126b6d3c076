//! A damper: the tool yields to a push, and stands where it is left.

use super::{TaskState, TaskVector};

/// ẋ = −B_d⁻¹ F_e.
#[derive(Debug, Clone, PartialEq)]
pub struct DamperLaw {
    /// B_d, m, N s/m and N m s.
    damping: Vec<f64>,
}

impl DamperLaw {
    /// Builds the law; `None` if a damping is not a positive number.
    pub fn new(damping: Vec<f64>) -> Option<Self> {
        damping.iter().all(|entry| entry.is_finite() && *entry > 0.0).then_some(Self { damping })
    }

    /// Returns m, the number of rows.
    pub(super) fn rows(&self) -> usize {
        self.damping.len()
    }

    /// Returns ẋ, m.
    pub(super) fn velocity(&self, state: &TaskState) -> TaskVector {
        TaskVector::from_fn(self.damping.len(), |row| -state.force[row] / self.damping[row])
    }
}

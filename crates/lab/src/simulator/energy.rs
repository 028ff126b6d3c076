//! Energy of the contacts.

use std::iter::Sum;

use serde::{Deserialize, Serialize};

/// Energy of all contacts since the start, J.
///
/// Work is integrated over distance, dissipation over time. Their balance therefore shows how well the time steps resolve
/// the contact.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Energy {
    /// Work of the tool and of moving surfaces on the contacts: ∫ F_e d(X − X_0).
    pub work_j: f64,
    /// Energy stored in the contacts: ½ K_e (X − X_0)² + ½ M_e (Ẋ − Ẋ_0)².
    pub stored_j: f64,
    /// Energy dissipated by damping, friction and impacts.
    pub dissipated_j: f64,
}

impl Energy {
    /// Returns the work that is neither stored nor dissipated, J: 0 except for the error of the time steps.
    pub fn imbalance_j(&self) -> f64 {
        self.work_j - self.stored_j - self.dissipated_j
    }
}

impl Sum for Energy {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |sum, part| Self {
            work_j: sum.work_j + part.work_j,
            stored_j: sum.stored_j + part.stored_j,
            dissipated_j: sum.dissipated_j + part.dissipated_j,
        })
    }
}

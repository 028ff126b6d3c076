//! What contacts take from the tool, keep and turn into heat.

use std::iter::Sum;

use serde::{Deserialize, Serialize};

/// Energy of all contacts together since the start, J.
///
/// Work and dissipation are summed up independently of each other, the one over ways, the other over time, so that their
/// balance tells how well the periods resolve the contact.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Energy {
    /// Work done on the contacts, by the tool and by surfaces that move: ∫ F_e d(X − X_0).
    pub work_j: f64,
    /// What they give back: ½ K_e (X − X_0)² + ½ M_e (Ẋ − Ẋ_0)².
    pub stored_j: f64,
    /// What damping, friction, and impacts have turned into heat.
    pub dissipated_j: f64,
}

impl Energy {
    /// Work that is neither stored nor dissipated, J: 0 but for the length of the steps.
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

//! The force law.

use super::{Gains, Profile, TaskState};
use crate::linalg::TaskVector;

/// M_d Ẍ + B_d Ẋ − F_d = −F_e: push until the contact pushes back as asked.
///
/// Paper: Eqs. (35), (38)-(42).
#[derive(Debug, Clone, PartialEq)]
pub struct ForceLaw {
    gains: Gains,
    target_force: Profile,
}

impl ForceLaw {
    /// `target_force`: F_d, N and N·m, as many rows as the gains; `None` if they differ.
    pub fn new(gains: Gains, target_force: Profile) -> Option<Self> {
        (gains.rows() == target_force.rows()).then_some(Self { gains, target_force })
    }

    /// m.
    pub fn rows(&self) -> usize {
        self.gains.rows()
    }

    /// F_d at time t, N and N·m.
    pub fn target_force(&self, time_s: f64) -> TaskVector {
        TaskVector::from_slice(&self.target_force.at(time_s).value)
    }

    /// Ẍ = M_d⁻¹ (F_d − F_e − B_d Ẋ), m/s² and rad/s².
    pub fn acceleration(&self, state: &TaskState) -> TaskVector {
        let (target, damping) = (self.target_force(state.time_s), self.gains.damping());
        self.gains.accelerate(|row| target[row] - state.force[row] - damping[row] * state.velocity[row])
    }
}

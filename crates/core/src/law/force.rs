//! The force law.
//!
//! It gives an acceleration from the measured wrench. [`Law`](super::Law) integrates it to the velocity of the task.

use revprio_robot::profile::Profile;

use super::gains::Gains;
use super::task_state::TaskState;
use super::task_vector::TaskVector;

/// The force law M_d Ẍ + B_d Ẋ − F_d = −F_e: the tool pushes until the contact force F_e equals F_d.
///
/// Paper: Eqs. (35), (38)-(42).
#[derive(Debug, Clone, PartialEq)]
pub struct ForceLaw {
    gains: Gains,
    pub(super) target_force: Profile,
}

impl ForceLaw {
    /// Builds a law with F_d = `target_force`, N and N·m; `None` unless it has as many rows as the gains.
    pub fn new(gains: Gains, target_force: Profile) -> Option<Self> {
        (gains.rows() == target_force.rows()).then_some(Self { gains, target_force })
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.gains.rows()
    }

    /// Returns F_d at time t, N and N·m.
    pub fn target_force(&self, time_s: f64) -> TaskVector {
        TaskVector::from_slice(&self.target_force.at(time_s).value)
    }

    /// Returns Ẍ = M_d⁻¹ (F_d − F_e − B_d Ẋ), m/s² and rad/s².
    pub fn acceleration(&self, state: &TaskState) -> TaskVector {
        let (target, damping) = (state.set_point(&self.target_force), self.gains.damping());
        self.gains.accelerate(|row| target[row] - state.force[row] - damping[row] * state.velocity[row])
    }
}

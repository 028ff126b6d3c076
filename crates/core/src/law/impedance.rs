//! The impedance law.
//!
//! It gives an acceleration from the measured wrench. [`Law`](super::Law) integrates it to the velocity of the task.

use super::gains::Gains;
use super::task_state::TaskState;
use super::task_vector::TaskVector;

/// The impedance law M_d ΔẌ + B_d ΔẊ + K_d ΔX = −F_e: the tool yields like mass, damper and spring about a target X_d,
/// which may move.
///
/// Paper: Eqs. (43)-(46). Departs: (47) prints the bracket without J_1 J_2⁺; the resolution supplies it.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpedanceLaw {
    gains: Gains,
}

impl ImpedanceLaw {
    /// Builds a law with these gains.
    pub fn new(gains: Gains) -> Self {
        Self { gains }
    }

    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        self.gains.rows()
    }

    /// Returns Ẍ = Ẍ_d + M_d⁻¹ (−B_d ΔẊ − K_d ΔX − F_e), m/s² and rad/s².
    pub fn acceleration(&self, state: &TaskState) -> TaskVector {
        let (damping, stiffness) = (self.gains.damping(), self.gains.stiffness());
        let relative_velocity = state.relative_velocity();
        let resistance = self.gains.accelerate(|row| {
            damping[row] * relative_velocity[row] + stiffness[row] * state.displacement[row] + state.force[row]
        });
        &state.target_acceleration - &resistance
    }
}

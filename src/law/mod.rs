//! Control laws: each turns a measured state into the velocity ẋ_k of its task.
//!
//! The force, impedance and hybrid laws integrate a desired acceleration, ẋ ← ẋ + T ẍ (semi-implicit Euler), and so keep
//! one velocity per task axis from period to period: the *integrator*.

mod force;
mod gains;
mod hybrid;
mod impedance;
mod profile;

pub use force::ForceLaw;
pub use gains::{GainError, Gains};
pub use hybrid::HybridLaw;
pub use impedance::ImpedanceLaw;
pub use profile::{Profile, ProfileError};

use crate::linalg::Vector;

/// What a law sees of the measured state: the rows of its own task, m each, base axes.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskState {
    /// t, s.
    pub time_s: f64,
    /// Ẋ, measured velocity, m/s and rad/s.
    pub velocity: Vector,
    /// ΔX = X − X_d, displacement from the target pose, m and rad.
    pub displacement: Vector,
    /// F_e, force and torque on the environment, N and N·m.
    pub force: Vector,
}

/// The law of one task.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// ẋ as given.
    Velocity(Profile),
    /// Follow a force. Paper: Eqs. (35)-(42).
    Force(ForceLaw),
    /// Behave as mass, damper and spring about a pose. Paper: Eqs. (43)-(47).
    Impedance(ImpedanceLaw),
    /// Some axes follow a force, the others a pose. Paper: Eqs. (48)-(53).
    Hybrid(HybridLaw),
}

impl Law {
    /// m, the number of rows that the law is about.
    pub fn rows(&self) -> usize {
        match self {
            Self::Velocity(profile) => profile.rows(),
            Self::Force(law) => law.rows(),
            Self::Impedance(law) => law.rows(),
            Self::Hybrid(law) => law.rows(),
        }
    }

    /// ẋ_k for this period, m entries, from the integrator's value in the last one; `period`: T, s.
    pub fn velocity(&self, state: &TaskState, integrator: &Vector, period: f64) -> Vector {
        match self {
            Self::Velocity(profile) => profile.at(state.time_s),
            Self::Force(law) => integrator + law.acceleration(state) * period,
            Self::Impedance(law) => integrator + law.acceleration(state) * period,
            Self::Hybrid(law) => integrator + law.acceleration(state) * period,
        }
    }

    /// F_d at time t, per row `None` where the law follows no force, N and N·m.
    pub fn target_force(&self, time_s: f64) -> Vec<Option<f64>> {
        match self {
            Self::Force(law) => law.target_force(time_s).iter().copied().map(Some).collect(),
            Self::Hybrid(law) => law.target_force(time_s),
            Self::Velocity(_) | Self::Impedance(_) => vec![None; self.rows()],
        }
    }
}

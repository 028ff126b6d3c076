//! Control laws: each turns a measured state into the velocity ẋ_k of its task.
//!
//! T is the period, X the tool's pose (or joints) and X_d its target, ΔX = X − X_d, K and M_d, B_d, K_d are diagonal.
//! Each guarantee is that of an axis whose task velocity is achieved: no limit, higher task or damping holds it back.
//!
//! | law | formula | guarantees | fails |
//! |---|---|---|---|
//! | velocity | ẋ given | the velocity itself | positions drift by what rounding and the arm's loop leave |
//! | pose | ẋ = ẋ_d + K (x_d − x) | a resting or moving target is reached as (1 − K T)^i | K T ≥ 2 diverges and is refused; with a late arm sooner; an orientation half a turn away has no shortest way |
//! | posture | q̇ = q̇_d + K (q_d − q), or q̇ = −K ∇H | the same for joints; H falls | as above; as a lower task it gives way |
//! | force, Eqs. (35)-(42) | ẋ ← ẋ + T M_d⁻¹ (F_d − F_e − B_d Ẋ) | F_e = F_d at rest, whatever the stiffness it meets | with nothing to push against it moves on at F_d/B_d; a stiff contact and a late arm bounce, see [the margin](crate::controller::ContactLoop) |
//! | impedance, Eqs. (43)-(47) | ẋ ← ẋ + T [Ẍ_d + M_d⁻¹ (−B_d ΔẊ − K_d ΔX − F_e)] | ΔX = −K_d⁻¹ F_e at rest; a uniformly moving target is followed without error where nothing is touched | B_d = 0 swings for ever, K_d = 0 drifts; bounces as the force law does |
//! | hybrid, Eqs. (48)-(53) | ẋ ← ẋ + T [Ẍ_d + M_d⁻¹ ((I − S) F_d − F_e − B_d ΔẊ − K_d S ΔX)] | the force law where S is 0, the impedance law where it is 1 | as each of them; a moving target on a force-controlled axis leaves a force error B_d Ẋ_d |
//!
//! The force, impedance and hybrid laws integrate a desired acceleration (semi-implicit Euler), and so keep one velocity
//! per task axis from period to period: the *integrator*. It is kept along the axes of the task's own frame, and turns
//! with them where those turn.

mod force;
mod gains;
mod hybrid;
mod impedance;
mod position;

pub use force::ForceLaw;
pub use gains::{GainError, Gains};
pub use hybrid::HybridLaw;
pub use impedance::ImpedanceLaw;
pub use position::{GainRange, PositionLaw};
pub use revprio_robot::profile::{MIN_DURATION, Point, Profile, ProfileError, SetPoint};

use smallvec::SmallVec;

use crate::linalg::TaskVector;

/// What a law sees of the measured state: the rows of its own task, m each, along the axes of its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskState {
    /// t, s.
    pub time_s: f64,
    /// Ẋ, measured velocity, m/s and rad/s.
    pub velocity: TaskVector,
    /// ΔX = X − X_d, displacement from the target, m and rad.
    pub displacement: TaskVector,
    /// Ẋ_d, velocity of the target, m/s and rad/s.
    pub target_velocity: TaskVector,
    /// Ẍ_d, acceleration of the target, m/s² and rad/s².
    pub target_acceleration: TaskVector,
    /// F_e, force and torque on the environment, N and N·m.
    pub force: TaskVector,
}

impl TaskState {
    /// ΔẊ = Ẋ − Ẋ_d, m/s and rad/s.
    pub fn relative_velocity(&self) -> TaskVector {
        &self.velocity - &self.target_velocity
    }
}

/// F_d per row, N and N·m; `None` where no force is followed.
pub type TargetForce = SmallVec<[Option<f64>; 8]>;

/// The law of one task.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// ẋ as given.
    Velocity(Profile),
    /// Go to a pose, or on joints to a posture.
    Position(PositionLaw),
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
            Self::Position(law) => law.rows(),
            Self::Force(law) => law.rows(),
            Self::Impedance(law) => law.rows(),
            Self::Hybrid(law) => law.rows(),
        }
    }

    /// Whether the law integrates an acceleration; those are the laws that read the measured wrench.
    pub fn integrates(&self) -> bool {
        match self {
            Self::Velocity(_) | Self::Position(_) => false,
            Self::Force(_) | Self::Impedance(_) | Self::Hybrid(_) => true,
        }
    }

    /// ẋ_k for this period, m entries, from the integrator's value in the last one; `period`: T, s.
    pub fn velocity(&self, state: &TaskState, integrator: &[f64], period: f64) -> TaskVector {
        let acceleration = match self {
            Self::Velocity(profile) => return TaskVector::from_slice(&profile.at(state.time_s).value),
            Self::Position(law) => return law.velocity(state),
            Self::Force(law) => law.acceleration(state),
            Self::Impedance(law) => law.acceleration(state),
            Self::Hybrid(law) => law.acceleration(state),
        };
        TaskVector::from_fn(integrator.len(), |row| integrator[row] + acceleration[row] * period)
    }

    /// F_d at time t, per row `None` where the law follows no force, N and N·m.
    pub fn target_force(&self, time_s: f64) -> TargetForce {
        match self {
            Self::Force(law) => law.target_force(time_s).iter().copied().map(Some).collect(),
            Self::Hybrid(law) => law.target_force(time_s),
            Self::Velocity(_) | Self::Position(_) | Self::Impedance(_) => SmallVec::from_elem(None, self.rows()),
        }
    }
}

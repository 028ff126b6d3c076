//! Control laws: each computes the velocity ẋ_k of its task from the measured state.
//!
//! T is the period, X the pose of the tool (or the joints), X_d its target and ΔX = X − X_d. K, M_d, B_d and K_d are
//! diagonal. The guarantees hold on an axis that reaches its task velocity, so no limit, higher task or damping may
//! hold it back.
//!
//! | law | formula | guarantees | fails |
//! |---|---|---|---|
//! | velocity | ẋ given | the velocity itself | positions drift by rounding and by the error of the arm's loop |
//! | bounds | lower ≤ ẋ ≤ upper given | the velocity is inside its bounds as far as higher tasks and limits permit | as the velocity law: a bound on a velocity is no bound on a position |
//! | pose | ẋ = ẋ_d + f K (x_d − x) | near the target f = 1: the distance to a resting or moving target shrinks as (1 − K T)^i in i periods; a distant target is approached no faster than the joints can brake, see [`PositionLaw`] | K T ≥ 2 diverges and is refused; a lag or delay beyond the stated drive lowers this bound; an orientation error of half a turn has no shortest direction |
//! | posture | q̇ = q̇_d + f K (q_d − q), or q̇ = −f K ∇H | the same for joints; H decreases | as above; as a lower task it gives way to higher ones |
//! | force, Eqs. (35)-(42) | ẋ ← ẋ + T M_d⁻¹ (F_d − F_e − B_d Ẋ) | F_e = F_d at rest, for any stiffness of the environment | without contact the tool moves at F_d/B_d, and oscillates behind a drive if B_d/M_d is too large; with a stiff contact and lag or delay of the arm it bounces, see [the stability margins](crate::controller::ContactLoop) |
//! | impedance, Eqs. (43)-(47) | ẋ ← ẋ + T [Ẍ_d + M_d⁻¹ (−B_d ΔẊ − K_d ΔX − F_e)] | ΔX = −K_d⁻¹ F_e at rest; without contact a uniformly moving target is followed without error | B_d = 0 oscillates without decay, K_d = 0 drifts; bounces as the force law does |
//! | contact | u = ((F_d − F)/K̂ − (p − x_s))/τ_c, see [`ContactLaw`] | F_d is held on a surface of unknown stiffness behind any stated lag and delay, without overshoot for K ≤ K̂ | a drive that is slower than stated; a surface that moves faster than the law follows |
//! | hybrid, Eqs. (48)-(53) | ẋ ← ẋ + T [Ẍ_d + M_d⁻¹ ((I − S) F_d − F_e − B_d ΔẊ − K_d S ΔX)] | the force law where S is 0, the impedance law where S is 1 | as the force and the impedance law; a moving target on a force-controlled axis leaves a force error B_d Ẋ_d |
//!
//! The force, impedance and hybrid laws integrate a desired acceleration (semi-implicit Euler). So they keep one
//! velocity per task axis from period to period, the *integrator*. Its entries are along the axes of the task's frame;
//! if these axes turn, the integrator turns with them. An axis that does not follow its request continues from the achieved
//! velocity; see [`AntiWindup`](crate::controller::AntiWindup). So in a direction with the damping gain D = σ²/(σ² + λ²)
//! the velocity stays below T D/(1 − D) times the acceleration of the law: near a singularity the arm moves slowly in the
//! weak direction, and does not wind up.

mod bounds;
mod contact;
mod force;
mod gains;
mod hybrid;
mod impedance;
mod motion_path;
mod position;
mod task_state;
mod task_vector;

pub use bounds::{VelocityBounds, VelocityBoundsError};
pub use contact::{
    AxisInput, ContactAxis, ContactContradiction, ContactLaw, ContactLawError, ContactPhase, ContactReport,
    ContactSettings, ContactTiming, FaultCause, Following, StiffnessEstimate, SurfaceMotion, Swing, Unchanged,
    largest_approach_speed, unavoidable_peak,
};
pub use force::ForceLaw;
pub use gains::{GainError, Gains};
pub use hybrid::HybridLaw;
pub use impedance::ImpedanceLaw;
pub use motion_path::MotionPath;
pub use position::{Braking, PositionLaw, PositionLawError};
pub(crate) use position::{braking_factor, linear_share};
pub use revprio_robot::profile::{MIN_DURATION, Point, Profile, ProfileError, SetPoint};
pub use task_state::{TargetForce, TaskState};
pub use task_vector::TaskVector;

use smallvec::SmallVec;

/// The law of one task.
#[derive(Debug, Clone, PartialEq)]
pub enum Law {
    /// A given velocity ẋ over time.
    Velocity(Profile),
    /// Bounds of ẋ in place of ẋ: an inequality task.
    Bounds(VelocityBounds),
    /// Motion to a pose, or of joints to a posture.
    Position(PositionLaw),
    /// Contact with a surface of unknown stiffness.
    Contact(ContactLaw),
    /// Force control. Paper: Eqs. (35)-(42).
    Force(ForceLaw),
    /// Mass, damper and spring about a pose. Paper: Eqs. (43)-(47).
    Impedance(ImpedanceLaw),
    /// Force control on some axes, impedance on the others. Paper: Eqs. (48)-(53).
    Hybrid(HybridLaw),
}

impl Law {
    /// Returns m, the number of rows.
    pub fn rows(&self) -> usize {
        match self {
            Self::Velocity(profile) => profile.rows(),
            Self::Bounds(bounds) => bounds.rows(),
            Self::Position(law) => law.rows(),
            Self::Contact(law) => law.rows(),
            Self::Force(law) => law.rows(),
            Self::Impedance(law) => law.rows(),
            Self::Hybrid(law) => law.rows(),
        }
    }

    /// Returns whether the law integrates an acceleration.
    pub fn integrates(&self) -> bool {
        match self {
            Self::Velocity(_) | Self::Bounds(_) | Self::Position(_) | Self::Contact(_) => false,
            Self::Force(_) | Self::Impedance(_) | Self::Hybrid(_) => true,
        }
    }

    /// Returns whether the law reads the measured wrench.
    pub fn reads_wrench(&self) -> bool {
        self.integrates() || self.contact().is_some()
    }

    /// Returns the contact law; `None` for others.
    pub fn contact(&self) -> Option<&ContactLaw> {
        match self {
            Self::Contact(law) => Some(law),
            _ => None,
        }
    }

    /// Returns whether the law follows a velocity.
    pub fn follows_velocity(&self) -> bool {
        matches!(self, Self::Velocity(_))
    }

    /// Returns whether the law follows a position.
    pub fn follows_position(&self) -> bool {
        matches!(self, Self::Position(_) | Self::Impedance(_) | Self::Hybrid(_))
    }

    /// Returns whether the law follows a force.
    pub fn follows_force(&self) -> bool {
        matches!(self, Self::Contact(_) | Self::Force(_) | Self::Hybrid(_))
    }

    /// Returns the bounds of an inequality task; `None` for laws that compute a velocity.
    pub fn bounds(&self) -> Option<&VelocityBounds> {
        match self {
            Self::Bounds(bounds) => Some(bounds),
            _ => None,
        }
    }

    /// Returns ẋ_k for this period from the integrator of the last period, m entries each; `period`: T, s. For bounds, it
    /// is the allowed velocity nearest to the measured one. The contact law has a memory of its own, see [`ContactLaw::step`]; here it
    /// keeps its velocity.
    pub fn velocity(&self, state: &TaskState, integrator: &[f64], period: f64) -> TaskVector {
        let acceleration = match self {
            Self::Velocity(profile) => return state.set_point(profile),
            Self::Bounds(bounds) => return bounds.velocity(state),
            Self::Position(law) => return law.velocity(state),
            Self::Contact(_) => return TaskVector::from_slice(integrator),
            Self::Force(law) => law.acceleration(state),
            Self::Impedance(law) => law.acceleration(state),
            Self::Hybrid(law) => law.acceleration(state),
        };
        TaskVector::from_fn(integrator.len(), |row| integrator[row] + acceleration[row] * period)
    }

    /// Returns the velocity or the force over time that streamed targets replace; `None` for laws of positions and bounds.
    pub fn target(&self) -> Option<&Profile> {
        match self {
            Self::Velocity(profile) => Some(profile),
            Self::Force(law) => Some(&law.target_force),
            Self::Hybrid(law) => Some(&law.target_force),
            Self::Contact(law) => Some(law.target_force()),
            Self::Bounds(_) | Self::Position(_) | Self::Impedance(_) => None,
        }
    }

    /// Returns F_d at time t, N and N·m; `None` on rows that follow no force.
    pub fn target_force(&self, time_s: f64) -> TargetForce {
        match self {
            Self::Force(law) => law.target_force(time_s).iter().copied().map(Some).collect(),
            Self::Hybrid(law) => law.target_force(time_s),
            Self::Contact(law) => law.target_force().at(time_s).value.iter().copied().map(Some).collect(),
            Self::Velocity(_) | Self::Bounds(_) | Self::Position(_) | Self::Impedance(_) => {
                SmallVec::from_elem(None, self.rows())
            }
        }
    }
}

//! Which least-squares problems the cascade solves, one after the other.
#![allow(non_snake_case)]

use smallvec::SmallVec;

use crate::linalg::{Damping, Decomposition, TaskMatrix, TaskVector};
use crate::resolution::certificate::relative;
use crate::resolution::closed_form::damped_velocities;
use crate::resolution::hierarchy::{Stage, stacked};

/// One level: minimise ‖A q̇ − b‖², then keep the first `kept` entries of A q̇.
pub struct Objective {
    /// A, m × n.
    pub A: TaskMatrix,
    /// ‖A‖.
    pub norm: f64,
    /// b, m.
    pub b: TaskVector,
    /// Rows of A whose value later levels must not change: all of them, or those that are not damping.
    pub kept: usize,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
}

/// The levels of a stage, highest first.
pub type Objectives = SmallVec<[Objective; 3]>;

impl Objective {
    /// min ‖J q̇ − ẋ‖².
    pub fn exact(J: TaskMatrix, xdot: TaskVector) -> Self {
        Self { kept: J.nrows(), norm: J.norm(), A: J, b: xdot, scaled: false }
    }

    /// min ‖J q̇ − ẋ‖², or J q̇ = s ẋ with the largest s ≤ 1 if the task is to be `scaled`.
    fn task(J: &TaskMatrix, xdot: TaskVector, scaled: bool) -> Self {
        Self { scaled, ..Self::exact(J.clone(), xdot) }
    }

    /// min ‖J q̇ − ẋ‖² + factor² ‖q̇ − reference‖².
    fn damped(J: &TaskMatrix, xdot: TaskVector, factor: f64, reference: &TaskVector) -> Self {
        let mut objective = Self::exact(J.clone(), xdot);
        if factor > 0.0 {
            objective.A.push_rows(&(&TaskMatrix::identity(J.ncols()) * factor));
            objective.b = objective.b.concatenated(&(reference * factor));
            objective.norm = objective.A.norm();
        }
        objective
    }

    /// min ‖q̇ − reference‖².
    fn nearest_to(reference: &TaskVector) -> Self {
        Self::exact(TaskMatrix::identity(reference.len()), reference.clone())
    }

    /// The entries of A q̇ that later levels must not change.
    pub fn kept_value(&self, qdot: &TaskVector) -> TaskVector {
        let mut value = &self.A * qdot;
        value.truncate(self.kept);
        value
    }

    /// How far later levels moved them from `value`, relative to the size of the level at velocities up to ‖q̇‖ = `speed`.
    pub fn drift(&self, value: &TaskVector, qdot: &TaskVector, speed: f64) -> f64 {
        relative((&self.kept_value(qdot) - value).amax(), self.norm * speed + self.b.norm())
    }

    /// Whether all of A q̇ is kept, so that the level's multipliers prove which limits stay active.
    pub fn is_exact(&self) -> bool {
        self.kept == self.A.nrows()
    }
}

/// One stack: reach it, then stay near ζ̇.
///
/// A stack of which a task is to be scaled is scaled as a whole: it has one velocity. Damping then forms that velocity
/// first, J (ζ̇ + J^# (ẋ − J ζ̇)).
pub fn stack_objectives(stages: &[Stage], factor: f64, zeta: &TaskVector) -> Objectives {
    let (J, xdot) = stacked(stages);
    let reach = if stages.iter().any(|stage| stage.scaled) {
        let given_up = Decomposition::singular(&J, J.norm()).damping_loss(&(&xdot - &(&J * zeta)), factor);
        Objective::task(&J, &xdot - &given_up, true)
    } else {
        Objective::damped(&J, xdot, factor, zeta)
    };
    [reach, Objective::nearest_to(zeta)].into_iter().collect()
}

/// Stage k of reverse priority: reach what damping leaves of task k, spare what lies below, move least.
///
/// Damping is a matter of the task's velocity, not of the limits: what it leaves, J_k (q̇_{k+1} + J_k^# e_k) up to an
/// unreachable part, is formed without them and then reached as well as they allow. Were the damped problem itself
/// solved within the limits, they would change it even where the stage's answer keeps them.
///
/// `qdot_low`: q̇_{k+1}, n, rad/s.
pub fn stage_objectives(stage: &Stage, qdot_low: &TaskVector) -> Objectives {
    let Stage { J_k, xdot_k, scaled, J_low, own, mu, lambda, .. } = stage;
    let given_up = own.damping_loss(&(xdot_k - &(J_k * qdot_low)), *mu);
    let mut levels = Objectives::new();
    levels.push(Objective::task(J_k, xdot_k - &given_up, *scaled));
    if J_low.nrows() > 0 {
        levels.push(Objective::damped(J_low, J_low * qdot_low, *lambda, qdot_low));
    }
    levels.push(Objective::nearest_to(qdot_low));
    levels
}

/// The strict hierarchy: one level per task, damped before limits count, then stay near ζ̇.
pub fn strict_objectives(stages: &[Stage], damping: Option<Damping>, zeta: &TaskVector) -> Objectives {
    let tasks = stages.iter().zip(damped_velocities(stages, damping));
    let task_levels = tasks.map(|(stage, velocity)| Objective::task(&stage.J_k, velocity, stage.scaled));
    task_levels.chain([Objective::nearest_to(zeta)]).collect()
}

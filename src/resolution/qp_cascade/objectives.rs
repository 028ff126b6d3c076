//! Which least-squares problems the cascade solves, one after the other.
#![allow(non_snake_case)]

use crate::linalg::{Matrix, SvdError, Vector, concatenate, stack};
use crate::resolution::certificate::relative;
use crate::resolution::closed_form::damped_velocities;
use crate::resolution::hierarchy::Stage;
use crate::resolution::problem::Problem;

/// One level: minimise ‖A q̇ − b‖², then keep the first `kept` entries of A q̇.
pub struct Objective {
    /// A, m × n.
    pub A: Matrix,
    /// b, m.
    pub b: Vector,
    /// Rows of A whose value later levels must not change: all of them, or those that are not damping.
    pub kept: usize,
    /// Whether limits may slow the task down, but not bend it.
    pub scaled: bool,
}

impl Objective {
    /// min ‖J q̇ − ẋ‖².
    pub fn exact(J: &Matrix, xdot: Vector) -> Self {
        Self { A: J.clone(), b: xdot, kept: J.nrows(), scaled: false }
    }

    /// min ‖J q̇ − ẋ‖², or J q̇ = s ẋ with the largest s ≤ 1 if the task is to be `scaled`.
    fn task(J: &Matrix, xdot: Vector, scaled: bool) -> Self {
        Self { scaled, ..Self::exact(J, xdot) }
    }

    /// min ‖J q̇ − ẋ‖² + factor² ‖q̇ − reference‖².
    fn damped(J: &Matrix, xdot: &Vector, factor: f64, reference: &Vector) -> Self {
        if factor == 0.0 {
            return Self::exact(J, xdot.clone());
        }
        let (kept, n) = (J.nrows(), J.ncols());
        let (A, b) = (stack(J, &(Matrix::identity(n, n) * factor)), concatenate(xdot, &(reference * factor)));
        Self { A, b, kept, scaled: false }
    }

    /// min ‖q̇ − reference‖².
    fn nearest_to(reference: &Vector) -> Self {
        Self::exact(&Matrix::identity(reference.len(), reference.len()), reference.clone())
    }

    /// The entries of A q̇ that later levels must not change.
    pub fn kept_value(&self, qdot: &Vector) -> Vector {
        self.A.rows(0, self.kept) * qdot
    }

    /// How far later levels moved them from `value`, relative to the size of the level at velocities up to ‖q̇‖ = `speed`.
    pub fn drift(&self, value: &Vector, qdot: &Vector, speed: f64) -> f64 {
        relative(&(self.kept_value(qdot) - value), self.A.norm() * speed + self.b.norm())
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
pub fn stack_objectives(problem: &Problem, top: &Stage, factor: f64, zeta: &Vector) -> Vec<Objective> {
    let (J, xdot) = (problem.tasks.stacked_jacobian(), problem.tasks.stacked_velocity());
    let reach = if problem.tasks.tasks().iter().any(|task| task.scaled) {
        let given_up = top.svd_rp.damping_loss(&(&xdot - &J * zeta), factor);
        Objective::task(&J, xdot - given_up, true)
    } else {
        Objective::damped(&J, &xdot, factor, zeta)
    };
    vec![reach, Objective::nearest_to(zeta)]
}

/// Stage k of reverse priority: reach what damping leaves of task k, spare what lies below, move least.
///
/// Damping is a matter of the task's velocity, not of the limits: what it leaves, J_k (q̇_{k+1} + J_k^# e_k) up to an
/// unreachable part, is formed without them and then reached as well as they allow. Were the damped problem itself
/// solved within the limits, they would change it even where the stage's answer keeps them.
///
/// `qdot_low`: q̇_{k+1}, n, rad/s.
pub fn stage_objectives(stage: &Stage, qdot_low: &Vector) -> Vec<Objective> {
    let Stage { J_k, xdot_k, scaled, J_low, svd, mu, lambda, .. } = stage;
    let given_up = svd.damping_loss(&(xdot_k - J_k * qdot_low), *mu);
    let mut levels = vec![Objective::task(J_k, xdot_k - given_up, *scaled)];
    if J_low.nrows() > 0 {
        levels.push(Objective::damped(J_low, &(J_low * qdot_low), *lambda, qdot_low));
    }
    levels.push(Objective::nearest_to(qdot_low));
    levels
}

/// The strict hierarchy: one level per task, damped before limits count, then stay near ζ̇.
pub fn strict_objectives(problem: &Problem, zeta: &Vector) -> Result<Vec<Objective>, SvdError> {
    let velocities = damped_velocities(&problem.tasks, problem.damping)?;
    let tasks = problem.tasks.tasks().iter().zip(velocities);
    let task_levels = tasks.map(|(task, velocity)| Objective::task(&task.jacobian, velocity, task.scaled));
    Ok(task_levels.chain([Objective::nearest_to(zeta)]).collect())
}

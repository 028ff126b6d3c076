//! Which least-squares problems the cascade solves, one after the other.
#![allow(non_snake_case)]

use crate::linalg::{Matrix, Vector, concatenate, stack};
use crate::resolution::closed_form::strict_levels;
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
}

impl Objective {
    /// min ‖J q̇ − ẋ‖² + factor² ‖q̇ − reference‖².
    fn damped(J: &Matrix, xdot: &Vector, factor: f64, reference: &Vector) -> Self {
        let kept = J.nrows();
        if factor == 0.0 {
            return Self { A: J.clone(), b: xdot.clone(), kept };
        }
        let n = J.ncols();
        Self { A: stack(J, &(Matrix::identity(n, n) * factor)), b: concatenate(xdot, &(reference * factor)), kept }
    }

    /// min ‖q̇ − reference‖².
    fn nearest_to(reference: &Vector) -> Self {
        let n = reference.len();
        Self { A: Matrix::identity(n, n), b: reference.clone(), kept: n }
    }

    /// Whether all of A q̇ is kept, so that the level's multipliers prove which limits stay active.
    pub fn is_exact(&self) -> bool {
        self.kept == self.A.nrows()
    }
}

/// One stack: reach it, then stay near ζ̇.
pub fn stack_objectives(problem: &Problem, factor: f64, zeta: &Vector) -> Vec<Objective> {
    let (J, xdot) = (problem.tasks.stacked_jacobian(), problem.tasks.stacked_velocity());
    vec![Objective::damped(&J, &xdot, factor, zeta), Objective::nearest_to(zeta)]
}

/// Stage k of reverse priority: reach task k, spare what lies below, move least.
///
/// `qdot_low`: q̇_{k+1}, n, rad/s.
pub fn stage_objectives(stage: &Stage, qdot_low: &Vector) -> Vec<Objective> {
    let Stage { J_k, xdot_k, J_low, mu, lambda, .. } = stage;
    let mut levels = vec![Objective::damped(J_k, xdot_k, *mu, qdot_low)];
    if J_low.nrows() > 0 {
        levels.push(Objective::damped(J_low, &(J_low * qdot_low), *lambda, qdot_low));
    }
    levels.push(Objective::nearest_to(qdot_low));
    levels
}

/// The strict hierarchy: one level per task, then stay near ζ̇.
pub fn strict_objectives(problem: &Problem, zeta: &Vector) -> Result<Vec<Objective>, crate::linalg::SvdError> {
    let rest = Vector::zeros(zeta.len());
    let levels = strict_levels(&problem.tasks, problem.damping)?;
    let task_levels = problem
        .tasks
        .tasks()
        .iter()
        .zip(levels)
        .map(|(task, level)| Objective::damped(&task.jacobian, &task.velocity, level.lambda, &rest));
    Ok(task_levels.chain([Objective::nearest_to(zeta)]).collect())
}

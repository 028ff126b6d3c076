//! The strict (lexicographic) hierarchy.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Damping, Matrix, Svd, SvdError, Vector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::task::TaskStack;

/// Where task k may act: the null space of all higher tasks.
pub struct StrictLevel {
    /// Orthonormal basis N of the null space of all higher tasks, n × p.
    N: Matrix,
    /// Decomposition of J_k N.
    svd: Svd,
    /// Damping from σ_min(J_k N).
    pub lambda: f64,
}

/// The level of each task, highest first.
pub fn strict_levels(tasks: &TaskStack, damping: Option<Damping>) -> Result<Vec<StrictLevel>, SvdError> {
    let mut N = Matrix::identity(tasks.joint_count(), tasks.joint_count());
    let mut levels = Vec::with_capacity(tasks.tasks().len());
    for task in tasks.tasks() {
        let svd = Svd::with_scale(&(&task.jacobian * &N), task.jacobian.norm())?;
        let below = &N * svd.null_space();
        levels.push(StrictLevel { lambda: svd.damping_factor(damping), N, svd });
        N = below;
    }
    Ok(levels)
}

/// min ‖J_1 q̇ − ẋ_1‖, then ‖J_2 q̇ − ẋ_2‖, …, then ‖q̇ − ζ̇‖, each keeping what the ones before achieved.
///
/// Task k moves in the null space N of all higher tasks: q̇ ← q̇ + N (J_k N)^# (ẋ_k − J_k q̇), damped by σ_min(J_k N).
/// `zeta`: ζ̇, n, rad/s.
///
/// Departs: the paper claims strictness for the recursion of Eq. (29), which has it for the top task alone.
pub fn strict_reverse_priority(
    tasks: &TaskStack,
    damping: Option<Damping>,
    zeta: &Vector,
) -> Result<ClosedForm, SvdError> {
    let (mut qdot, mut kkt_residual) = (Vector::zeros(tasks.joint_count()), 0.0_f64);
    let mut rest = zeta.clone();
    for (task, StrictLevel { N, svd, lambda }) in tasks.tasks().iter().zip(strict_levels(tasks, damping)?) {
        let (J_k, xdot_k) = (&task.jacobian, &task.velocity);
        let z = svd.damped_solve(&(xdot_k - J_k * &qdot), lambda);
        qdot += &N * &z;
        let gradient = N.transpose() * J_k.transpose() * (J_k * &qdot - xdot_k) + z * (lambda * lambda);
        kkt_residual = kkt_residual.max(relative(&gradient, gradient_scale(J_k, &qdot, xdot_k)));
        let below = N * svd.null_space();
        rest = &below * (below.transpose() * zeta);
    }
    Ok(ClosedForm { joint_velocity: qdot + rest, kkt_residual })
}

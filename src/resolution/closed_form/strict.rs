//! The strict (lexicographic) hierarchy.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Damping, Matrix, Svd, SvdError, Vector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::task::{Task, TaskStack};

/// What one task adds to the hierarchy, limits apart.
struct Step {
    /// N z, what is added to q̇, n, rad/s.
    delta: Vector,
    /// The part of ẋ_k that damping gives up, m_k.
    given_up: Vector,
    /// Relative stationarity residual.
    kkt_residual: f64,
}

/// The hierarchy in progress.
struct Descent {
    /// q̇ of the tasks so far, n, rad/s.
    qdot: Vector,
    /// Orthonormal basis N of the null space of the tasks so far, n × p.
    N: Matrix,
}

impl Descent {
    fn new(n: usize) -> Self {
        Self { qdot: Vector::zeros(n), N: Matrix::identity(n, n) }
    }

    /// Task k moves in the null space N of all higher tasks: q̇ ← q̇ + N (J_k N)^# (ẋ_k − J_k q̇), damped by σ_min(J_k N).
    fn step(&mut self, task: &Task, damping: Option<Damping>) -> Result<Step, SvdError> {
        let (J_k, xdot_k) = (&task.jacobian, &task.velocity);
        let J_k_N = J_k * &self.N;
        let svd = Svd::with_scale(&J_k_N, J_k.norm())?;
        let (lambda, e_k) = (svd.damping_factor(damping), xdot_k - J_k * &self.qdot);
        let z = svd.damped_solve(&e_k, lambda);
        let terms = self.qdot.norm() + z.norm();
        let gradient = J_k_N.transpose() * (&J_k_N * &z - &e_k) + &z * (lambda * lambda);
        let step = Step {
            delta: &self.N * &z,
            given_up: svd.damping_loss(&e_k, lambda),
            kkt_residual: relative(&gradient, gradient_scale(J_k, lambda, terms, xdot_k.norm())),
        };
        self.qdot += &step.delta;
        self.N = &self.N * svd.null_space();
        Ok(step)
    }
}

/// min ‖J_1 q̇ − ẋ_1‖, then ‖J_2 q̇ − ẋ_2‖, …, then ‖q̇ − ζ̇‖, each keeping what the ones before achieved.
///
/// `zeta`: ζ̇, n, rad/s.
///
/// Departs: the paper claims strictness for the recursion of Eq. (29), which has it for the top task alone.
pub fn strict_reverse_priority(
    tasks: &TaskStack,
    damping: Option<Damping>,
    zeta: &Vector,
) -> Result<ClosedForm, SvdError> {
    let mut descent = Descent::new(tasks.joint_count());
    let mut kkt_residual = 0.0_f64;
    for task in tasks.tasks() {
        kkt_residual = kkt_residual.max(descent.step(task, damping)?.kkt_residual);
    }
    let Descent { qdot, N } = descent;
    Ok(ClosedForm { joint_velocity: qdot + &N * (N.transpose() * zeta), kkt_residual })
}

/// The velocities that damping leaves of each ẋ_k, m_k each, highest priority first: what the hierarchy then reaches as
/// well as it can.
pub fn damped_velocities(tasks: &TaskStack, damping: Option<Damping>) -> Result<Vec<Vector>, SvdError> {
    let mut descent = Descent::new(tasks.joint_count());
    tasks.tasks().iter().map(|task| Ok(&task.velocity - descent.step(task, damping)?.given_up)).collect()
}

//! The strict (lexicographic) hierarchy.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Damping, Decomposition, TaskMatrix, TaskVector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::{Stage, damp};

/// What one task adds to the hierarchy, limits apart.
struct Step {
    /// The part of ẋ_k that damping gives up, m_k.
    given_up: TaskVector,
    /// Relative stationarity residual.
    kkt_residual: f64,
}

/// The hierarchy in progress.
struct Descent {
    /// q̇ of the tasks so far, n, rad/s.
    qdot: TaskVector,
    /// Orthonormal basis N of the null space of the tasks so far, n × p.
    N: TaskMatrix,
}

impl Descent {
    fn new(n: usize) -> Self {
        Self { qdot: TaskVector::zeros(n), N: TaskMatrix::identity(n) }
    }

    /// Task k moves in the null space N of all higher tasks: q̇ ← q̇ + N (J_k N)^# (ẋ_k − J_k q̇), damped by σ_min(J_k N).
    fn step(&mut self, stage: &Stage, damping: Option<Damping>) -> Step {
        let Stage { J_k, xdot_k, .. } = stage;
        let mut J_k_N = J_k * &self.N;
        J_k_N.without_rounding(0, J_k);
        let mut decomposition = Decomposition::with_scale(&J_k_N, stage.norm);
        let lambda = damp(&mut decomposition, &J_k_N, stage.norm, damping);
        let e_k = xdot_k - &(J_k * &self.qdot);
        let z = if lambda > 0.0 {
            let mut z = decomposition.damped_in_frame(&e_k, lambda);
            decomposition.from_frame(&mut z);
            z
        } else {
            decomposition.solve(&e_k)
        };
        let terms = self.qdot.norm() + z.norm();
        let mut gradient = J_k_N.transposed_times(&(&(&J_k_N * &z) - &e_k));
        gradient.add_scaled(lambda * lambda, &z);
        let scale = gradient_scale(stage.norm, lambda, terms, xdot_k.norm());
        let given_up = decomposition.damping_loss(&e_k, lambda);
        self.qdot += &(&self.N * &z);
        self.N = decomposition.times_null_space(&self.N);
        Step { given_up, kkt_residual: relative(gradient.amax(), scale) }
    }
}

/// min ‖J_1 q̇ − ẋ_1‖, then ‖J_2 q̇ − ẋ_2‖, …, then ‖q̇ − ζ̇‖, each keeping what the ones before achieved.
///
/// `zeta`: ζ̇, n, rad/s.
///
/// Departs: the paper claims strictness for the recursion of Eq. (29), which has it for the top task alone.
pub fn strict_reverse_priority(stages: &[Stage], damping: Option<Damping>, zeta: &TaskVector) -> ClosedForm {
    let mut descent = Descent::new(zeta.len());
    let residuals = stages.iter().map(|stage| descent.step(stage, damping).kkt_residual);
    let kkt_residual = residuals.fold(0.0, f64::max);
    let Descent { qdot, N } = descent;
    ClosedForm { joint_velocity: &qdot + &(&N * &N.transposed_times(zeta)), kkt_residual }
}

/// The velocities that damping leaves of each ẋ_k, m_k each, highest priority first: what the hierarchy then reaches as
/// well as it can.
pub fn damped_velocities(stages: &[Stage], damping: Option<Damping>) -> impl Iterator<Item = TaskVector> {
    let mut descent = Descent::new(stages[0].J_k.ncols());
    stages.iter().map(move |stage| &stage.xdot_k - &descent.step(stage, damping).given_up)
}

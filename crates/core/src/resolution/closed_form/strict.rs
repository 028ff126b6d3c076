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
#[derive(Default)]
pub struct Descent {
    /// q̇ of the tasks so far, n, rad/s.
    qdot: TaskVector,
    /// Orthonormal basis N of the null space of the tasks so far, n × p.
    N: TaskMatrix,
    /// J_k N and its decomposition.
    J_k_N: TaskMatrix,
    decomposition: Decomposition,
}

impl Descent {
    fn start(&mut self, n: usize) {
        self.qdot = TaskVector::zeros(n);
        self.N.reset(n, n);
        (0..n).for_each(|i| self.N[i][i] = 1.0);
    }

    /// Task k moves in the null space N of all higher tasks: q̇ ← q̇ + N (J_k N)^# (ẋ_k − J_k q̇), damped by σ_min(J_k N).
    fn step(&mut self, stage: &Stage, damping: Option<Damping>) -> Step {
        let Stage { J_k, xdot_k, .. } = stage;
        let Self { qdot, N, J_k_N, decomposition } = self;
        J_k_N.become_product(J_k, N);
        J_k_N.without_rounding(0, J_k);
        decomposition.decompose(J_k_N, 0, stage.norm);
        let lambda = damp(decomposition, J_k_N, stage.norm, damping);
        let e_k = xdot_k - &(J_k * &*qdot);
        let mut z =
            if lambda > 0.0 { decomposition.damped_in_frame(&e_k, lambda) } else { decomposition.solve_in_frame(&e_k) };
        decomposition.from_frame(&mut z);
        let terms = qdot.norm() + z.norm();
        let mut gradient = J_k_N.transposed_times(&(&(&*J_k_N * &z) - &e_k));
        gradient.add_scaled(lambda * lambda, &z);
        let scale = gradient_scale(stage.norm, lambda, terms, xdot_k.norm());
        let given_up = decomposition.damping_loss(&e_k, lambda);
        *qdot += &(&*N * &z);
        decomposition.to_null_space(N);
        Step { given_up, kkt_residual: relative(gradient.amax(), scale) }
    }

    /// min ‖J_1 q̇ − ẋ_1‖, then ‖J_2 q̇ − ẋ_2‖, …, then ‖q̇ − ζ̇‖, each keeping what the ones before achieved.
    ///
    /// `zeta`: ζ̇, n, rad/s.
    ///
    /// Departs: the paper claims strictness for the recursion of Eq. (29), which has it for the top task alone.
    pub fn strict_reverse_priority(
        &mut self,
        stages: &[Stage],
        damping: Option<Damping>,
        zeta: &TaskVector,
    ) -> ClosedForm {
        self.start(zeta.len());
        let residuals = stages.iter().map(|stage| self.step(stage, damping).kkt_residual);
        let kkt_residual = residuals.fold(0.0, f64::max);
        let free = &self.N * &self.N.transposed_times(zeta);
        ClosedForm { joint_velocity: &self.qdot + &free, kkt_residual }
    }

    /// The velocities that damping leaves of each ẋ_k, m_k each, highest priority first: what the hierarchy then reaches as
    /// well as it can.
    pub fn damped_velocities(
        &mut self,
        stages: &[Stage],
        damping: Option<Damping>,
    ) -> impl Iterator<Item = TaskVector> {
        self.start(stages[0].J_k.ncols());
        stages.iter().map(move |stage| &stage.xdot_k - &self.step(stage, damping).given_up)
    }
}

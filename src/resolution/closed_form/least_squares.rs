//! All tasks as one stack.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Decomposition, TaskMatrix, TaskVector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::{Stage, stacked};

/// All rows, and room to invert them in.
#[derive(Default)]
pub struct Stack {
    J: TaskMatrix,
    decomposition: Decomposition,
}

impl Stack {
    /// q̇ = ζ̇ + Jᵀ(J Jᵀ + λ² I)⁻¹ (ẋ − J ζ̇), with λ = 0: q̇ = J⁺ẋ + (I − J⁺J) ζ̇.
    ///
    /// `zeta`: ζ̇, n, rad/s.
    ///
    /// Paper: Eqs. (5), (15). Departs: Eq. (4) inverts JᵀJ, singular for n > m, and the projector of Eq. (7) is zero.
    pub fn least_squares(&mut self, stages: &[Stage], zeta: &TaskVector, lambda: f64) -> ClosedForm {
        let Self { J, decomposition } = self;
        let xdot = stacked(stages, J);
        let (J, norm) = (&*J, J.norm());
        let error = &xdot - &(J * zeta);
        let delta = if lambda > 0.0 {
            decomposition.decompose_singular(J, 0, norm);
            let mut delta = decomposition.damped_in_frame(&error, lambda);
            decomposition.from_frame(&mut delta);
            delta
        } else {
            decomposition.decompose(J, 0, norm);
            decomposition.solve(&error)
        };
        let qdot = zeta + &delta;
        let terms = zeta.norm() + delta.norm();
        let mut gradient = J.transposed_times(&(&(J * &qdot) - &xdot));
        gradient.add_scaled(lambda * lambda, &delta);
        let kkt_residual = relative(gradient.amax(), gradient_scale(norm, lambda, terms, xdot.norm()));
        ClosedForm { joint_velocity: qdot, kkt_residual }
    }
}

//! All rows as one least-squares problem.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Decomposition, TaskVector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::Rows;

/// q̇ = ζ̇ + Jᵀ(J Jᵀ + λ² I)⁻¹ (ẋ − J ζ̇), with λ = 0: q̇ = J⁺ẋ + (I − J⁺J) ζ̇.
///
/// `decomposition`: of J, by singular values where λ > 0; `zeta`: ζ̇, n, rad/s.
///
/// Paper: Eqs. (5), (15). Departs: Eq. (4) inverts JᵀJ, singular for n > m, and the projector of Eq. (7) is zero.
pub fn least_squares(rows: &Rows, decomposition: &Decomposition, zeta: &TaskVector, lambda: f64) -> ClosedForm {
    let Rows { J, norm, xdot } = rows;
    let error = xdot - &(J * zeta);
    let mut delta =
        if lambda > 0.0 { decomposition.damped_in_frame(&error, lambda) } else { decomposition.solve_in_frame(&error) };
    decomposition.from_frame(&mut delta);
    let qdot = zeta + &delta;
    let terms = zeta.norm() + delta.norm();
    let mut gradient = J.transposed_times(&(&(J * &qdot) - xdot));
    gradient.add_scaled(lambda * lambda, &delta);
    let kkt_residual = relative(gradient.amax(), gradient_scale(*norm, lambda, terms, xdot.norm()));
    ClosedForm { joint_velocity: qdot, kkt_residual }
}

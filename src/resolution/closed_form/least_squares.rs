//! All tasks as one stack.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::Vector;
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::Stage;
use crate::task::TaskStack;

/// q̇ = ζ̇ + Jᵀ(J Jᵀ + λ² I)⁻¹ (ẋ − J ζ̇), with λ = 0: q̇ = J⁺ẋ + (I − J⁺J) ζ̇.
///
/// `top`: the stage of all rows; `zeta`: ζ̇, n, rad/s.
///
/// Paper: Eqs. (5), (15). Departs: Eq. (4) inverts JᵀJ, singular for n > m, and the projector of Eq. (7) is zero.
pub fn least_squares(tasks: &TaskStack, top: &Stage, zeta: &Vector, lambda: f64) -> ClosedForm {
    let (J, xdot) = (tasks.stacked_jacobian(), tasks.stacked_velocity());
    let delta = top.svd_rp.damped_solve(&(&xdot - &J * zeta), lambda);
    let qdot = zeta + &delta;
    let terms = zeta.norm() + delta.norm();
    let gradient = J.transpose() * (&J * &qdot - &xdot) + delta * (lambda * lambda);
    let kkt_residual = relative(&gradient, gradient_scale(&J, lambda, terms, xdot.norm()));
    ClosedForm { joint_velocity: qdot, kkt_residual }
}

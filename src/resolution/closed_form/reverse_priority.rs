//! The reverse-priority recursion.
//!
//! The paper writes stage k as q̇_k = q̇_{k+1} + T_k (J_k T_k)⁺ (ẋ_k − J_k q̇_{k+1}), Eq. (29), with T_k the first m_k
//! columns of (J_k^RP)⁺. With the two dampings (see [`crate::linalg::Damping`]) it reads
//!
//! q̇_k = q̇_{k+1} + T_k (J_k T_k)⁺ J_k J_k^# e_k,  e_k = ẋ_k − J_k q̇_{k+1},
//!
//! with J_k^# = J_kᵀ(J_k J_kᵀ + μ_k² I)⁻¹ and T_k from J_k^RPᵀ(J_k^RP J_k^RPᵀ + λ_k² I)⁻¹.
//! The added vector is the solution of: minimise ‖J_{k+1}^RP Δ‖² + λ_k² ‖Δ‖² (then ‖Δ‖) subject to
//! J_k Δ = J_k J_k^# e_k. With an orthonormal basis N of the null space of J_k, Δ = J_k^# e_k − N z, so that
//!
//! Δ = (I − N (J_{k+1}^RP N)^# J_{k+1}^RP) J_k^# e_k,  (·)^# damped with λ_k.
//!
//! That is the same vector without the product J_k T_k, in which small rows appear squared: rank decisions stay right
//! for rows of very different size. A test holds it to the printed form.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::{Svd, SvdError, Vector};
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::Stage;

/// q̇_1 of the recursion k = l, …, 1 from q̇_{l+1} = ζ̇.
///
/// `stages`: highest priority first; `zeta`: ζ̇, n, rad/s (the paper's start is zero).
///
/// Paper: Eqs. (22), (29), (30), (32).
pub fn reverse_priority(stages: &[Stage], zeta: &Vector) -> Result<ClosedForm, SvdError> {
    let mut answer = ClosedForm { joint_velocity: zeta.clone(), kkt_residual: 0.0 };
    for stage in stages.iter().rev() {
        let (delta, residual) = correction(stage, &answer.joint_velocity)?;
        answer.joint_velocity += delta;
        answer.kkt_residual = answer.kkt_residual.max(residual);
    }
    Ok(answer)
}

/// Δ of stage k and its stationarity residual.
fn correction(stage: &Stage, qdot_low: &Vector) -> Result<(Vector, f64), SvdError> {
    let Stage { J_k, xdot_k, J_low, svd, mu, lambda, .. } = stage;
    let e_k = xdot_k - J_k * qdot_low;
    let reach = svd.damped_solve(&e_k, *mu);
    let N = svd.null_space();
    let J_low_N = J_low * &N;
    let spared = Svd::with_scale(&J_low_N, J_low.norm())?.damped_solve(&(J_low * &reach), *lambda);
    let delta = &reach - &N * &spared;

    let reaching = J_k.transpose() * (J_k * &reach - &e_k) + &reach * (mu * mu);
    let sparing = N.transpose() * (J_low.transpose() * (J_low * &delta) + &delta * (lambda * lambda));
    let residual = relative(&reaching, gradient_scale(J_k, *mu, qdot_low.norm() + reach.norm(), xdot_k.norm()))
        .max(relative(&sparing, gradient_scale(J_low, *lambda, reach.norm() + spared.norm(), 0.0)));
    Ok((delta, residual))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Damping, Matrix};
    use crate::resolution::hierarchy::Hierarchy;
    use crate::task::{Task, TaskStack};

    /// Rows a and a + ε b, damped.
    fn nearly_dependent_rows(epsilon: f64, angle: f64) -> TaskStack {
        let (s, c) = angle.sin_cos();
        let jacobian = Matrix::from_row_slice(2, 3, &[c, s, 0.3, c - epsilon * s, s + epsilon * c, 0.3]);
        let velocity = Vector::from_vec(vec![0.7, -0.4]);
        TaskStack::new(vec![Task::new("only", jacobian, velocity)]).unwrap()
    }

    #[test]
    fn a_damped_lowest_task_is_certified() {
        for i in 0..200 {
            let tasks = nearly_dependent_rows(1e-4 * f64::from(i), 0.1 * f64::from(i));
            let hierarchy = Hierarchy::new(&tasks, Some(Damping::STANDARD)).unwrap();
            assert!(hierarchy.top().lambda > 0.0);
            let residual = reverse_priority(&hierarchy.stages, &Vector::zeros(3)).unwrap().kkt_residual;
            assert!(residual < 1e-12, "{i}: {residual:e}");
        }
    }
}

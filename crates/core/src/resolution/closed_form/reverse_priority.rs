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
//!
//! Where all rows are independent and nothing is damped, every T_k changes no lower task, so that all tasks are met by the
//! vector nearest to ζ̇: [`super::least_squares`], which takes one decomposition, is asked there.
#![allow(non_snake_case)]

use super::ClosedForm;
use crate::linalg::TaskVector;
use crate::resolution::certificate::{gradient_scale, relative};
use crate::resolution::hierarchy::Stage;

/// q̇_1 of the recursion k = l, …, 1 from q̇_{l+1} = ζ̇.
///
/// `stages`: highest priority first; `zeta`: ζ̇, n, rad/s (the paper's start is zero).
///
/// Paper: Eqs. (22), (29), (30), (32).
pub fn reverse_priority(stages: &[Stage], zeta: TaskVector) -> ClosedForm {
    let start = ClosedForm { joint_velocity: zeta, kkt_residual: 0.0 };
    stages.iter().rev().fold(start, |below, stage| next(stage, below))
}

/// q̇_k from q̇_{k+1}.
pub fn next(stage: &Stage, below: ClosedForm) -> ClosedForm {
    let Stage { J_k, xdot_k, J_low_V, own, spare, mu, lambda, .. } = stage;
    let mut qdot = below.joint_velocity;
    let e_k = xdot_k - &(J_k * &qdot);
    // All in the frame V = [V_r, N] of J_k, in which N z are the coordinates from the rank on.
    let reach = if *mu > 0.0 { own.damped_in_frame(&e_k, *mu) } else { own.solve_in_frame(&e_k) };
    let mut delta = reach.clone();
    if J_low_V.nrows() > 0 {
        let asked = J_low_V * &reach;
        let mut spared =
            if *lambda > 0.0 { spare.damped_in_frame(&asked, *lambda) } else { spare.solve_in_frame(&asked) };
        spare.from_frame(&mut spared);
        delta -= &spared;
    }
    own.from_frame(&mut delta);
    let (size, speed) = (reach.norm(), qdot.norm());
    let reaching =
        relative(reaching(stage, &delta, &e_k, &reach), gradient_scale(stage.norm, *mu, speed + size, xdot_k.norm()));
    // ‖Δ‖² = ‖J_k^# e_k‖² + ‖N z‖², so that this is the size of the terms whose difference Δ is.
    let sparing = relative(sparing(stage, &delta), gradient_scale(stage.norm_low, *lambda, size + delta.norm(), 0.0));
    qdot += &delta;
    ClosedForm { joint_velocity: qdot, kkt_residual: below.kkt_residual.max(reaching).max(sparing) }
}

/// ‖J_kᵀ(J_k Δ − e_k) + μ² J_k^# e_k‖_∞, `reach` being J_k^# e_k in the frame.
fn reaching(stage: &Stage, delta: &TaskVector, e_k: &TaskVector, reach: &TaskVector) -> f64 {
    let Stage { J_k, own, mu, .. } = stage;
    let mut gradient = J_k.transposed_times(&(&(J_k * delta) - e_k));
    if *mu > 0.0 {
        own.to_frame(&mut gradient);
        gradient.add_scaled(mu * mu, reach);
    }
    gradient.amax()
}

/// ‖Nᵀ (J_{k+1}^RPᵀ J_{k+1}^RP Δ + λ² Δ)‖_∞; 0 where nothing lies below.
fn sparing(stage: &Stage, delta: &TaskVector) -> f64 {
    let Stage { J_low, own, lambda, .. } = stage;
    if J_low.nrows() == 0 {
        return 0.0;
    }
    let mut gradient = J_low.transposed_times(&(J_low * delta));
    gradient.add_scaled(lambda * lambda, delta);
    own.to_frame(&mut gradient);
    gradient[own.rank()..].iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{Damping, Matrix, Vector};
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
            let mut hierarchy = Hierarchy::default();
            hierarchy.update(&tasks, Some(Damping::STANDARD));
            assert!(hierarchy.top().lambda > 0.0);
            let residual = reverse_priority(&hierarchy.stages, TaskVector::zeros(3)).kkt_residual;
            assert!(residual < 1e-12, "{i}: {residual:e}");
        }
    }
}

//! How far an answer is from the optimality conditions.

use crate::linalg::{Matrix, Vector};

/// The size that the gradient Aᵀ(A x − b) of a least-squares problem can have by scale alone.
///
/// Dividing by it makes residuals dimensionless: multiplying rows or velocities by a constant changes nothing.
pub fn gradient_scale(a: &Matrix, x: &Vector, b: &Vector) -> f64 {
    let norm = a.norm();
    norm * (norm * x.norm()).max(b.norm())
}

/// ‖v‖_∞ relative to `scale`; 0 for no vector at all.
pub fn relative(v: &Vector, scale: f64) -> f64 {
    let size = if v.is_empty() { 0.0 } else { v.amax() };
    if size == 0.0 { 0.0 } else { size / scale.max(f64::MIN_POSITIVE) }
}

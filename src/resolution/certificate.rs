//! How far an answer is from the optimality conditions.

use crate::linalg::{Matrix, Vector};

/// The size that the gradient Aᵀ(A x − b) + λ² x of a damped least-squares problem can have by scale alone.
///
/// Dividing by it makes residuals dimensionless: multiplying rows or velocities by a constant changes nothing.
/// `x`, `b`: their norms.
pub fn gradient_scale(a: &Matrix, lambda: f64, x: f64, b: f64) -> f64 {
    let norm = a.norm().hypot(lambda);
    norm * (norm * x + b)
}

/// ‖v‖_∞ relative to `scale`; 0 for no vector at all, infinite where the scale is beyond the numbers.
pub fn relative(v: &Vector, scale: f64) -> f64 {
    let size = if v.is_empty() { 0.0 } else { v.amax() };
    match scale {
        _ if size == 0.0 => 0.0,
        scale if scale.is_finite() => size / scale.max(f64::MIN_POSITIVE),
        _ => f64::INFINITY,
    }
}

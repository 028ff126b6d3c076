//! How far an answer is from the optimality conditions.

/// The size that the gradient Aᵀ(A x − b) + λ² x of a damped least-squares problem can have by scale alone.
///
/// Dividing by it makes residuals dimensionless: multiplying rows or velocities by a constant changes nothing.
/// `a`, `x`, `b`: their norms.
pub fn gradient_scale(a: f64, lambda: f64, x: f64, b: f64) -> f64 {
    let norm = if lambda > 0.0 { a.hypot(lambda) } else { a };
    norm * (norm * x + b)
}

/// `size`, ‖v‖_∞, relative to `scale`; 0 for no vector at all, infinite where the scale is beyond the numbers.
pub fn relative(size: f64, scale: f64) -> f64 {
    match scale {
        _ if size == 0.0 => 0.0,
        scale if scale.is_finite() => size / scale.max(f64::MIN_POSITIVE),
        _ => f64::INFINITY,
    }
}

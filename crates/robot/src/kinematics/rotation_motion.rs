//! Rotation, angular velocity and angular acceleration of a rotation vector that changes with time.
#![allow(non_snake_case)]

use nalgebra::{Rotation3, Vector3};

/// Angle (rad) below which series replace the closed formulas, which would lose digits by cancellation.
const SERIES_LIMIT: f64 = 1.0;

/// The rotation exp(d) with its angular velocity and acceleration, for a rotation vector d that changes with time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationMotion {
    /// R = exp(d).
    pub rotation: Rotation3<f64>,
    /// ω, rad/s, along the same axes as d.
    pub velocity: Vector3<f64>,
    /// ω̇, rad/s².
    pub acceleration: Vector3<f64>,
}

impl RotationMotion {
    /// Computes the motion from a rotation vector d (rad) and its time derivatives ḋ, d̈.
    ///
    /// ω = V ḋ and ω̇ = V d̈ + V̇ ḋ with V = I + a D + b D², D the matrix of d ×, a = (1 − cos θ)/θ²,
    /// b = (θ − sin θ)/θ³, θ = ‖d‖. If d keeps its direction, ω = ḋ and ω̇ = d̈.
    pub fn new(d: Vector3<f64>, rate: Vector3<f64>, second_rate: Vector3<f64>) -> Self {
        let [a, b, a_slope, b_slope] = coefficients(d.norm());
        let (D, D_rate) = (d.cross_matrix(), rate.cross_matrix());
        // θ θ̇ = d·ḋ; the slopes below are derivatives divided by θ.
        let half_square_rate = d.dot(&rate);
        let V = nalgebra::Matrix3::identity() + D * a + D * D * b;
        let V_rate = D * (a_slope * half_square_rate)
            + D_rate * a
            + D * D * (b_slope * half_square_rate)
            + (D_rate * D + D * D_rate) * b;
        Self { rotation: Rotation3::new(d), velocity: V * rate, acceleration: V * second_rate + V_rate * rate }
    }
}

/// Returns a, b, and their derivatives divided by θ: a'(θ)/θ, b'(θ)/θ.
fn coefficients(angle: f64) -> [f64; 4] {
    if angle < SERIES_LIMIT {
        return [series(angle, 2, 0), series(angle, 3, 0), series(angle, 2, 1), series(angle, 3, 1)];
    }
    let (sine, cosine) = angle.sin_cos();
    let (a, b) = ((1.0 - cosine) / angle.powi(2), (angle - sine) / angle.powi(3));
    let a_slope = (angle * sine - 2.0 * (1.0 - cosine)) / angle.powi(4);
    let b_slope = (3.0 * sine - 2.0 * angle - angle * cosine) / angle.powi(5);
    [a, b, a_slope, b_slope]
}

/// Sums nine terms of Σ (−1)^k θ^2k / (2k + offset)!, or for `derivative` = 1 of its derivative divided by θ.
///
/// For θ < 1 the last term is below 1e-16 of the first.
fn series(angle: f64, offset: u32, derivative: u32) -> f64 {
    let square = angle * angle;
    let factorial = |m: u32| (1..=m).map(f64::from).product::<f64>();
    let term = |k: u32| {
        let factor = if derivative == 1 { f64::from(2 * k) } else { 1.0 };
        let sign = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * factor * square.powi((k - derivative).cast_signed()) / factorial(2 * k + offset)
    };
    (derivative..derivative + 9).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::orientation_error;

    /// A rotation vector that changes length and direction.
    fn path(t: f64, size: f64) -> [Vector3<f64>; 3] {
        let (s, c) = t.sin_cos();
        [
            Vector3::new(s, 0.3 * c, 0.5 * t) * size,
            Vector3::new(c, -0.3 * s, 0.5) * size,
            Vector3::new(-s, -0.3 * c, 0.0) * size,
        ]
    }

    fn motion(t: f64, size: f64) -> RotationMotion {
        let [d, rate, second_rate] = path(t, size);
        RotationMotion::new(d, rate, second_rate)
    }

    #[test]
    fn velocity_and_acceleration_match_finite_differences_for_small_and_large_angles() {
        for size in [1e-6, 0.1, 0.9, 1.1, 2.5] {
            let (t, h) = (0.7, 1e-5);
            let (before, now, after) = (motion(t - h, size), motion(t, size), motion(t + h, size));
            let turn = orientation_error(&after.rotation, &before.rotation) / (2.0 * h);
            assert!((turn - now.velocity).norm() < 1e-8 * size.max(1e-2), "{size}: {turn} {}", now.velocity);
            let gain = (after.velocity - before.velocity) / (2.0 * h);
            assert!((gain - now.acceleration).norm() < 1e-8 * size, "{size}: {gain} {}", now.acceleration);
        }
    }

    #[test]
    fn rotation_about_one_axis_has_the_derivatives_of_its_angle() {
        let z = Vector3::z();
        let motion = RotationMotion::new(z * 0.4, z * 3.0, z * -2.0);
        assert!((motion.velocity - z * 3.0).norm() < 1e-15 && (motion.acceleration + z * 2.0).norm() < 1e-15);
    }

    #[test]
    fn series_and_closed_formulas_agree_at_the_limit() {
        let (below, above) = (coefficients(SERIES_LIMIT - 1e-12), coefficients(SERIES_LIMIT));
        for (below, above) in below.into_iter().zip(above) {
            assert!((below - above).abs() < 1e-12, "{below}, {above}");
        }
    }
}

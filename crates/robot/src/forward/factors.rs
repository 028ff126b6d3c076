//! Factors of a fixed transform.
#![allow(non_snake_case)]

use nalgebra::IsometryMatrix3;

use super::angle::Angle;

/// A transform as a sequence of motions: a rotation about z by α, a shift, a rotation about x by β, and a rotation about
/// z by δ. Each motion is relative to the axes after the motion before it.
#[derive(Debug)]
pub struct Factors {
    pub alpha: Angle,
    /// m.
    pub shift: [f64; 3],
    pub beta: Angle,
    pub delta: Angle,
}

impl From<&IsometryMatrix3<f64>> for Factors {
    fn from(transform: &IsometryMatrix3<f64>) -> Self {
        let R = transform.rotation.matrix();
        // The third column of R is (sin α sin β, −cos α sin β, cos β). If sin β is zero, any α will do.
        let alpha = Angle::of_vector(-R[(1, 2)], R[(0, 2)]);
        // Rz(α)ᵀ R = Rx(β) Rz(δ). Its first row is (cos δ, −sin δ, 0), so δ is exact for every α.
        let [cos_delta, _] = alpha.components(R[(0, 0)], R[(1, 0)]);
        let [minus_sin_delta, _] = alpha.components(R[(0, 1)], R[(1, 1)]);
        let [_, minus_sin_beta] = alpha.components(R[(0, 2)], R[(1, 2)]);
        let [x, y] = alpha.components(transform.translation.x, transform.translation.y);
        Self {
            alpha,
            shift: [x, y, transform.translation.z],
            beta: Angle::of_vector(R[(2, 2)], -minus_sin_beta),
            delta: Angle::of_vector(cos_delta, -minus_sin_delta),
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};
    use proptest::prelude::*;

    use super::*;

    fn rotation(axis: Vector3<f64>, Angle { sine, cosine }: Angle) -> IsometryMatrix3<f64> {
        let turned = Rotation3::from_scaled_axis(axis * sine.atan2(cosine));
        IsometryMatrix3::from_parts(Vector3::zeros().into(), turned)
    }

    /// Returns the largest deviation of the product of the factors from the transform.
    fn error(transform: &IsometryMatrix3<f64>) -> f64 {
        let Factors { alpha, shift, beta, delta } = Factors::from(transform);
        let shift = IsometryMatrix3::new(shift.into(), Vector3::zeros());
        let (x, z) = (Vector3::x(), Vector3::z());
        let product = rotation(z, alpha) * shift * rotation(x, beta) * rotation(z, delta);
        (product.to_homogeneous() - transform.to_homogeneous()).amax()
    }

    proptest! {
        #[test]
        fn product_of_the_factors_is_the_transform(
            shift in prop::array::uniform3(-2.0..2.0_f64),
            turn in prop::array::uniform3(-4.0..4.0_f64),
            tilt in prop_oneof![Just(0.0), Just(std::f64::consts::PI), 1e-18..1e-6, -1e-6..-1e-18, -4.0..4.0_f64],
        ) {
            prop_assert!(error(&IsometryMatrix3::new(shift.into(), turn.into())) < 3e-15);
            // Nearly parallel and nearly opposite axes, where α alone is not defined.
            let upright = rotation(Vector3::z(), Angle::of_vector(turn[0], turn[1]));
            let tilted = upright * IsometryMatrix3::new(shift.into(), Vector3::x() * tilt) * upright;
            prop_assert!(error(&tilted) < 3e-15);
        }
    }
}

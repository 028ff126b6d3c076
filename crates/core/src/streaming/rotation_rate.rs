//! Rates of displacements and velocities of poses.
//!
//! A pose is moved by a rotation vector φ from the left, exp(φ) R. Its angular velocity (base axes) is then ω = J(φ) φ', with the left
//! Jacobian J of the rotation group. For the linear part of a pose, and for rows, both are the same.

use nalgebra::Vector3;

use super::value::TargetValue;
use crate::law::TaskVector;

/// Angle below which the series are exact to rounding, rad.
const SMALL: f64 = 1e-4;

/// Returns the velocity of a value that a displacement moves at a rate, each a displacement (per second).
pub(super) fn velocity_of(value: &TargetValue, displacement: &[f64], rate: &TaskVector) -> TaskVector {
    turned(value, rate, |rate| left_jacobian(rotation(displacement), rate))
}

/// Returns the rate of the displacement that gives a value this velocity, each a displacement (per second).
pub(super) fn rate_of(value: &TargetValue, displacement: &[f64], velocity: &TaskVector) -> TaskVector {
    turned(value, velocity, |velocity| inverse_left_jacobian(rotation(displacement), velocity))
}

/// Returns a velocity whose angular part is turned by the rotation of a displacement.
pub(super) fn turned_by(value: &TargetValue, displacement: &[f64], velocity: &TaskVector) -> TaskVector {
    turned(value, velocity, |velocity| nalgebra::Rotation3::new(rotation(displacement)) * velocity)
}

/// Applies a function to the angular part, if the value is a pose.
fn turned(value: &TargetValue, entries: &TaskVector, change: impl Fn(Vector3<f64>) -> Vector3<f64>) -> TaskVector {
    let mut changed = entries.clone();
    if matches!(value, TargetValue::Pose(_)) {
        changed[3..6].copy_from_slice(change(rotation(entries)).as_slice());
    }
    changed
}

fn rotation(displacement: &[f64]) -> Vector3<f64> {
    Vector3::new(displacement[3], displacement[4], displacement[5])
}

/// Returns J(φ) v = v + (1 − cos θ)/θ² φ × v + (θ − sin θ)/θ³ φ × (φ × v).
fn left_jacobian(phi: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
    let (angle, once) = (phi.norm(), phi.cross(&v));
    let square = angle * angle;
    let [a, b] = if angle < SMALL {
        [0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0]
    } else {
        [(1.0 - angle.cos()) / square, (angle - angle.sin()) / (square * angle)]
    };
    v + a * once + b * phi.cross(&once)
}

/// Returns J(φ)⁻¹ v = v − ½ φ × v + (1/θ² − cot(θ/2)/(2 θ)) φ × (φ × v), up to half a turn.
fn inverse_left_jacobian(phi: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
    let (angle, once) = (phi.norm(), phi.cross(&v));
    let square = angle * angle;
    let c =
        if angle < SMALL { 1.0 / 12.0 + square / 720.0 } else { 1.0 / square - 0.5 / (angle * (0.5 * angle).tan()) };
    v - 0.5 * once + c * phi.cross(&once)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_directions_are_inverse_and_agree_with_differences() {
        let v = Vector3::new(0.3, -0.7, 0.2);
        for phi in
            [Vector3::zeros(), Vector3::new(5e-5, 0.0, 2e-5), Vector3::new(0.4, -1.1, 0.9), Vector3::new(0.0, 3.1, 0.0)]
        {
            assert!((inverse_left_jacobian(phi, left_jacobian(phi, v)) - v).norm() < 1e-12, "{phi}");
            let step = 1e-6;
            let at = |time: f64| nalgebra::UnitQuaternion::from_scaled_axis(phi + v * time);
            let turned = (at(step) * at(-step).inverse()).scaled_axis() / (2.0 * step);
            assert!((turned - left_jacobian(phi, v)).norm() < 1e-8, "{phi}");
        }
    }
}

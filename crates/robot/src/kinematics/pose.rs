//! Poses from positions and quaternions.

use nalgebra::{IsometryMatrix3, Quaternion, Translation3, UnitQuaternion};

/// Largest deviation of the length of a quaternion from 1. A larger one is a mistake, not rounding.
pub const UNIT_LENGTH_TOLERANCE: f64 = 1e-3;

/// Error: a quaternion is not an orientation. Holds its length.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("a quaternion of length {0}; orientations have length 1")]
pub struct NotUnitLength(pub f64);

/// Builds a pose from a position (m) and a quaternion w, x, y, z, which it scales to length 1.
pub fn pose(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> Result<IsometryMatrix3<f64>, NotUnitLength> {
    let quaternion = Quaternion::new(w, x, y, z);
    let length = quaternion.norm();
    if !((length - 1.0).abs() <= UNIT_LENGTH_TOLERANCE) {
        return Err(NotUnitLength(length));
    }
    let rotation = UnitQuaternion::from_quaternion(quaternion).to_rotation_matrix();
    Ok(IsometryMatrix3::from_parts(Translation3::from(position), rotation))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation3, Vector3};

    use super::*;

    #[test]
    fn half_a_turn_about_z_is_the_quaternion_0_0_0_1() {
        let turned = pose([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]).unwrap();
        let expected = Rotation3::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI);
        assert!((turned.rotation.matrix() - expected.matrix()).amax() < 1e-15);
        assert_eq!(turned.translation.vector, Vector3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn quaternions_of_another_length_are_refused() {
        for length in [0.0, 0.9, 1.1, f64::NAN, f64::INFINITY] {
            assert!(pose([0.0; 3], [length, 0.0, 0.0, 0.0]).is_err(), "{length}");
        }
    }
}

//! The error of an orientation as a rotation vector.

use nalgebra::{Rotation3, UnitQuaternion, Vector3};

/// Returns log(R R_dᵀ), the rotation vector (rad, base axes) from the desired orientation to the actual one.
///
/// It is X − X_d of the control laws for the angular rows.
pub fn orientation_error(actual: &Rotation3<f64>, desired: &Rotation3<f64>) -> Vector3<f64> {
    // Computed from the quaternion: the arc cosine of a rotation matrix cannot resolve angles below 1e-8 rad.
    UnitQuaternion::from_rotation_matrix(&(actual * desired.inverse())).scaled_axis()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_error_is_the_rotation_vector_from_desired_to_actual() {
        let desired = Rotation3::from_euler_angles(0.3, -0.2, 1.0);
        let turn = Vector3::new(0.1, -0.4, 0.2);
        let error = orientation_error(&(Rotation3::new(turn) * desired), &desired);
        assert!((error - turn).norm() < 1e-14);
        let tiny = Vector3::new(1e-12, 0.0, -2e-12);
        assert!((orientation_error(&Rotation3::new(tiny), &Rotation3::identity()) - tiny).norm() < 1e-20);
    }
}

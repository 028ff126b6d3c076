//! One row of Denavit-Hartenberg parameters.

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};
use serde::Deserialize;

/// One row of standard Denavit-Hartenberg parameters, as in Table 1 of the paper.
///
/// The frame after the joint is Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α) of the frame before it. The joint position adds
/// to θ (revolute) or to d (prismatic).
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DenavitHartenberg {
    /// d, offset along z, m.
    pub d: f64,
    /// a, length along x, m.
    pub a: f64,
    /// α, twist about x, rad.
    pub alpha: f64,
    /// θ at joint position zero, rad.
    #[serde(default)]
    pub theta: f64,
}

impl DenavitHartenberg {
    /// Returns the constant transform that follows the joint's motion.
    ///
    /// Rot_z and Trans_z commute, so the motion can always come first, whichever of the two it is.
    pub fn after_motion(&self) -> IsometryMatrix3<f64> {
        let screw_z = IsometryMatrix3::from_parts(
            Translation3::new(0.0, 0.0, self.d),
            Rotation3::from_axis_angle(&Vector3::z_axis(), self.theta),
        );
        let screw_x = IsometryMatrix3::from_parts(
            Translation3::new(self.a, 0.0, 0.0),
            Rotation3::from_axis_angle(&Vector3::x_axis(), self.alpha),
        );
        screw_z * screw_x
    }
}

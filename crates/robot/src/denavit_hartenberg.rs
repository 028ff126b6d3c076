//! Standard Denavit-Hartenberg parameters, as in Table 1 of the paper.

use nalgebra::{IsometryMatrix3, Rotation3, Translation3, Vector3};
use serde::Deserialize;

/// One row: the frame after the joint is Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α) of the frame before.
///
/// θ (revolute) or d (prismatic) is the joint position plus the constant given here.
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
    /// The constant transform that follows the joint's motion.
    ///
    /// Rot_z and Trans_z commute, so the motion, either of them, can always come first.
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

//! A capsule in the frame of a body.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::shape::Segment;

/// A triangle of a mesh, m.
pub type Triangle = [Vector3<f64>; 3];

/// Largest number of triangles of a mesh.
pub const MAX_TRIANGLES: usize = 2_000_000;

/// A capsule that contains a body, in the frame of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedCapsule {
    /// The segment, m.
    pub core: Segment,
    /// Radius, m.
    pub radius: f64,
}

impl FittedCapsule {
    /// Returns its volume, m³.
    pub fn volume(&self) -> f64 {
        let length = (self.core.to - self.core.from).norm();
        PI * self.radius.powi(2) * (length + 4.0 / 3.0 * self.radius)
    }
}

//! A force and a torque.

use nalgebra::{Rotation3, Vector3};

/// A force (N) with a torque (N·m) about the point at which it is measured.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3<f64>,
    /// Torque, N·m.
    pub torque: Vector3<f64>,
}

impl Wrench {
    /// Returns the same wrench along other axes: a vector v becomes R v.
    pub(crate) fn rotated(self, rotation: &Rotation3<f64>) -> Self {
        Self { force: rotation * self.force, torque: rotation * self.torque }
    }

    /// Returns the wrench about another point, from which the present one is at `lever`, m.
    pub(super) fn about(self, lever: &Vector3<f64>) -> Self {
        Self { torque: self.torque + lever.cross(&self.force), ..self }
    }

    /// Returns a x + b y.
    pub(super) fn combined(a: f64, x: &Self, b: f64, y: &Self) -> Self {
        Self { force: a * x.force + b * y.force, torque: a * x.torque + b * y.torque }
    }
}

impl From<[f64; 6]> for Wrench {
    fn from([fx, fy, fz, tx, ty, tz]: [f64; 6]) -> Self {
        Self { force: Vector3::new(fx, fy, fz), torque: Vector3::new(tx, ty, tz) }
    }
}

impl From<Wrench> for [f64; 6] {
    fn from(Wrench { force, torque }: Wrench) -> Self {
        [force.x, force.y, force.z, torque.x, torque.y, torque.z]
    }
}

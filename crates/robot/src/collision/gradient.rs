//! How fast joints change the distance of two points of a robot along a direction.

use nalgebra::Vector3;

use crate::kinematics::Configuration;

/// A point that moves with a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPoint {
    /// The moving joint that carries it; `None`: the point stands still.
    pub joint: Option<usize>,
    /// The point in the base frame, m.
    pub position: Vector3<f64>,
}

impl Configuration {
    /// Overwrites g (n) with the gradient of n·(x − y) for two points, where the direction n turns with the last link that
    /// carries both.
    ///
    /// `normal`: n, base axes, a unit vector. g q̇ is the speed at which the points come apart along n, m/s. Joints that carry
    /// both points, and joints that carry neither, have entries of zero.
    ///
    /// # Panics
    ///
    /// Panics if the robot has no such joint, or if `gradient` has fewer than n entries.
    pub fn write_distance_gradient(&self, [x, y]: [BodyPoint; 2], normal: &Vector3<f64>, gradient: &mut [f64]) {
        gradient.fill(0.0);
        for (coordinate, [dx, dy, dz]) in self.apart_columns([x.joint, y.joint], [&x.position, &y.position]) {
            gradient[coordinate] += normal.x * dx + normal.y * dy + normal.z * dz;
        }
    }
}

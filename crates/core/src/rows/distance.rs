//! The row of a distance between the tool and a point of the base.

use nalgebra::{Point3, Vector3};

use crate::arm_state::ArmAt;
use crate::law::{TaskState, TaskVector};
use crate::linalg::Matrix;

/// The distance d = |x − c| of the tool x from a point c, and its target.
#[derive(Debug, Clone, PartialEq)]
pub struct DistanceRow {
    /// c, base frame, m.
    pub point: Point3<f64>,
    /// Target of d, m.
    pub target: f64,
}

impl DistanceRow {
    /// Returns d and the unit vector from the point to the tool.
    fn direction(&self, at: ArmAt) -> (f64, Vector3<f64>) {
        let way = at.configuration.tool_pose().translation.vector - self.point.coords;
        let distance = way.norm();
        (distance, way / distance.max(f64::MIN_POSITIVE))
    }

    /// Overwrites `jacobian` with eᵀ J, 1 × n; e: the unit vector.
    pub(super) fn write_jacobian(&self, at: ArmAt, jacobian: &mut Matrix) {
        let (_, direction) = self.direction(at);
        for (entry, column) in jacobian.iter_mut().zip(at.configuration.tool_point_jacobian()) {
            *entry = column.dot(&direction);
        }
    }

    /// Returns ḋ, m/s.
    pub(super) fn velocity(&self, at: ArmAt) -> TaskVector {
        let ([x, y, z, ..], (_, direction)) = (at.arm.twist, self.direction(at));
        TaskVector::from_slice(&[direction.dot(&Vector3::new(x, y, z))])
    }

    /// Returns the state for the law.
    pub(super) fn state(&self, velocity: TaskVector, at: ArmAt) -> TaskState {
        let zero = TaskVector::zeros(1);
        TaskState {
            time_s: at.arm.profile_time(at.time_s),
            velocity,
            displacement: TaskVector::from_slice(&[self.direction(at).0 - self.target]),
            target_velocity: zero.clone(),
            target_acceleration: zero.clone(),
            force: zero,
            streamed: None,
        }
    }
}

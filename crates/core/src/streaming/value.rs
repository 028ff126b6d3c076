//! The values of targets: poses, or one number per row.

use std::ops::Range;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::law::TaskVector;

/// What a streamed target is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// The pose of the reference point of a task.
    Pose,
    /// The positions of the joints of a task.
    JointPosition,
    /// The velocity of a task.
    Velocity,
    /// The force of a task.
    Force,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 4] = [Self::Pose, Self::JointPosition, Self::Velocity, Self::Force];

    /// Returns whether the quantity is a position, which has a velocity.
    pub fn is_position(self) -> bool {
        matches!(self, Self::Pose | Self::JointPosition)
    }
}

/// The value of a target.
#[derive(Debug, Clone, PartialEq)]
pub enum TargetValue {
    /// A pose in the base frame, m.
    Pose(Isometry3<f64>),
    /// One number per row of the task.
    Rows(TaskVector),
}

impl TargetValue {
    /// Returns the length of a displacement: 6 for a pose, otherwise the number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Pose(_) => 6,
            Self::Rows(rows) => rows.len(),
        }
    }

    /// Returns whether the value has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the entries of a displacement that one bound holds together: position and orientation of a pose, each
    /// row of the others.
    pub(super) fn groups(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let size = if matches!(self, Self::Pose(_)) { 3 } else { 1 };
        (0..self.len() / size).map(move |group| group * size..(group + 1) * size)
    }

    /// Returns the displacement from `origin` to this value. For a pose: x, y, z (m), then the rotation vector (rad),
    /// base axes.
    pub(super) fn minus(&self, origin: &Self) -> TaskVector {
        match (self, origin) {
            (Self::Pose(to), Self::Pose(from)) => {
                let moved = to.translation.vector - from.translation.vector;
                let turned = (to.rotation * from.rotation.inverse()).scaled_axis();
                TaskVector::from_slice(&[moved.x, moved.y, moved.z, turned.x, turned.y, turned.z])
            }
            (Self::Rows(to), Self::Rows(from)) => to - from,
            // A stream has values of one kind only.
            _ => TaskVector::zeros(self.len()),
        }
    }

    /// Returns the distance to another value, m and rad together; infinite if it is of another kind.
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let square = match (self, other) {
            (Self::Pose(_), Self::Pose(_)) => self.minus(other).iter().map(|entry| entry * entry).sum(),
            (Self::Rows(to), Self::Rows(from)) if to.len() == from.len() => {
                to.iter().zip(from.iter()).map(|(to, from)| (to - from) * (to - from)).sum::<f64>()
            }
            _ => f64::INFINITY,
        };
        square.sqrt()
    }

    /// Overwrites this value. Nothing is allocated if it has as many rows.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        match (&mut *self, other) {
            (Self::Rows(to), Self::Rows(from)) if to.len() == from.len() => to.copy_from_slice(from),
            _ => *self = other.clone(),
        }
    }

    /// Returns this value moved by a displacement.
    pub(crate) fn plus(&self, displacement: &[f64]) -> Self {
        match self {
            Self::Pose(pose) => {
                let moved = Vector3::new(displacement[0], displacement[1], displacement[2]);
                let turned = Vector3::new(displacement[3], displacement[4], displacement[5]);
                let rotation = UnitQuaternion::from_scaled_axis(turned) * pose.rotation;
                let mut moved = Isometry3::from_parts((pose.translation.vector + moved).into(), rotation);
                // Rounding would otherwise grow over millions of periods.
                moved.rotation.renormalize_fast();
                Self::Pose(moved)
            }
            Self::Rows(rows) => Self::Rows(TaskVector::from_fn(rows.len(), |row| rows[row] + displacement[row])),
        }
    }

    /// Returns whether all numbers are finite and an orientation has length 1.
    pub fn is_valid(&self) -> bool {
        match self {
            Self::Pose(pose) => {
                pose.translation.vector.iter().all(|entry| entry.is_finite())
                    && (pose.rotation.quaternion().norm() - 1.0).abs() < 1e-9
            }
            Self::Rows(rows) => rows.iter().all(|entry| entry.is_finite()),
        }
    }
}

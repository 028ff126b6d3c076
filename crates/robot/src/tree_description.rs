//! The description of a tree of links, independent of the format of a file.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Vector3};

use super::{JointKind, JointLimits, ModelError};

/// Links connected by joints, and the tips among them. [`RobotModel::from_tree`](super::RobotModel::from_tree) checks it.
///
/// The links are the base and the children of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeDescription {
    /// Name of the link whose frame is the base frame.
    pub base: String,
    /// All joints, in any order.
    pub joints: Vec<TreeJoint>,
    /// The tips; the first one is the tool.
    pub tips: Vec<TreeTip>,
}

/// A joint between two links. The frame of the child link is the frame of the joint.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeJoint {
    /// Name.
    pub name: String,
    /// Name of the link above.
    pub parent: String,
    /// Name of the link below.
    pub child: String,
    /// Pose of the child's frame in the parent's frame at position zero, m.
    pub origin: IsometryMatrix3<f64>,
    /// How it moves; `None` if it is fixed.
    pub motion: Option<JointMotion>,
}

/// How a joint moves. A continuous joint is a revolute joint without position limits.
#[derive(Debug, Clone, PartialEq)]
pub struct JointMotion {
    /// Kind of motion.
    pub kind: JointKind,
    /// Direction of the axis in the child's frame, of any length but zero.
    pub axis: Vector3<f64>,
    /// Limits. Those of a mimic joint restrict the joint that it follows.
    pub limits: JointLimits,
    /// The joint that it follows; `None` if it has a coordinate of its own.
    pub mimic: Option<Mimic>,
}

/// What a mimic joint follows: its position is `multiplier` times that of the leader plus `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct Mimic {
    /// Name of the joint that it follows.
    pub leader: String,
    /// Position per position of the leader.
    pub multiplier: f64,
    /// Position if the leader is at zero, rad or m.
    pub offset: f64,
}

/// A tip of a description.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeTip {
    /// Name.
    pub name: String,
    /// Name of the link that carries it.
    pub link: String,
    /// Pose in the frame of the link, m.
    pub offset: IsometryMatrix3<f64>,
}

impl TreeJoint {
    /// Returns the rotation from the child's frame to the frame of the moving joint, whose z is the axis.
    pub(crate) fn rotation_to_axis(&self, motion: &JointMotion) -> Result<Rotation3<f64>, ModelError> {
        let direction = motion.axis.try_normalize(SHORTEST_AXIS);
        let direction = direction.ok_or_else(|| ModelError::Axis { joint: self.name.clone() })?;
        Ok(rotation_from_z(&direction))
    }
}

/// Length below which an axis has no direction.
pub(crate) const SHORTEST_AXIS: f64 = 1e-9;

/// Returns a rotation that maps z to a direction of unit length.
///
/// It is free of rounding if the direction is an axis of the frame, and the identity for z itself.
fn rotation_from_z(direction: &Vector3<f64>) -> Rotation3<f64> {
    let across = if direction.y.abs() <= 0.8 { Vector3::y() } else { Vector3::z() };
    let x = across.cross(direction).normalize();
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[x, direction.cross(&x), *direction]))
}

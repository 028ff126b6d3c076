//! `POST /v1/kinematics`: tool pose, Jacobian and link frames at a posture.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{JointVector, Pose};

/// A posture of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicsRequest {
    /// Name of the robot, from `GET /v1/robots`.
    pub robot: String,
    /// Joint position q, rad or m.
    pub joint_position: JointVector,
    /// Tip or link whose pose and Jacobian are asked for, by its name; default: the first tip, which is the tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// Tip or link from which they are seen, by its name; default: the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_to: Option<String>,
}

/// The kinematics of a robot at a posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KinematicsAnswer {
    /// Pose of the tool in the base frame, m; of `link` and seen from `relative_to`, if they are given.
    pub pose: Pose,
    /// Its Jacobian J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), at its origin, along the axes of the base or of
    /// `relative_to`.
    pub jacobian: Vec<Vec<f64>>,
    /// Singular values of J, largest first; min(6, n) of them.
    pub singular_values: Vec<f64>,
    /// Manipulability, the product of the singular values.
    pub manipulability: f64,
    /// Frames of the links, base first: the frame of each joint after its motion.
    pub links: Vec<LinkFrame>,
    /// Poses of the tips in the base frame, first the tool.
    #[serde(default)]
    pub tips: Vec<TipPose>,
}

/// The pose of a tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TipPose {
    /// Name of the tip.
    pub name: String,
    /// Name of the joint that carries it; absent: it is fixed to the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
    /// Pose in the base frame, m.
    pub pose: Pose,
}

/// The frame of one link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LinkFrame {
    /// Name of the joint that moves the link.
    pub joint: String,
    /// Name of the joint that it hangs on; absent: the base.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Pose in the base frame, m: origin on the axis of the joint, z along it.
    pub pose: Pose,
}

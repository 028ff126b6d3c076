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
}

/// The kinematics of a robot at a posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KinematicsAnswer {
    /// Tool pose in the base frame, m.
    pub pose: Pose,
    /// Tool Jacobian J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), base axes, at the tool
    /// point.
    pub jacobian: Vec<Vec<f64>>,
    /// Singular values of J, largest first; min(6, n) of them.
    pub singular_values: Vec<f64>,
    /// Manipulability, the product of the singular values.
    pub manipulability: f64,
    /// Frames of the links, base first: the frame of each joint after its motion.
    pub links: Vec<LinkFrame>,
}

/// The frame of one link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LinkFrame {
    /// Name of the joint that moves the link.
    pub joint: String,
    /// Pose in the base frame, m: origin on the axis of the joint, z along it.
    pub pose: Pose,
}

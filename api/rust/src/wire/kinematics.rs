//! `POST /v1/kinematics`: where the arm is at a posture, and how it can move.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{JointVector, Pose};

/// A posture of a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct KinematicsRequest {
    /// Name of a robot.
    pub robot: String,
    /// q, rad or m.
    pub joint_position: JointVector,
}

/// Poses, Jacobian and its singular values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct KinematicsAnswer {
    /// The tool in the base frame.
    pub pose: Pose,
    /// J, 6 × n, row by row: linear x y z (m/s), then angular x y z (rad/s), base axes, at the tool point.
    pub jacobian: Vec<Vec<f64>>,
    /// Singular values of J, largest first; as many as the smaller of 6 and n.
    pub singular_values: Vec<f64>,
    /// Their product.
    pub manipulability: f64,
    /// Frame of each joint after its motion, base first: what the link behind it is fixed to.
    pub links: Vec<LinkFrame>,
}

/// The frame of one link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LinkFrame {
    /// The joint that moves it.
    pub joint: String,
    /// Origin on the joint's axis, z along it, in the base frame.
    pub pose: Pose,
}

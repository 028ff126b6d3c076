//! Robots: `GET /v1/robots`, `POST /v1/robots`.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::JointKind;

/// Answer to `GET /v1/robots`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotList {
    /// Robots that requests can name.
    pub robots: Vec<Robot>,
}

/// `POST /v1/robots`: registers the chain of a URDF text from one link to another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotRegistration {
    /// Name for requests: at most 64 letters, digits, `_`, `-` and `.`.
    pub name: String,
    /// URDF text, `<robot …>`.
    pub urdf: String,
    /// Base link; default: the root of the tree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Link of the tool frame; default: the only leaf of the tree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
}

/// The format that described a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotSource {
    /// One Denavit-Hartenberg row per joint.
    DenavitHartenberg,
    /// A URDF text.
    Urdf,
}

/// A robot arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Robot {
    /// Name for requests.
    pub name: String,
    /// Description, one line of text.
    pub description: String,
    /// Format that described the robot.
    pub source: RobotSource,
    /// Joints, base first; the order of all vectors of joints.
    pub joints: Vec<RobotJoint>,
}

/// A joint and its limits; a limit is `null` if there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotJoint {
    /// Name of the joint.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Unit of the position, `rad` or `m`; velocity and acceleration are per s and s².
    pub unit: String,
    /// Minimum and maximum position, rad or m.
    pub position_limit: Option<[f64; 2]>,
    /// Maximum speed, rad/s or m/s.
    pub velocity_limit: Option<f64>,
    /// Maximum acceleration, rad/s² or m/s².
    pub acceleration_limit: Option<f64>,
    /// Position range in a publication, if it differs; for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_range: Option<[f64; 2]>,
    /// Standard Denavit-Hartenberg row, if the robot was described by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denavit_hartenberg: Option<DenavitHartenberg>,
}

/// A Denavit-Hartenberg row, Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α); the joint position adds to θ (revolute) or d
/// (prismatic).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DenavitHartenberg {
    /// Offset d along z, m.
    pub d_m: f64,
    /// Length a along x, m.
    pub a_m: f64,
    /// Twist α about x, rad.
    pub alpha_rad: f64,
    /// Angle θ at joint position zero, rad.
    pub theta_rad: f64,
}

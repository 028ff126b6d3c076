//! Known arms.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::JointKind;

/// Answer to `GET /v1/robots`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotList {
    /// The robots that requests can name.
    pub robots: Vec<Robot>,
}

/// `POST /v1/robots`: the chain of a URDF text from one link to another.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotRegistration {
    /// Name by which requests will call it: letters, digits, `_`, `-` and `.`, at most 64.
    pub name: String,
    /// The text, `<robot …>`.
    pub urdf: String,
    /// Link that the arm stands on; the root of the tree if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Link of the tool frame; the only leaf of the tree if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
}

/// How an arm was described.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotSource {
    /// By a Denavit-Hartenberg row per joint.
    DenavitHartenberg,
    /// By a URDF text.
    Urdf,
}

/// An arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// How it was described.
    pub source: RobotSource,
    /// The joints, base first: the order of every vector of joints.
    pub joints: Vec<RobotJoint>,
}

/// A joint and its limits; `null` where there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotJoint {
    /// Name.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Unit of its position: `rad` or `m`; velocity and acceleration are per s and s².
    pub unit: String,
    /// Smallest and largest position, rad or m.
    pub position_limit: Option<[f64; 2]>,
    /// Largest speed, rad/s or m/s.
    pub velocity_limit: Option<f64>,
    /// Largest acceleration, rad/s² or m/s².
    pub acceleration_limit: Option<f64>,
    /// Position range that a publication prints instead; informative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_range: Option<[f64; 2]>,
    /// Standard Denavit-Hartenberg row, where the robot was described by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denavit_hartenberg: Option<DenavitHartenberg>,
}

/// Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α); the joint position adds to θ (revolute) or d (prismatic).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DenavitHartenberg {
    /// d, m.
    pub d_m: f64,
    /// a, m.
    pub a_m: f64,
    /// α, rad.
    pub alpha_rad: f64,
    /// θ at joint position zero, rad.
    pub theta_rad: f64,
}

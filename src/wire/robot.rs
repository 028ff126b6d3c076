//! Known arms.

use serde::{Deserialize, Serialize};

use super::JointKind;

/// Answer to `GET /v1/robots`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotList {
    /// The robots that requests can name.
    pub robots: Vec<Robot>,
}

/// An arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// The joints, base first: the order of every vector of joints.
    pub joints: Vec<RobotJoint>,
}

/// A joint and its limits; `null` where there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
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

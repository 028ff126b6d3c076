//! The virtual arm of laws that look ahead, as a part of the memory.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{integer, object};

/// The virtual arm of laws with `path`: postures at which the tasks have reached their targets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct VirtualArm {
    /// Joint positions at each of the times ahead, rad or m.
    pub postures: Vec<Vec<f64>>,
    /// Index of the posture that the next period computes.
    #[schema(example = 3)]
    #[serde(deserialize_with = "integer::deserialize")]
    pub next: u32,
    /// Smoothed accelerations of the streamed targets, one list per stream, m/s² and rad/s²; default: none.
    #[schema(example = json!([[0.1, 0.0, -0.2, 0.0, 0.0, 0.0]]))]
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub target_accelerations: Vec<Vec<f64>>,
    /// The line on which the arm moves to targets that have jumped; default: it is at its targets.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub line: Option<Line>,
}

/// A line of the virtual arm from the place of the tool to targets that have jumped.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Line {
    /// Displacement of all rows from their targets at the start, m and rad.
    pub offset: Vec<f64>,
    /// Progress along the line, 0 to 1.
    #[schema(example = 0.4)]
    pub progress: f64,
    /// Its rate, 1/s.
    #[schema(example = 1.2)]
    pub speed: f64,
    /// Joint positions at equal distances along the line, as far as they are known, rad or m.
    pub postures: Vec<Vec<f64>>,
    /// The largest rates of progress there, 1/s.
    pub speeds: Vec<f64>,
    /// Whether the line is out of reach or too slow; default: no.
    #[schema(example = false)]
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_given_up: bool,
}

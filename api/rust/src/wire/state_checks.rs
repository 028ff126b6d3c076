//! The checks of measured states.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Bounds of a plausible state. A state beyond a bound is refused with 422; a larger bound allows it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StateChecks {
    /// Maximum distance of a measured joint position outside the joint's range, rad or m; default 0.1. It applies if
    /// `limits` include positions and `solver` is not `closed_form`.
    pub position_tolerance: f64,
    /// Maximum magnitude of each entry of the measured force, N; default: no bound, and a warning above 10 000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_force_n: Option<f64>,
    /// Maximum magnitude of each entry of the measured torque, N·m; default: no bound, and a warning above 10 000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_torque_nm: Option<f64>,
}

impl Default for StateChecks {
    fn default() -> Self {
        Self { position_tolerance: 0.1, max_force_n: None, max_torque_nm: None }
    }
}

//! How the joints follow a command.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::integer;

/// How the joints follow a command: after a dead time, with a first-order lag. Limits hold behind it. Give values that are
/// too large rather than too small: the arm then brakes a little early.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct JointDrive {
    /// Time constant L of the lag, s: after a step of the command, the joint has 63 % of the velocity at that time.
    /// Default 0.03.
    pub lag_s: f64,
    /// Dead time D from the measurement of a state to the motion that its answer causes, whole periods. Count sensor,
    /// network and drive; default 2.
    #[serde(deserialize_with = "integer::deserialize")]
    pub delay_periods: u64,
}

impl Default for JointDrive {
    fn default() -> Self {
        Self { lag_s: 0.03, delay_periods: 2 }
    }
}

/// The commands that the drive still has to follow, in the memory of a controller.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DriveState {
    /// Velocity of the joints behind the lag, rad/s or m/s.
    pub velocity: Vec<f64>,
    /// Commands of the last `delay_periods` periods, the oldest first, rad/s or m/s.
    pub pending: Vec<Vec<f64>>,
}

//! Set-points over time.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;

/// One value for all axes of the task, or a list with one value per axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected one value for all axes, or a list with one value per axis")]
pub enum PerAxis<T> {
    /// One value for all axes.
    All(T),
    /// One value per axis.
    Each(Vec<T>),
}

impl<T: Copy> PerAxis<T> {
    /// Returns the value of an axis of the task (index from 0); `None` if the list is too short.
    pub fn at(&self, axis: usize) -> Option<T> {
        match self {
            Self::All(value) => Some(*value),
            Self::Each(values) => values.get(axis).copied(),
        }
    }
}

/// A set-point over time, on the clock of the states. On the clock of Unix (times above 1e9 s) it counts from the first state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Profile {
    /// A constant value.
    Constant {
        /// Constant value.
        value: PerAxis<f64>,
    },
    /// A sine: offset + amplitude sin(ω t + φ).
    Sine {
        /// Mean value.
        offset: PerAxis<f64>,
        /// Amplitude.
        amplitude: PerAxis<f64>,
        /// Angular frequency ω, rad/s.
        angular_frequency_rad_s: f64,
        /// Phase φ, rad; default 0.
        #[serde(default)]
        phase_rad: f64,
        /// Start time, s: before it, the value is that at the start. Absent: the sine has no start.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        start_time_s: Option<f64>,
    },
    /// A linear change from one value to another, constant before and after.
    Ramp {
        /// Value before the ramp.
        start: PerAxis<f64>,
        /// Value after the ramp.
        end: PerAxis<f64>,
        /// Start time, s; default 0.
        #[serde(default)]
        start_time_s: f64,
        /// Duration, s; at least 1e-6.
        duration_s: f64,
    },
    /// The value of the last point passed; before the first point, its value.
    Steps {
        /// Points in the order of their times.
        #[serde(deserialize_with = "object::list")]
        points: Vec<ProfilePoint>,
    },
    /// A smooth curve through all points, at rest at the first and the last point.
    Waypoints {
        /// Points in the order of their times.
        #[serde(deserialize_with = "object::list")]
        points: Vec<ProfilePoint>,
    },
}

/// A value at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfilePoint {
    /// Time t, s.
    pub time_s: f64,
    /// Value at that time.
    pub value: PerAxis<f64>,
}

//! Set-points over time.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;

/// One value that counts for every axis of the task, or a list with one value per axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged, expecting = "expected one value for all axes, or a list with one value per axis")]
pub enum PerAxis<T> {
    /// The same for every axis.
    All(T),
    /// One per axis.
    Each(Vec<T>),
}

impl<T: Copy> PerAxis<T> {
    /// The value of the task's axis at a place, from 0; `None` where the list is too short.
    pub fn at(&self, axis: usize) -> Option<T> {
        match self {
            Self::All(value) => Some(*value),
            Self::Each(values) => values.get(axis).copied(),
        }
    }
}

/// A set-point over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Profile {
    /// The same for ever.
    Constant {
        /// The value.
        value: PerAxis<f64>,
    },
    /// offset + amplitude sin(ω t + φ).
    Sine {
        /// Mean value.
        offset: PerAxis<f64>,
        /// Swing.
        amplitude: PerAxis<f64>,
        /// ω, rad/s.
        angular_frequency_rad_s: f64,
        /// φ, rad.
        #[serde(default)]
        phase_rad: f64,
    },
    /// Straight from one value to another; constant before and after.
    Ramp {
        /// First value.
        start: PerAxis<f64>,
        /// Last value.
        end: PerAxis<f64>,
        /// When it begins, s.
        #[serde(default)]
        start_time_s: f64,
        /// How long it takes, s.
        duration_s: f64,
    },
    /// The value of the last point whose time has come; of the first one before it.
    Steps {
        /// The points, in the order of their times.
        #[serde(deserialize_with = "object::list")]
        points: Vec<ProfilePoint>,
    },
    /// Smoothly through all points, at rest at the first and the last one.
    Waypoints {
        /// The points, in the order of their times.
        #[serde(deserialize_with = "object::list")]
        points: Vec<ProfilePoint>,
    },
}

/// A value at a time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfilePoint {
    /// t, s.
    pub time_s: f64,
    /// The value then.
    pub value: PerAxis<f64>,
}

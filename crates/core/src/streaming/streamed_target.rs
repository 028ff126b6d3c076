//! The targets that arrive with a measurement.

use nalgebra::{UnitQuaternion, Vector3};

use super::stream::MAX_AHEAD;
use super::value::Quantity;

/// A target that arrives with a measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamedTarget {
    /// Index of the task, from 0.
    pub task: usize,
    /// Time of the target on the clock of the measurements, s.
    pub time_s: f64,
    /// The value.
    pub value: StreamedValue,
    /// Velocity of the value along the rows of the task, m entries, m/s and rad/s; `None`: estimated. In the tool
    /// frame: along the axes of the target.
    pub velocity: Option<Vec<f64>>,
}

/// The value of a target.
#[derive(Debug, Clone, PartialEq)]
pub enum StreamedValue {
    /// A pose (m) of the reference point, in the task's fixed frame, if it has one, otherwise in the base frame. A part
    /// that is `None` is that of the tool.
    Pose {
        /// The position, m.
        position: Option<Vector3<f64>>,
        /// The orientation.
        orientation: Option<UnitQuaternion<f64>>,
    },
    /// Positions of the joints of the task, rad or m.
    JointPosition(Vec<f64>),
    /// The velocity ẋ of the task, m/s and rad/s.
    Velocity(Vec<f64>),
    /// The force F_d of the task, N and N·m.
    Force(Vec<f64>),
}

/// Why a target is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TargetError {
    /// There is no such task, or its law does not follow such targets.
    #[error("the law of this task does not follow such targets")]
    Quantity,
    /// The number of values is not the number of rows.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A number is not finite.
    #[error("the numbers of a target must be finite")]
    NotFinite,
    /// Time of the target is too far ahead.
    #[error("the target is {ahead_s} s ahead of the state; give at most {MAX_AHEAD} s, on the clock of the states")]
    Ahead {
        /// Time of the target minus time of the state, s.
        ahead_s: f64,
    },
}

impl StreamedValue {
    /// Returns what the target is.
    pub fn quantity(&self) -> Quantity {
        match self {
            Self::Pose { .. } => Quantity::Pose,
            Self::JointPosition(_) => Quantity::JointPosition,
            Self::Velocity(_) => Quantity::Velocity,
            Self::Force(_) => Quantity::Force,
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::Pose { position, orientation } => {
                position.is_none_or(|position| position.iter().all(|entry| entry.is_finite()))
                    && orientation.is_none_or(|orientation| orientation.coords.iter().all(|entry| entry.is_finite()))
            }
            Self::JointPosition(rows) | Self::Velocity(rows) | Self::Force(rows) => {
                rows.iter().all(|entry| entry.is_finite())
            }
        }
    }
}

impl StreamedTarget {
    /// Checks the sizes and numbers of a target for a task with `expected` rows, and its time against that of the state, s.
    pub(crate) fn check_values(&self, expected: usize, time_s: f64) -> Result<(), TargetError> {
        let rows = match &self.value {
            StreamedValue::Pose { .. } => None,
            StreamedValue::JointPosition(rows) | StreamedValue::Velocity(rows) | StreamedValue::Force(rows) => {
                Some(rows)
            }
        };
        for given in rows.into_iter().chain(&self.velocity).map(Vec::len) {
            if given != expected {
                return Err(TargetError::Rows { expected, given });
            }
        }
        let is_finite = |rows: &Vec<f64>| rows.iter().all(|entry| entry.is_finite());
        if !(self.time_s.is_finite() && self.value.is_finite() && self.velocity.as_ref().is_none_or(is_finite)) {
            return Err(TargetError::NotFinite);
        }
        let ahead_s = self.time_s - time_s;
        if ahead_s > MAX_AHEAD { Err(TargetError::Ahead { ahead_s }) } else { Ok(()) }
    }
}

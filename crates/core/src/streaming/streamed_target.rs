//! The targets that arrive with a measurement.

use nalgebra::{UnitQuaternion, Vector3};

use super::curve::MIN_INTERVAL;
use super::value::Quantity;

/// Maximum time of a target after the time of the state, s. A target further ahead has another clock.
pub const MAX_AHEAD: f64 = 1.0;

/// Maximum time of a target that is given ahead after the target with which it comes, s.
pub const MAX_FORESIGHT: f64 = 2.0;

/// Maximum number of targets that are given ahead with one target.
pub const MAX_TARGETS_AHEAD: usize = 64;

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
    /// Where the target will be later, in the order of time. Laws that look ahead use it.
    pub ahead: Vec<TargetAhead>,
}

/// A target of a later time.
#[derive(Debug, Clone, PartialEq)]
pub struct TargetAhead {
    /// Time after that of the target with which it comes, s.
    pub after_s: f64,
    /// The value, of the same quantity.
    pub value: StreamedValue,
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
    /// Targets ahead are not of later and later times, too far ahead, too many, or of another quantity.
    #[error(
        "give at most {MAX_TARGETS_AHEAD} targets ahead, of the same quantity as the target, each at least 1 µs later than the one before it, \
         and at most {MAX_FORESIGHT} s after the target"
    )]
    Foresight {
        /// Index of the first one that does not fit.
        index: usize,
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

    /// Returns the number of rows that are given; `None` for a pose.
    pub(super) fn row_count(&self) -> Option<usize> {
        match self {
            Self::JointPosition(rows) | Self::Velocity(rows) | Self::Force(rows) => Some(rows.len()),
            Self::Pose { .. } => None,
        }
    }

    fn check_rows(&self, expected: usize) -> Result<(), TargetError> {
        match self.row_count().filter(|given| *given != expected) {
            Some(given) => Err(TargetError::Rows { expected, given }),
            None => Ok(()),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
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
        self.value.check_rows(expected)?;
        if let Some(velocity) = self.velocity.as_ref().filter(|velocity| velocity.len() != expected) {
            return Err(TargetError::Rows { expected, given: velocity.len() });
        }
        let is_finite = |rows: &Vec<f64>| rows.iter().all(|entry| entry.is_finite());
        if !(self.time_s.is_finite() && self.value.is_finite() && self.velocity.as_ref().is_none_or(is_finite)) {
            return Err(TargetError::NotFinite);
        }
        let ahead_s = self.time_s - time_s;
        if ahead_s > MAX_AHEAD + MIN_INTERVAL {
            return Err(TargetError::Ahead { ahead_s });
        }
        self.check_ahead(expected)
    }

    fn check_ahead(&self, expected: usize) -> Result<(), TargetError> {
        let mut before = 0.0;
        for (index, TargetAhead { after_s, value }) in self.ahead.iter().enumerate() {
            value.check_rows(expected)?;
            // False for NaN.
            let in_order = *after_s >= before + MIN_INTERVAL && *after_s <= MAX_FORESIGHT && index < MAX_TARGETS_AHEAD;
            if !(in_order && value.quantity() == self.value.quantity() && value.quantity().is_position()) {
                return Err(TargetError::Foresight { index });
            }
            if !value.is_finite() {
                return Err(TargetError::NotFinite);
            }
            before = *after_s;
        }
        Ok(())
    }
}

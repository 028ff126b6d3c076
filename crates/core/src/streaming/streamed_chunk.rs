//! Chunks of actions that arrive with a measurement.

use super::curve::MIN_INTERVAL;
use super::streamed_target::StreamedValue;
use crate::channel::ChannelTarget;

/// Maximum number of actions of a chunk.
pub const MAX_ACTIONS: usize = 256;

/// Maximum time of an action after the time of the state, s.
pub const MAX_HORIZON: f64 = 10.0;

/// A chunk of actions for one task, as a policy computes it at once.
#[derive(Debug, Clone, PartialEq)]
pub struct StreamedChunk {
    /// Index of the task, from 0.
    pub task: usize,
    /// The actions, in the order of their times, all of the same quantity.
    pub actions: Vec<Action>,
    /// Which actions are past.
    pub align: Align,
    /// Targets of channels that are due with the actions. They are followed if the chunk is.
    pub channels: Vec<ChannelChunk>,
}

/// The targets of a channel in a chunk.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelChunk {
    /// Index of the channel, from 0.
    pub channel: usize,
    /// The targets at the times of their actions, as they were sent.
    pub targets: Vec<ChannelTarget>,
}

/// An action of a chunk: a target with the time at which it is due.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    /// Time on the clock of the measurements, s.
    pub time_s: f64,
    /// The value.
    pub value: StreamedValue,
}

/// Which actions of a chunk that comes late are past.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Align {
    /// Those before the time of the state.
    #[default]
    Time,
    /// Those before the place that the arm has reached: of the places that are due until now, the nearest one. The rest of the
    /// chunk is moved in time to begin there. Forces have no place, so their time counts.
    Progress,
}

/// Why a chunk is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ChunkError {
    /// It has no actions.
    #[error("a chunk needs an action; to end a motion, send nothing, and the task brakes after the last action")]
    Empty,
    /// It has too many actions.
    #[error("a chunk of {given} actions; give at most {MAX_ACTIONS}")]
    TooMany {
        /// Number of actions.
        given: usize,
    },
    /// The task follows no such actions.
    #[error("the law of this task does not follow such actions")]
    Quantity {
        /// Index of the action.
        index: usize,
    },
    /// The actions are not of one quantity.
    #[error("this action is of another kind than the first one; send chunks of one kind")]
    Mixed {
        /// Index of the action.
        index: usize,
    },
    /// The actions are not in the order of time.
    #[error(
        "the action is due at {time_s} s, and the one before it at {before_s} s; give the actions in the order of their times, each at \
         least 1 µs after the one before"
    )]
    Order {
        /// Index of the action.
        index: usize,
        /// Its time, s.
        time_s: f64,
        /// Time of the action before it, s.
        before_s: f64,
    },
    /// The action is too far ahead.
    #[error(
        "the action is {ahead_s:.3} s ahead of the state; give at most {MAX_HORIZON} s. Its `time_s` is in seconds, on the clock of the states"
    )]
    Ahead {
        /// Index of the action.
        index: usize,
        /// Time of the action minus time of the state, s.
        ahead_s: f64,
    },
    /// The number of values is not the number of rows.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Index of the action.
        index: usize,
        /// Rows of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// The controller has no such channel, or its targets are not finite or not in the order of time.
    #[error(
        "the targets of a channel must be finite numbers of a channel of the controller, in the order of their times"
    )]
    Channel,
    /// A number is not finite.
    #[error("the numbers of an action must be finite")]
    NotFinite {
        /// Index of the action.
        index: usize,
    },
}

impl ChunkError {
    /// Returns the index of the action that is refused; `None`: the chunk as a whole.
    pub fn index(&self) -> Option<usize> {
        match *self {
            Self::Empty | Self::TooMany { .. } | Self::Channel => None,
            Self::Quantity { index }
            | Self::Mixed { index }
            | Self::Order { index, .. }
            | Self::Ahead { index, .. }
            | Self::Rows { index, .. }
            | Self::NotFinite { index } => Some(index),
        }
    }

    /// Returns whether the time of the action is refused.
    pub fn is_of_time(&self) -> bool {
        matches!(self, Self::Order { .. } | Self::Ahead { .. })
    }
}

impl StreamedChunk {
    /// Checks sizes, numbers and times for a task with `expected` rows and a state of `now_s`.
    pub(crate) fn check_actions(&self, expected: usize, now_s: f64) -> Result<(), ChunkError> {
        let Some(first) = self.actions.first() else { return Err(ChunkError::Empty) };
        if self.actions.len() > MAX_ACTIONS {
            return Err(ChunkError::TooMany { given: self.actions.len() });
        }
        let quantity = first.value.quantity();
        let mut before_s = f64::NEG_INFINITY;
        for (index, Action { time_s, value }) in self.actions.iter().enumerate() {
            if value.quantity() != quantity {
                return Err(ChunkError::Mixed { index });
            }
            if let Some(given) = value.row_count().filter(|given| *given != expected) {
                return Err(ChunkError::Rows { index, expected, given });
            }
            if !(time_s.is_finite() && value.is_finite()) {
                return Err(ChunkError::NotFinite { index });
            }
            if time_s - before_s < MIN_INTERVAL {
                return Err(ChunkError::Order { index, time_s: *time_s, before_s });
            }
            if time_s - now_s > MAX_HORIZON + MIN_INTERVAL {
                return Err(ChunkError::Ahead { index, ahead_s: time_s - now_s });
            }
            before_s = *time_s;
        }
        Ok(())
    }

    /// Checks the targets of channels, of which the controller has `count`.
    pub(crate) fn check_channels(&self, count: usize) -> Result<(), ChunkError> {
        let is_right = |chunk: &ChannelChunk| {
            let targets = &chunk.targets;
            chunk.channel < count
                && targets.len() <= MAX_ACTIONS
                && targets.iter().all(|target| target.time_s.is_finite() && target.value.is_finite())
                && targets.windows(2).all(|pair| pair[0].time_s < pair[1].time_s)
        };
        if self.channels.iter().all(is_right) { Ok(()) } else { Err(ChunkError::Channel) }
    }
}

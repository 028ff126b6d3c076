//! How a task follows its streamed targets.

/// Maximum of each time of [`Streaming`], s. A stream with one target in ten seconds is no stream.
pub const MAX_STREAMING_TIME: f64 = 10.0;

/// How a task follows its streamed targets. The defaults suit 30 to 90 targets per second.
#[derive(Debug, Clone, PartialEq)]
pub struct Streaming {
    /// Age of the newest target from which it is no longer extrapolated, s.
    pub hold_after_s: f64,
    /// Age of the newest target from which the task brakes, s.
    pub brake_after_s: f64,
    /// Delay with which targets are followed, s. With a delay of one interval between targets, the task interpolates
    /// and never extrapolates.
    pub delay_s: f64,
    /// Time constant with which the reference follows the targets, s; 0: it follows as fast as the bounds allow.
    pub smoothing_s: f64,
    /// Time in which the offset between a chunk of actions and the motion before it fades, s; longer if it would need more than half of the
    /// maximum acceleration. 0: it does not fade, the reference follows the new chunk within the bounds.
    pub fade_s: f64,
    /// Maximum velocity of the target, one per row, m/s and rad/s; `None`: the defaults of the rows.
    pub max_velocity: Option<Vec<f64>>,
    /// Maximum acceleration of the target, one per row, m/s² and rad/s²; `None`: the defaults of the rows.
    pub max_acceleration: Option<Vec<f64>>,
}

impl Default for Streaming {
    /// Extrapolates over one lost target of 30 per second, and smooths over one interval of 30 per second.
    fn default() -> Self {
        Self {
            hold_after_s: 0.05,
            brake_after_s: 0.2,
            delay_s: 0.0,
            smoothing_s: 0.03,
            fade_s: 0.3,
            max_velocity: None,
            max_acceleration: None,
        }
    }
}

/// Why settings are refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StreamingError {
    /// A time is negative, too long or not finite.
    #[error("{value} s is out of range; give 0 to {MAX_STREAMING_TIME} s")]
    Time {
        /// The field.
        field: &'static str,
        /// The value, s.
        value: f64,
    },
    /// The task would brake before it holds.
    #[error("brake_after_s is {brake_after_s} s, below hold_after_s of {hold_after_s} s; give at least that")]
    Order {
        /// Age from which the task holds, s.
        hold_after_s: f64,
        /// Age from which the task brakes, s.
        brake_after_s: f64,
    },
    /// The number of bounds is not the number of rows.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// The field.
        field: &'static str,
        /// Rows of the task.
        expected: usize,
        /// Values given.
        given: usize,
    },
    /// A bound is not positive or not finite.
    #[error("{value} is out of range; give a positive number")]
    Bound {
        /// The field.
        field: &'static str,
        /// Row, from 0.
        row: usize,
        /// The value.
        value: f64,
    },
}

impl StreamingError {
    /// Returns the name of the refused field.
    pub fn field(&self) -> &'static str {
        match self {
            Self::Time { field, .. } | Self::Rows { field, .. } | Self::Bound { field, .. } => field,
            Self::Order { .. } => "brake_after_s",
        }
    }
}

impl Streaming {
    /// Checks the settings of a task with `rows` rows.
    pub(crate) fn check(&self, rows: usize) -> Result<(), StreamingError> {
        let times = [
            ("hold_after_s", self.hold_after_s),
            ("brake_after_s", self.brake_after_s),
            ("delay_s", self.delay_s),
            ("smoothing_s", self.smoothing_s),
            ("fade_s", self.fade_s),
        ];
        if let Some(&(field, value)) = times.iter().find(|(_, value)| !(0.0..=MAX_STREAMING_TIME).contains(value)) {
            return Err(StreamingError::Time { field, value });
        }
        let Self { hold_after_s, brake_after_s, .. } = *self;
        if brake_after_s < hold_after_s {
            return Err(StreamingError::Order { hold_after_s, brake_after_s });
        }
        check_bounds("max_velocity", self.max_velocity.as_deref(), rows)?;
        check_bounds("max_acceleration", self.max_acceleration.as_deref(), rows)
    }
}

fn check_bounds(field: &'static str, values: Option<&[f64]>, rows: usize) -> Result<(), StreamingError> {
    let Some(values) = values else { return Ok(()) };
    if values.len() != rows {
        return Err(StreamingError::Rows { field, expected: rows, given: values.len() });
    }
    match values.iter().enumerate().find(|(_, value)| !(value.is_finite() && **value > 0.0)) {
        Some((row, &value)) => Err(StreamingError::Bound { field, row, value }),
        None => Ok(()),
    }
}

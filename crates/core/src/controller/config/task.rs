//! One task: its rows and its law.

use revprio_robot::RobotModel;

use crate::law::{Braking, Law, MotionPath};
use crate::rows::{RowKind, RowsError, TaskRows};
use crate::streaming::{Bound, Quantity, Streaming, StreamingError};

/// One task with its law.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskConfig {
    /// Name that answers use.
    pub name: String,
    /// The rows: axes of the tool, joints, or constant rows.
    pub rows: TaskRows,
    /// The law that computes the velocity, or bounds; as many rows as the task.
    pub law: Law,
    /// Whether the task is slowed down in its direction to keep limits, instead of changing its direction. A task with
    /// bounds cannot be.
    pub scaled: bool,
    /// How the task follows streamed targets.
    pub streaming: Streaming,
}

/// Why a task is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TaskConfigError {
    /// The rows do not fit the robot, the law or the target.
    #[error(transparent)]
    Rows(#[from] RowsError),
    /// A task with bounds is to be scaled.
    #[error("a task with bounds has no direction to keep; do not scale it")]
    Scaled,
    /// A law that looks ahead brakes in a way of its own.
    #[error(
        "a law with `path` brakes with the limits of the joints; omit `max_acceleration` and `braking`, or omit `path`"
    )]
    Path,
    /// The settings of streamed targets are out of range.
    #[error(transparent)]
    Streaming(#[from] StreamingError),
    /// With this gain and period the law oscillates without decay.
    #[error("a gain of {gain} makes the law unstable at this period; it must be below {bound}")]
    Unstable {
        /// Row, from 0.
        row: usize,
        /// The gain.
        gain: f64,
        /// The smallest unstable gain.
        bound: f64,
    },
}

impl TaskConfig {
    /// Checks that the parts fit each other and the robot, and that the law is stable at this period (s).
    pub(super) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        self.rows.check(robot, &self.law)?;
        self.streaming.check(self.rows.len())?;
        if self.scaled && self.law.bounds().is_some() {
            return Err(TaskConfigError::Scaled);
        }
        match &self.law {
            Law::Position(law) if law.path().is_some() && *law.braking() != Braking::Joints => {
                Err(TaskConfigError::Path)
            }
            _ => self.check_gain(robot, period),
        }
    }

    /// Returns the path of a position law that looks ahead.
    pub(in crate::controller) fn path(&self) -> Option<MotionPath> {
        let Law::Position(law) = &self.law else { return None };
        law.path()
    }

    /// Returns whether streamed targets of this task can be of a quantity.
    pub fn accepts(&self, quantity: Quantity) -> bool {
        match quantity {
            Quantity::Pose | Quantity::JointPosition => {
                self.law.follows_position() && self.rows.position_quantity() == Some(quantity)
            }
            Quantity::Velocity => self.law.follows_velocity(),
            Quantity::Force => self.law.follows_force(),
        }
    }

    /// Returns what streamed targets of this task can be.
    pub fn quantities(&self) -> Vec<Quantity> {
        Quantity::ALL.into_iter().filter(|quantity| self.accepts(*quantity)).collect()
    }

    /// Returns the bound of an entry of a streamed target: a row, or the first entry of a part of a pose. A part of a pose
    /// has the smallest bounds of its rows.
    pub(in crate::controller) fn bound(
        &self,
        quantity: Quantity,
        entry: usize,
        robot: &revprio_robot::RobotModel,
    ) -> Bound {
        let of_row = |row: usize| {
            let default = self.rows.kind(row, robot).bound();
            let own = |values: &Option<Vec<f64>>, default: f64| values.as_ref().map_or(default, |values| values[row]);
            Bound {
                velocity: own(&self.streaming.max_velocity, default.velocity),
                acceleration: own(&self.streaming.max_acceleration, default.acceleration),
            }
        };
        if quantity != Quantity::Pose {
            return of_row(entry);
        }
        let kind = if entry < 3 { RowKind::Linear } else { RowKind::Angular };
        let rows = (0..self.rows.len()).filter(|&row| self.rows.kind(row, robot) == kind).map(of_row);
        let smallest = rows.reduce(|a, b| Bound {
            velocity: a.velocity.min(b.velocity),
            acceleration: a.acceleration.min(b.acceleration),
        });
        smallest.unwrap_or_else(|| kind.bound())
    }

    /// Returns the largest K of a position law, 1/s, with the rates of its rows; `None`: another law.
    pub(super) fn largest_gain(&self, robot: &RobotModel) -> Option<f64> {
        let Law::Position(law) = &self.law else { return None };
        Some((0..law.rows()).map(|row| self.rate(row, robot) * law.gain()[row]).fold(0.0, f64::max))
    }

    /// Returns how fast a row moves relative to its displacement: 1, but for joints towards the middle of their ranges.
    fn rate(&self, row: usize, robot: &RobotModel) -> f64 {
        self.rows.joint(robot, row).map_or(1.0, |(_, rate)| rate)
    }

    /// Checks the gain of a position law: each period multiplies a displacement by 1 − K T, so K T must be below 2.
    fn check_gain(&self, robot: &RobotModel, period: f64) -> Result<(), TaskConfigError> {
        let Law::Position(law) = &self.law else { return Ok(()) };
        let bounds = (0..law.rows()).map(|row| 2.0 / (self.rate(row, robot) * period));
        match bounds.zip(law.gain().iter()).enumerate().find(|(_, (bound, gain))| *gain >= bound) {
            Some((row, (bound, &gain))) => Err(TaskConfigError::Unstable { row, gain, bound }),
            None => Ok(()),
        }
    }
}

//! Why the configuration of a controller is refused.

use super::null_space::NullSpaceError;
use super::task::TaskConfigError;
use crate::channel::ChannelError;
use crate::collision::CollisionAvoidanceError;
use crate::constraint::MAX_CONSTRAINT_ROWS;
use crate::limits::MAX_DRIVE_DELAY;
use crate::wrench::WrenchSensorError;

/// Why the configuration of a controller is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// T is not positive or not finite.
    #[error("the period must be a positive number of seconds, not {0}")]
    Period(f64),
    /// L is not positive or not finite.
    #[error("the characteristic length must be a positive number of metres, not {0}")]
    CharacteristicLength(f64),
    /// The list of tasks is empty.
    #[error("give at least one task")]
    NoTasks,
    /// Two tasks share a name.
    #[error("two tasks are named `{name}`; give each its own name")]
    DuplicateTask {
        /// Index of the second of the two tasks, from 0.
        task: usize,
        /// The repeated name.
        name: String,
    },
    /// The parts of a task do not fit each other or the robot.
    #[error("{source}")]
    Task {
        /// Index of the task, from 0.
        task: usize,
        /// What is wrong with it.
        source: TaskConfigError,
    },
    /// Some tasks look ahead and others do not, or along another path.
    #[error(
        "a controller looks ahead with all its tasks or with none; give each task the law `pose` or `posture` with the same `path`"
    )]
    Path {
        /// Index of the first task that differs, from 0.
        task: usize,
    },
    /// Two tasks follow the normals of surfaces with the axes of one frame.
    #[error("two tasks follow the normal of a surface in the same frame; give `surface` to one of them")]
    Surfaces {
        /// Index of the second of the two tasks, from 0.
        task: usize,
    },
    /// Laws that look ahead plan with the speed and the deceleration of each joint, and the limits do not state them.
    #[error(
        "a law with `path` plans with the speeds and decelerations of the joints; give the limits `position_velocity_acceleration` \
         or `position_velocity`, the solver `auto` or `qp`, and a robot whose joints have velocity limits"
    )]
    Unplanned,
    /// A constraint has the wrong number of coefficients, or names a joint that the robot does not have.
    #[error("inequality `{name}` does not fit a robot of {expected} joints")]
    Constraint {
        /// Index in the list, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// Joints of the robot.
        expected: usize,
    },
    /// The constraints have too many rows.
    #[error("the inequalities have {given} rows; give at most {MAX_CONSTRAINT_ROWS}")]
    ConstraintRows {
        /// Rows of all constraints.
        given: usize,
    },
    /// A channel is refused.
    #[error("{source}")]
    Channel {
        /// Index of the channel, from 0.
        index: usize,
        /// What is wrong with it.
        source: ChannelError,
    },
    /// A force and torque sensor is refused.
    #[error("{source}")]
    WrenchSensor {
        /// Index of the sensor, from 0.
        index: usize,
        /// What is wrong with it.
        source: WrenchSensorError,
    },
    /// The controller cannot keep clear of obstacles.
    #[error(transparent)]
    Collisions(#[from] CollisionAvoidanceError),
    /// Collisions are stated twice.
    #[error("state once what the controller keeps clear of")]
    CollisionsTwice,
    /// The box has another number of joints than the robot.
    #[error("limits for {given} joints, but the robot has {expected}")]
    Limits {
        /// Joints of the robot.
        expected: usize,
        /// Joints of the box.
        given: usize,
    },
    /// The lag is negative or not finite, or the dead time is too long.
    #[error("the lag of the drive must be 0 s or more, its delay at most {MAX_DRIVE_DELAY} periods")]
    Drive,
    /// The null-space motion does not fit the robot or the period.
    #[error(transparent)]
    NullSpace(#[from] NullSpaceError),
}

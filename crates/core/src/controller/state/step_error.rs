//! Why a period has no command.

use revprio_robot::kinematics::ConfigurationError;

use super::memory::MemoryError;
use crate::collision::ObstacleError;
use crate::resolution::ProblemError;
use crate::streaming::{ChunkError, TargetError};
use crate::task::TaskError;

/// Why a measurement is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StepError {
    /// The joint positions do not fit the robot or are not finite.
    #[error(transparent)]
    Configuration(#[from] ConfigurationError),
    /// The joint velocities do not fit the robot or are not finite.
    #[error("the joint velocity needs {expected} finite entries")]
    JointVelocity {
        /// Joints of the robot.
        expected: usize,
    },
    /// Time or wrench is NaN or infinite.
    #[error("time and wrenches must be finite numbers")]
    NotFinite,
    /// A wrench is that of no tip, of the tool, or of a tip that has one already.
    #[error("a wrench names tip {tip}; name each tip from 1 to {} at most once, `wrench` is that of the tool", tips - 1)]
    WrenchTip {
        /// Index of the tip.
        tip: usize,
        /// Tips of the robot.
        tips: usize,
    },
    /// A streamed target does not fit its task.
    #[error("{source}")]
    Target {
        /// Index of the target in the measurement, from 0.
        index: usize,
        /// What is wrong with it.
        source: TargetError,
    },
    /// A chunk of actions does not fit its task.
    #[error("{source}")]
    Chunk {
        /// Index of the chunk in the measurement, from 0.
        index: usize,
        /// What is wrong with it.
        source: ChunkError,
    },
    /// The controller has no such channel, or a number of it is not finite.
    #[error("a channel needs finite numbers, and the controller must have it")]
    Channel,
    /// The controller has no moving obstacle of this name.
    #[error("the controller has no moving obstacle `{name}`")]
    UnknownObstacle {
        /// Index of the obstacle in the measurement, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// An obstacle is named twice.
    #[error("obstacle `{name}` is named twice")]
    ObstacleTwice {
        /// Index of the second one, from 0.
        index: usize,
        /// Its name.
        name: String,
    },
    /// Position or velocity of an obstacle is not allowed.
    #[error("obstacle `{name}`: {source}")]
    Obstacle {
        /// Index of the obstacle in the measurement, from 0.
        index: usize,
        /// Its name.
        name: String,
        /// What is wrong with it.
        source: ObstacleError,
    },
    /// A moving obstacle of the controller is not named.
    #[error("say where obstacle `{name}` is; repeat its last position if no new one is known")]
    MissingObstacle {
        /// Its name.
        name: String,
    },
    /// The memory belongs to another controller or is damaged.
    #[error(transparent)]
    Memory(#[from] MemoryError),
    /// A task velocity overflows.
    #[error("a task velocity is not a finite number; check gains and wrench: {0}")]
    Task(#[from] TaskError),
    /// The solver is not the one that the configuration names.
    #[error("the solver is not the one that the controller names; pass that one to `Stepper::with_solver`")]
    Solver,
    /// The parts of the problem do not fit each other. A checked configuration excludes this.
    #[error(transparent)]
    Problem(#[from] ProblemError),
}

//! Why a run ended early.

use revprio_api::ClientError;
use revprio_robot::ModelError;
use revprio_robot::kinematics::{ConfigurationError, NotUnitLength};

use super::field_error::FieldError;

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The simulator does not know the robot.
    #[error("the simulator has no robot `{name}`; use one of {known}, or give a robot file")]
    UnknownRobot {
        /// The name.
        name: String,
        /// The known names.
        known: String,
    },
    /// The orientation of the tool offset is not valid.
    #[error("controller.tool_offset: {0}")]
    ToolOrientation(#[from] NotUnitLength),
    /// The tool offset is not finite.
    #[error("controller.tool_offset: {0}")]
    Tool(#[from] ModelError),
    /// The start posture does not fit the robot.
    #[error("start_joint_position: {0}")]
    Start(ConfigurationError),
    /// A value of the scenario is not valid.
    #[error("{0}")]
    Scenario(FieldError),
    /// The simulated posture is not finite.
    #[error("at t = {time_s} s: {source}")]
    Diverged {
        /// Simulated time, s.
        time_s: f64,
        /// The error.
        source: ConfigurationError,
    },
    /// The service has another robot of the same name.
    #[error(
        "at t = {time_s} s: the answer has {given} joint velocities, but the robot has {expected} joints; the service has \
         another robot of this name"
    )]
    AnswerSize {
        /// Simulated time, s.
        time_s: f64,
        /// Joints of the simulated arm.
        expected: usize,
        /// Velocities in the answer.
        given: usize,
    },
    /// The caller stopped the run.
    #[error("stopped at t = {time_s} s")]
    Stopped {
        /// Simulated time, s.
        time_s: f64,
    },
    /// The service did not answer.
    #[error("at t = {time_s} s: {source}")]
    Service {
        /// Simulated time, s.
        time_s: f64,
        /// The error.
        source: ClientError,
    },
}

impl From<FieldError> for RunError {
    fn from(error: FieldError) -> Self {
        Self::Scenario(error)
    }
}

//! Checks of joint positions.

use crate::RobotModel;

/// Why a posture is refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ConfigurationError {
    /// The number of positions is not the number of joints.
    #[error("{given} joint positions for a robot of {expected} joints")]
    Size {
        /// Joints of the robot.
        expected: usize,
        /// Positions given.
        given: usize,
    },
    /// A position is NaN or infinite.
    #[error("the position of joint `{joint}` is not a finite number")]
    NotFinite {
        /// The joint.
        joint: String,
    },
}

/// Refuses joint positions that are not n finite numbers.
pub(super) fn check(robot: &RobotModel, joint_position: &[f64]) -> Result<(), ConfigurationError> {
    if joint_position.len() != robot.joint_count() {
        return Err(ConfigurationError::Size { expected: robot.joint_count(), given: joint_position.len() });
    }
    if joint_position.iter().all(|q| q.is_finite()) { Ok(()) } else { Err(not_finite(robot, joint_position)) }
}

/// Returns the error that names the first joint without a finite position.
#[cold]
fn not_finite(robot: &RobotModel, joint_position: &[f64]) -> ConfigurationError {
    let joint = robot.joints().iter().zip(joint_position).find(|(_, q)| !q.is_finite());
    ConfigurationError::NotFinite { joint: joint.map(|(joint, _)| joint.name.clone()).unwrap_or_default() }
}

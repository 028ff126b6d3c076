//! Null-space velocities.

use revprio_api::wire;
use revprio_core::controller::NullSpaceMotion;
use revprio_robot::RobotModel;

use super::checks::{Missing, Result};
use super::numbers::{joint_vector, joint_vector_of, not_negative};

/// Reads the null-space velocity ζ̇ at `/null_space_velocity` for `joints` joints; `None`: rest. One that depends on the
/// posture needs a robot.
pub fn null_space(
    request: &wire::NullSpaceVelocity,
    robot: Option<&RobotModel>,
    joints: usize,
) -> Result<Option<NullSpaceMotion>> {
    let motion = match request {
        wire::NullSpaceVelocity::Constant(velocity) => {
            let velocity = joint_vector_of(velocity, robot, joints, "/null_space_velocity")?;
            return Ok(Some(NullSpaceMotion::Constant(velocity)));
        }
        wire::NullSpaceVelocity::Motion(wire::NullSpaceMotion::Rest {}) => return Ok(None),
        wire::NullSpaceVelocity::Motion(motion) => motion,
    };
    let robot = robot.or_invalid("/robot", "this null-space velocity needs the name of a robot")?;
    let gain = |gain: f64| not_negative(gain, "/null_space_velocity/gain");
    Ok(Some(match motion {
        wire::NullSpaceMotion::JointLimits { gain: k } => NullSpaceMotion::JointLimits { gain: gain(*k)? },
        wire::NullSpaceMotion::Posture { joint_position, gain: k } => NullSpaceMotion::Posture {
            joint_position: joint_vector(joint_position, robot, "/null_space_velocity/joint_position")?,
            gain: gain(*k)?,
        },
        wire::NullSpaceMotion::InitialPosture { gain: k } => NullSpaceMotion::InitialPosture { gain: gain(*k)? },
        wire::NullSpaceMotion::Rest {} => return Ok(None),
    }))
}

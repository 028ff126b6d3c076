//! Frames of the joints after their motion.

use nalgebra::IsometryMatrix3;

use super::posture_check::{ConfigurationError, check};
use crate::RobotModel;

/// Returns the frames of the joints with a coordinate after their motion (n) in the base frame, m.
///
/// `joint_position`: q, n; rad or m.
///
/// Each frame has its origin on the axis of its joint and its z along it. The tool frame of a serial arm is the last one
/// times [`RobotModel::tool`].
pub fn link_frames(
    robot: &RobotModel,
    joint_position: &[f64],
) -> Result<Vec<IsometryMatrix3<f64>>, ConfigurationError> {
    check(robot, joint_position)?;
    let joints = robot.moving_joints();
    let mut frames: Vec<IsometryMatrix3<f64>> = Vec::with_capacity(joints.len());
    for joint in joints {
        let mut frame = joint.parent.map_or_else(IsometryMatrix3::identity, |parent| frames[parent]) * joint.placement;
        joint.kind.move_along(&mut frame, joint.position(joint_position));
        frames.push(frame);
    }
    let with_coordinate = frames.into_iter().zip(joints).filter(|(_, joint)| !joint.is_mimic);
    Ok(with_coordinate.map(|(frame, _)| frame).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;
    use crate::kinematics::Configuration;

    #[test]
    fn the_last_link_frame_carries_the_tool_and_the_first_is_at_the_first_joint() {
        let sawyer = &built_in()[0];
        let posture = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];
        let frames = link_frames(sawyer, &posture).unwrap();
        let tool = frames[6] * sawyer.tool();
        let expected = Configuration::new(sawyer, &posture).unwrap();
        assert!((tool.to_homogeneous() - expected.tool_pose().to_homogeneous()).norm() < 1e-15);
        assert_eq!(frames[0].translation, sawyer.joints()[0].placement.translation);
        assert!(link_frames(sawyer, &posture[1..]).is_err());
    }
}

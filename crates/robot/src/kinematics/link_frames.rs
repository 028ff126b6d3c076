//! The whole arm at a posture, for drawing it.

use nalgebra::IsometryMatrix3;

use super::configuration::{ConfigurationError, check, move_along};
use crate::RobotModel;

/// Frames of the joints after their motion, base first, n, in the base frame (m), at `joint_position` (n; rad or m).
///
/// Each has its origin on its joint's axis and z along it; the tool is the last one times [`RobotModel::tool`].
pub fn link_frames(
    robot: &RobotModel,
    joint_position: &[f64],
) -> Result<Vec<IsometryMatrix3<f64>>, ConfigurationError> {
    check(robot, joint_position)?;
    let mut frame = IsometryMatrix3::identity();
    let joints = robot.joints().iter().zip(joint_position);
    Ok(joints
        .map(|(joint, &q)| {
            frame *= joint.placement;
            move_along(&mut frame, joint.kind, q);
            frame
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::built_in;
    use crate::kinematics::Configuration;

    #[test]
    fn the_last_link_carries_the_tool_and_the_first_stands_on_the_base() {
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

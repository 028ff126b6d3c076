//! Poses and frames.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3};
use revprio_api::wire;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Frame, TaskFrame, pose as pose_of};

use super::checks::{Inside, Refused, Result};
use super::numbers::check_numbers;

/// Reads a pose.
pub fn pose(pose: &wire::Pose) -> Result<IsometryMatrix3<f64>> {
    let wire::Pose { position, orientation: wire::Orientation { w, x, y, z } } = *pose;
    check_numbers(&position, "/position")?;
    pose_of(position, [w, x, y, z]).at("/orientation")
}

/// Reads the frame and the reference point of a task.
pub fn task_frame(frame: &wire::Frame, reference_point: Option<[f64; 3]>) -> Result<TaskFrame> {
    let point = reference_point.unwrap_or_default();
    check_numbers(&point, "/reference_point")?;
    let frame = match frame {
        wire::Frame::Base => Frame::Base,
        wire::Frame::Tool => Frame::Tool,
        wire::Frame::Fixed(stated) => Frame::Fixed(pose(stated).inside("/frame")?),
    };
    Ok(TaskFrame { frame, reference_point: Vector3::from(point) })
}

/// Returns the robot with the tool offset of the request.
pub fn with_tool_offset(robot: &Arc<RobotModel>, offset: Option<&wire::Pose>) -> Result<Arc<RobotModel>> {
    let Some(offset) = offset else { return Ok(Arc::clone(robot)) };
    robot.with_tool_offset(&pose(offset).inside("/tool_offset")?).map(Arc::new).at("/tool_offset")
}

/// Returns a pose as a part of an answer.
pub fn pose_answer(frame: &IsometryMatrix3<f64>) -> wire::Pose {
    let quaternion = UnitQuaternion::from_rotation_matrix(&frame.rotation);
    wire::Pose {
        position: frame.translation.vector.into(),
        orientation: wire::Orientation { w: quaternion.w, x: quaternion.i, y: quaternion.j, z: quaternion.k },
    }
}

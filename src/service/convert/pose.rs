//! Poses and frames.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3};
use revprio_api::wire;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Frame, TaskFrame, pose as pose_of};

use super::numbers::check_numbers;
use crate::service::error::ApiError;

/// Reads a pose.
pub fn pose(pose: &wire::Pose) -> Result<IsometryMatrix3<f64>, ApiError> {
    let wire::Pose { position, orientation: wire::Orientation { w, x, y, z } } = *pose;
    check_numbers(&position, "/position")?;
    pose_of(position, [w, x, y, z]).map_err(|error| ApiError::invalid("/orientation", error))
}

/// Reads the frame and the reference point of a task.
pub fn task_frame(frame: &wire::Frame, reference_point: Option<[f64; 3]>) -> Result<TaskFrame, ApiError> {
    let point = reference_point.unwrap_or_default();
    check_numbers(&point, "/reference_point")?;
    let frame = match frame {
        wire::Frame::Base => Frame::Base,
        wire::Frame::Tool => Frame::Tool,
        wire::Frame::Fixed(stated) => Frame::Fixed(pose(stated).map_err(|error| error.inside("/frame"))?),
    };
    Ok(TaskFrame { frame, reference_point: Vector3::from(point) })
}

/// Returns the robot with the tool offset of the request.
pub fn with_tool_offset(robot: &Arc<RobotModel>, offset: Option<&wire::Pose>) -> Result<Arc<RobotModel>, ApiError> {
    let Some(offset) = offset else { return Ok(Arc::clone(robot)) };
    let offset = pose(offset).map_err(|error| error.inside("/tool_offset"))?;
    let moved = robot.with_tool_offset(&offset);
    moved.map(Arc::new).map_err(|error| ApiError::invalid("/tool_offset", error))
}

/// Returns a pose as a part of an answer.
pub fn pose_answer(frame: &IsometryMatrix3<f64>) -> wire::Pose {
    let quaternion = UnitQuaternion::from_rotation_matrix(&frame.rotation);
    wire::Pose {
        position: frame.translation.vector.into(),
        orientation: wire::Orientation { w: quaternion.w, x: quaternion.i, y: quaternion.j, z: quaternion.k },
    }
}

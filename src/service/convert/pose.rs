//! Poses and frames.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3};

use super::numbers::numbers;
use crate::kinematics::{Frame, TaskFrame, pose as pose_of};
use crate::robot::RobotModel;
use crate::service::problem::Problem;
use crate::wire;

/// A pose.
pub fn pose(pose: &wire::Pose, pointer: &str) -> Result<IsometryMatrix3<f64>, Problem> {
    let wire::Pose { position, orientation: wire::Orientation { w, x, y, z } } = *pose;
    numbers(&position, &format!("{pointer}/position"))?;
    pose_of(position, [w, x, y, z]).map_err(|error| Problem::invalid(format!("{pointer}/orientation"), error))
}

/// Point and axes of the task at `pointer`.
pub fn task_frame(frame: &wire::Frame, reference_point: Option<[f64; 3]>, pointer: &str) -> Result<TaskFrame, Problem> {
    let point = reference_point.unwrap_or_default();
    numbers(&point, &format!("{pointer}/reference_point"))?;
    let frame = match frame {
        wire::Frame::Base => Frame::Base,
        wire::Frame::Tool => Frame::Tool,
        wire::Frame::Fixed(stated) => Frame::Fixed(pose(stated, &format!("{pointer}/frame"))?),
    };
    Ok(TaskFrame { frame, reference_point: Vector3::from(point) })
}

/// The robot with its tool point where the request says.
pub fn with_tool_offset(robot: &Arc<RobotModel>, offset: Option<&wire::Pose>) -> Result<Arc<RobotModel>, Problem> {
    let Some(offset) = offset else { return Ok(Arc::clone(robot)) };
    let moved = robot.with_tool_offset(&pose(offset, "/tool_offset")?);
    moved.map(Arc::new).map_err(|error| Problem::invalid("/tool_offset", error))
}

/// A pose as a part of an answer.
pub fn pose_answer(frame: &IsometryMatrix3<f64>) -> wire::Pose {
    let quaternion = UnitQuaternion::from_rotation_matrix(&frame.rotation);
    wire::Pose {
        position: frame.translation.vector.into(),
        orientation: wire::Orientation { w: quaternion.w, x: quaternion.i, y: quaternion.j, z: quaternion.k },
    }
}

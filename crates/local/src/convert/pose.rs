//! Poses and frames.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, UnitQuaternion, Vector3};
use revprio_api::wire;
use revprio_robot::kinematics::{BodyFrame, Frame, TaskBody, TaskFrame, pose as pose_of};
use revprio_robot::{LinkId, RobotModel};

use super::checks::{Inside, Refused, Result};
use super::numbers::check_numbers;
use crate::error::ApiError;

/// Reads a pose.
pub fn pose(pose: &wire::Pose) -> Result<IsometryMatrix3<f64>> {
    let wire::Pose { position, orientation: wire::Orientation { w, x, y, z } } = *pose;
    check_numbers(&position, "/position")?;
    pose_of(position, [w, x, y, z]).at("/orientation")
}

/// Reads the frame and the reference point of a task.
pub fn task_frame(body: Option<TaskBody>, frame: &wire::Frame, reference_point: Option<[f64; 3]>) -> Result<TaskFrame> {
    let point = reference_point.unwrap_or_default();
    check_numbers(&point, "/reference_point")?;
    let frame = match frame {
        wire::Frame::Base => Frame::Base,
        wire::Frame::Tool => Frame::Tool,
        wire::Frame::Fixed(stated) => Frame::Fixed(pose(stated).inside("/frame")?),
    };
    Ok(TaskFrame { body, frame, reference_point: Vector3::from(point) })
}

/// Reads the link of a task, and the link from which it is seen; `None`: the tool seen from the base.
pub fn task_body(robot: &RobotModel, link: Option<&str>, relative_to: Option<&str>) -> Result<Option<TaskBody>> {
    let named = |name: &str, pointer: &str| body_frame(robot, name).ok_or_else(|| unknown_link(robot, name, pointer));
    let relative_to = relative_to.map(|name| named(name, "/relative_to")).transpose()?;
    let relative_to = relative_to.filter(|frame| *frame != BodyFrame::from(LinkId::BASE));
    let body = match link {
        Some(name) => named(name, "/link")?,
        None if relative_to.is_some() => BodyFrame::from(&robot.tips()[0]),
        None => return Ok(None),
    };
    let is_tool = relative_to.is_none() && body == BodyFrame::from(&robot.tips()[0]);
    Ok((!is_tool).then_some(TaskBody { body, relative_to }))
}

/// Returns the frame of a tip, or of a link.
pub fn body_frame(robot: &RobotModel, name: &str) -> Option<BodyFrame> {
    robot.tip(name).map(BodyFrame::from).or_else(|| robot.link(name).map(BodyFrame::from))
}

/// Returns the names of the tips and links.
pub fn frame_names(robot: &RobotModel) -> Vec<String> {
    let links = robot.links().iter().map(|link| &link.name);
    let mut names: Vec<String> = robot.tips().iter().map(|tip| &tip.name).chain(links).cloned().collect();
    names.dedup();
    names
}

fn unknown_link(robot: &RobotModel, name: &str, pointer: &str) -> ApiError {
    let detail = format!("`{}` has no tip and no link `{name}`", robot.name());
    ApiError::invalid(pointer, detail).with_candidates(&frame_names(robot))
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

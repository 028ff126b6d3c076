//! `POST /v1/kinematics`.

use nalgebra::IsometryMatrix3;
use revprio_api::wire;
use revprio_core::linalg::{Matrix, Svd};
use revprio_robot::kinematics::{Configuration, TaskFrame, link_frames};
use revprio_robot::{RobotModel, Tip};

use super::checks::{Refused, Result};
use super::numbers::joint_vector;
use super::pose::{pose_answer, task_body};
use super::resolve::known_robot;
use crate::robots::Robots;

/// Computes the answer.
pub fn kinematics(request: &wire::KinematicsRequest, robots: &Robots) -> Result<wire::KinematicsAnswer> {
    let pointer = "/joint_position";
    let robot = &*known_robot(&request.robot, robots)?;
    let position: Vec<f64> = joint_vector(&request.joint_position, robot, pointer)?;
    let configuration = Configuration::new(robot, &position).at(pointer)?;
    let links = link_frames(robot, &position).at(pointer)?;
    let body = task_body(robot, request.link.as_deref(), request.relative_to.as_deref())?;
    let frame = TaskFrame { body, ..TaskFrame::default() };
    let placed = frame.at(&configuration);
    let jacobian = placed.jacobian();
    let svd = Svd::new(&Matrix::from_fn(6, jacobian.ncols(), |i, j| jacobian[(i, j)]));
    let singular_values = svd.singular_values();
    let link = |(joint, frame): (&revprio_robot::Joint, &IsometryMatrix3<f64>)| wire::LinkFrame {
        joint: joint.name.clone(),
        parent: parent_joint(robot, &joint.name),
        pose: pose_answer(frame),
    };
    let tip = |tip: &Tip| wire::TipPose {
        name: tip.name.clone(),
        joint: own_joint(robot, robot.links()[tip.link.index()].joint),
        pose: pose_answer(&configuration.tip_pose(tip)),
    };
    Ok(wire::KinematicsAnswer {
        pose: pose_answer(&frame.body_pose(&configuration)),
        jacobian: jacobian.row_iter().map(|row| row.iter().copied().collect()).collect(),
        singular_values: singular_values.to_vec(),
        manipulability: singular_values.iter().product::<f64>().min(f64::MAX),
        links: robot.joints().iter().zip(&links).map(link).collect(),
        tips: robot.tips().iter().map(tip).collect(),
    })
}

/// Returns the name of the joint with a coordinate that carries a joint.
fn parent_joint(robot: &RobotModel, name: &str) -> Option<String> {
    let joint = robot.moving_joints().iter().find(|joint| joint.name == name)?;
    own_joint(robot, joint.parent)
}

/// Returns the name of a moving joint, or of the first one above it that does not mimic another.
fn own_joint(robot: &RobotModel, moving: Option<usize>) -> Option<String> {
    let joint = &robot.moving_joints()[moving?];
    if joint.is_mimic { own_joint(robot, joint.parent) } else { Some(joint.name.clone()) }
}

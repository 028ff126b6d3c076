//! `POST /v1/kinematics`.

use nalgebra::IsometryMatrix3;
use revprio_api::wire;
use revprio_core::linalg::{Matrix, Svd};
use revprio_robot::kinematics::{Configuration, link_frames};

use super::checks::{Refused, Result};
use super::numbers::joint_vector;
use super::pose::pose_answer;
use super::resolve::known_robot;
use crate::service::robots::Robots;

/// Computes the answer.
pub fn kinematics(request: &wire::KinematicsRequest, robots: &Robots) -> Result<wire::KinematicsAnswer> {
    let pointer = "/joint_position";
    let robot = &*known_robot(&request.robot, robots)?;
    let position: Vec<f64> = joint_vector(&request.joint_position, robot, pointer)?;
    let configuration = Configuration::new(robot, &position).at(pointer)?;
    let links = link_frames(robot, &position).at(pointer)?;
    let jacobian = configuration.jacobian();
    let svd = Svd::new(&Matrix::from_fn(6, jacobian.ncols(), |i, j| jacobian[(i, j)]));
    let singular_values = svd.singular_values();
    let link = |(joint, frame): (&revprio_robot::Joint, &IsometryMatrix3<f64>)| wire::LinkFrame {
        joint: joint.name.clone(),
        pose: pose_answer(frame),
    };
    Ok(wire::KinematicsAnswer {
        pose: pose_answer(configuration.tool_pose()),
        jacobian: jacobian.row_iter().map(|row| row.iter().copied().collect()).collect(),
        singular_values: singular_values.to_vec(),
        manipulability: singular_values.iter().product::<f64>().min(f64::MAX),
        links: robot.joints().iter().zip(&links).map(link).collect(),
    })
}

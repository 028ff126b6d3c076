//! The memory of stateless steps, in requests and answers.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3};
use revprio_api::wire;
use revprio_core::controller::{Controller, ControllerConfig, Memory};
use revprio_core::linalg::Vector;
use revprio_core::resolution::{ActiveSet, Side};

use super::numbers::{check_numbers, joint_list, numbers};
use super::step::check_sequence;
use super::terms;
use crate::service::error::ApiError;

/// Maximum deviation of RᵀR from the identity. The matrices of the service deviate by 1e-15.
const MAX_ROTATION_ERROR: f64 = 1e-9;

/// Reads the memory of a stateless step with this sequence number; `None` at the first step. Pointers begin at the whole
/// request.
pub fn memory(
    memory: Option<&wire::Memory>,
    sequence: u64,
    controller: &Controller,
) -> Result<Option<Memory>, ApiError> {
    let Some(memory) = memory else { return Ok(None) };
    check_sequence(memory.sequence, sequence).map_err(|error| error.inside("/state"))?;
    read(memory, controller.config()).map(Some).map_err(|error| error.inside("/memory"))
}

fn read(memory: &wire::Memory, config: &ControllerConfig) -> Result<Memory, ApiError> {
    let velocity = |(k, values): (usize, &Vec<f64>)| {
        let values = numbers(values, "").map_err(|error| error.inside(&format!("/task_velocities/{k}")));
        values.map(Vector::from_vec)
    };
    Ok(Memory {
        task_velocities: memory.task_velocities.iter().enumerate().map(velocity).collect::<Result<_, _>>()?,
        initial_pose: pose(&memory.initial_pose)?,
        last_command: joint_list(&memory.last_command, config.robot.joint_count(), "/last_command")
            .map(Vector::from_vec)?,
        active_set: memory.active_set.iter().map(|set| active_set(set, config)).collect::<Result<_, _>>()?,
    })
}

fn pose(pose: &wire::FramePose) -> Result<IsometryMatrix3<f64>, ApiError> {
    check_numbers(&pose.position, "/initial_pose/position")?;
    let [x, y, z] = pose.position;
    let matrix = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    if !((matrix.transpose() * matrix - Matrix3::identity()).amax() <= MAX_ROTATION_ERROR && matrix.determinant() > 0.0)
    {
        return Err(ApiError::invalid(
            "/initial_pose/rotation",
            "not a rotation matrix; send the memory of the last answer unchanged",
        ));
    }
    Ok(IsometryMatrix3::from_parts(Translation3::new(x, y, z), Rotation3::from_matrix_unchecked(matrix)))
}

fn active_set(names: &[wire::ActiveLimitName], config: &ControllerConfig) -> Result<ActiveSet, ApiError> {
    let joints = config.robot.joints();
    let index = |limit: &wire::ActiveLimitName| match (&limit.joint, &limit.inequality) {
        (Some(name), None) => joints.iter().position(|joint| joint.name == *name),
        (None, Some(name)) => {
            config.barriers.iter().position(|barrier| barrier.name() == name).map(|index| joints.len() + index)
        }
        _ => None,
    };
    let unknown = || {
        ApiError::invalid("/active_set", "not a limit of this controller; send the memory of the last answer unchanged")
    };
    let limit = |limit: &wire::ActiveLimitName| Ok((index(limit).ok_or_else(unknown)?, terms::side(limit.side)));
    names.iter().map(limit).collect()
}

/// Returns the memory as a part of an answer.
pub fn memory_answer(controller: &Controller, sequence: u64, memory: &Memory) -> wire::Memory {
    let joints = controller.config().robot.joints();
    let barriers = &controller.config().barriers;
    let name = |&(row, side): &(usize, Side)| wire::ActiveLimitName {
        joint: joints.get(row).map(|joint| joint.name.clone()),
        inequality: row.checked_sub(joints.len()).map(|index| barriers[index].name().to_owned()),
        side: terms::side_answer(side),
    };
    let (position, rotation) = (&memory.initial_pose.translation, memory.initial_pose.rotation.matrix());
    wire::Memory {
        sequence,
        task_velocities: memory.task_velocities.iter().map(|velocity| velocity.as_slice().to_vec()).collect(),
        initial_pose: wire::FramePose {
            position: [position.x, position.y, position.z],
            rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)])),
        },
        last_command: memory.last_command.as_slice().to_vec(),
        active_set: memory.active_set.iter().map(|set| set.iter().map(name).collect()).collect(),
    }
}

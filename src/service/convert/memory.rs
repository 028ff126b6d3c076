//! The memory of stateless steps, in requests and answers.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3};
use revprio_api::wire;
use revprio_core::controller::{AnsweredState, Controller, ControllerConfig, JerkState, Memory, Progress, Stall};
use revprio_core::limits::DriveState;
use revprio_core::linalg::Vector;
use revprio_core::resolution::{ActiveSet, Bound, BoundId};
use revprio_robot::Joint;

use super::numbers::{check_numbers, joint_list, number, numbers};
use super::state_rules::{LastState, MAX_VALID_FOR_MS};
use super::step::check_sequence;
use super::target_memory::{target_streams, target_streams_answer};
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
        drive: drive_state(memory, config)?,
        answered: answered_state(memory, config)?,
        jerk: memory.jerk.as_ref().map(|state| jerk_state(state, config)).transpose()?,
        active_set: memory.active_set.iter().map(|set| active_set(set, config)).collect::<Result<_, _>>()?,
        target_streams: target_streams(&memory.target_streams, config)?,
        initial_position: initial_position(memory, config)?,
        progress: memory.task_progress.iter().map(progress).collect(),
        stalls: stalls(&memory.stalls, config)?,
        in_transition: memory.in_transition,
    })
}

fn initial_position(memory: &wire::Memory, config: &ControllerConfig) -> Result<Option<Vector>, ApiError> {
    let read = |position: &Vec<f64>| joint_list(position, config.robot.joint_count(), "/initial_joint_position");
    Ok(memory.initial_joint_position.as_ref().map(read).transpose()?.map(Vector::from_vec))
}

fn progress(progress: &wire::Progress) -> Progress {
    let wire::Progress { share, slow_since_s, leaving_since_s, attempts } = *progress;
    Progress { share, slow_since_s, leaving_since_s, attempts }
}

fn progress_answer(progress: &Progress) -> wire::Progress {
    let Progress { share, slow_since_s, leaving_since_s, attempts } = *progress;
    wire::Progress { share, slow_since_s, leaving_since_s, attempts }
}

/// Reads the joints that did not follow; all others did.
fn stalls(listed: &[wire::Stall], config: &ControllerConfig) -> Result<Vec<Stall>, ApiError> {
    let joints = config.robot.joints();
    let mut stalls = vec![Stall::NONE; if listed.is_empty() { 0 } else { joints.len() }];
    for (k, wire::Stall { joint: name, commanded, moved, time_s }) in listed.iter().enumerate() {
        let inside = |error: ApiError| error.inside(&format!("/stalls/{k}"));
        let joint = joints.iter().position(|joint| joint.name == *name).ok_or_else(|| {
            let message = "not a joint of this robot; send the memory of the last answer unchanged";
            inside(ApiError::invalid("/joint", message))
        })?;
        let read = |value, pointer| number(value, pointer).map_err(inside);
        let (commanded, moved) = (read(*commanded, "/commanded")?, read(*moved, "/moved")?);
        stalls[joint] = Stall { commanded, moved, time_s: read(*time_s, "/time_s")? };
    }
    Ok(stalls)
}

/// Returns the joints that did not follow.
fn stalls_answer(stalls: &[Stall], config: &ControllerConfig) -> Vec<wire::Stall> {
    let entry = |(joint, &stall): (&Joint, &Stall)| {
        let Stall { commanded, moved, time_s } = stall;
        (stall != Stall::NONE).then(|| wire::Stall { joint: joint.name.clone(), commanded, moved, time_s })
    };
    config.robot.joints().iter().zip(stalls).filter_map(entry).collect()
}

fn drive_state(memory: &wire::Memory, config: &ControllerConfig) -> Result<DriveState, ApiError> {
    let joints = config.robot.joint_count();
    let list = |values: &Vec<f64>, pointer: &str| joint_list(values, joints, pointer).map(Vector::from_vec);
    let Some(state) = &memory.drive else {
        return Ok(DriveState::moving(config.drive, &list(&memory.last_command, "/last_command")?));
    };
    let pending = |(k, command): (usize, &Vec<f64>)| list(command, &format!("/drive/pending/{k}"));
    Ok(DriveState {
        velocity: list(&state.velocity, "/drive/velocity")?,
        pending: state.pending.iter().enumerate().map(pending).collect::<Result<_, _>>()?,
    })
}

fn answered_state(memory: &wire::Memory, config: &ControllerConfig) -> Result<Option<AnsweredState>, ApiError> {
    let wire::Memory { time_s: Some(time_s), joint_position: Some(position), valid_for_ms: Some(valid_for_ms), .. } =
        memory
    else {
        return Ok(None);
    };
    if *valid_for_ms > MAX_VALID_FOR_MS {
        return Err(ApiError::invalid("/valid_for_ms", format!("give at most {MAX_VALID_FOR_MS} ms")));
    }
    Ok(Some(AnsweredState {
        time_s: number(*time_s, "/time_s")?,
        joint_position: joint_list(position, config.robot.joint_count(), "/joint_position").map(Vector::from_vec)?,
        valid_for_ms: *valid_for_ms,
    }))
}

fn jerk_state(state: &wire::JerkState, config: &ControllerConfig) -> Result<JerkState, ApiError> {
    let list = |values: &Vec<f64>, pointer: &str| {
        joint_list(values, config.robot.joint_count(), pointer).map(Vector::from_vec)
    };
    Ok(JerkState {
        acceleration: list(&state.acceleration, "/jerk/acceleration")?,
        requested: list(&state.requested, "/jerk/requested")?,
    })
}

/// Reads the last state from the memory of a stateless step; `None` if it has none.
pub fn last_state(memory: Option<&wire::Memory>, controller: &Controller) -> Result<Option<LastState>, ApiError> {
    let Some(wire::Memory { sequence, time_s: Some(time_s), joint_position: Some(position), .. }) = memory else {
        return Ok(None);
    };
    let joints = controller.config().robot.joint_count();
    let read = |position| {
        let (time_s, joint_position) = (number(*time_s, "/time_s")?, joint_list(position, joints, "/joint_position")?);
        Ok(Some(LastState { sequence: *sequence, time_s, joint_position }))
    };
    read(position).map_err(|error: ApiError| error.inside("/memory"))
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
    let id = |limit: &wire::ActiveLimitName| match (&limit.joint, &limit.inequality, &limit.task, limit.row) {
        (Some(name), None, None, None) => {
            config.robot.joints().iter().position(|joint| joint.name == *name).map(BoundId::Joint)
        }
        (None, Some(name), None, None) => {
            let index = config.barriers.iter().position(|barrier| barrier.name() == name)?;
            Some(BoundId::Constraint { index, row: 0 })
        }
        (None, None, Some(name), Some(row)) => {
            let index = config.tasks.iter().position(|task| task.name == *name)?;
            (row < config.tasks[index].rows.len()).then_some(BoundId::Task { index, row })
        }
        _ => None,
    };
    let unknown = || {
        ApiError::invalid("/active_set", "not a limit of this controller; send the memory of the last answer unchanged")
    };
    let limit =
        |limit: &wire::ActiveLimitName| Ok(Bound { id: id(limit).ok_or_else(unknown)?, side: terms::side(limit.side) });
    names.iter().map(limit).collect()
}

/// Returns the name of a bound of an active set.
fn limit_name(config: &ControllerConfig, bound: &Bound) -> wire::ActiveLimitName {
    let (mut joint, mut inequality, mut task, mut row) = (None, None, None, None);
    match bound.id {
        BoundId::Joint(index) => joint = Some(config.robot.joints()[index].name.clone()),
        BoundId::Constraint { index, .. } => inequality = Some(config.barriers[index].name().to_owned()),
        BoundId::Task { index, row: own } => (task, row) = (Some(config.tasks[index].name.clone()), Some(own)),
    }
    wire::ActiveLimitName { joint, inequality, task, row, side: terms::side_answer(bound.side) }
}

/// Returns the memory as a part of an answer.
pub fn memory_answer(controller: &Controller, last: LastState, memory: &Memory) -> wire::Memory {
    let name = |limit: &Bound| limit_name(controller.config(), limit);
    let (position, rotation) = (&memory.initial_pose.translation, memory.initial_pose.rotation.matrix());
    wire::Memory {
        sequence: last.sequence,
        time_s: Some(last.time_s),
        joint_position: Some(last.joint_position),
        valid_for_ms: memory.answered.as_ref().map(|answered| answered.valid_for_ms),
        task_velocities: memory.task_velocities.iter().map(|velocity| velocity.as_slice().to_vec()).collect(),
        initial_pose: wire::FramePose {
            position: [position.x, position.y, position.z],
            rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| rotation[(i, j)])),
        },
        last_command: memory.last_command.as_slice().to_vec(),
        drive: Some(wire::DriveState {
            velocity: memory.drive.velocity.as_slice().to_vec(),
            pending: memory.drive.pending.iter().map(|command| command.as_slice().to_vec()).collect(),
        }),
        jerk: memory.jerk.as_ref().map(|state| wire::JerkState {
            acceleration: state.acceleration.as_slice().to_vec(),
            requested: state.requested.as_slice().to_vec(),
        }),
        active_set: memory.active_set.iter().map(|set| set.iter().map(name).collect()).collect(),
        target_streams: target_streams_answer(&memory.target_streams, controller.config()),
        initial_joint_position: memory.initial_position.as_ref().map(|position| position.as_slice().to_vec()),
        task_progress: memory.progress.iter().map(progress_answer).collect(),
        stalls: stalls_answer(&memory.stalls, controller.config()),
        in_transition: memory.in_transition,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::service::convert::controller;
    use crate::service::robots::Robots;

    /// A controller with an inequality, and tasks of two rows and of one row.
    const CONTROLLER: &str = r#"{"robot": "sawyer_dh", "period_s": 0.001,
        "inequalities": [{"kind": "plane", "name": "wall", "normal": [1, 0, 0], "offset_m": 1}],
        "tasks": [{"name": "a", "axes": ["x", "y"], "upper": [1, 1]}, {"name": "b", "axes": ["z"], "lower": [0]}]}"#;

    #[test]
    fn every_place_of_an_active_set_has_a_name_that_is_read_back() {
        let request: wire::Controller = serde_json::from_str(CONTROLLER).unwrap();
        let controller = controller(&request, &Robots::built_in()).unwrap();
        let config = controller.config();
        let joints = (0..7).map(BoundId::Joint);
        let rows = [(0, 0), (0, 1), (1, 0)].map(|(index, row)| BoundId::Task { index, row });
        let ids = joints.chain([BoundId::Constraint { index: 0, row: 0 }]).chain(rows);
        let places: ActiveSet = ids.map(Bound::upper).collect();
        let names: Vec<_> = places.iter().map(|limit| limit_name(config, limit)).collect();
        assert_eq!(active_set(&names, config).unwrap(), places);
        let written: Vec<String> = names[6..].iter().map(|name| serde_json::to_string(name).unwrap()).collect();
        assert_eq!(
            written,
            [
                r#"{"joint":"j7","side":"upper"}"#,
                r#"{"inequality":"wall","side":"upper"}"#,
                r#"{"task":"a","row":0,"side":"upper"}"#,
                r#"{"task":"a","row":1,"side":"upper"}"#,
                r#"{"task":"b","row":0,"side":"upper"}"#
            ]
        );
    }
}

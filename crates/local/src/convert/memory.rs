//! The memory of stateless steps, in requests and answers.

use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3};
use revprio_api::wire;
use revprio_core::controller::{AnsweredState, Controller, ControllerConfig, JerkState, Memory, Progress, Stall};
use revprio_core::limits::DriveState;
use revprio_core::resolution::{ActiveSet, Bound, BoundId};
use revprio_robot::Joint;

use super::channels;
use super::checks::{Inside, Result, check, each, foreign};
use super::contact::{contact_memory, contact_memory_answer};
use super::controller::MAX_VALID_FOR_MS;
use super::numbers::{check_numbers, joint_index, joint_list, number, numbers, time};
use super::rest_memory::{rest_state, rest_state_answer};
use super::step::check_sequence;
use super::target_memory::{target_streams, target_streams_answer};
use super::terms;
use super::virtual_arm_memory::{virtual_arm, virtual_arm_answer};
use super::wrench_sensor::{sensor_memory, sensor_memory_answer};
use crate::error::ApiError;
use crate::state_rules::LastState;

/// Maximum deviation of RᵀR from the identity. The matrices of the service deviate by 1e-15.
const MAX_ROTATION_ERROR: f64 = 1e-9;

/// Reads the memory of a stateless step with this sequence number; `None` at the first step. Pointers begin at the whole
/// request.
pub fn memory(memory: Option<&wire::Memory>, sequence: u64, controller: &Controller) -> Result<Option<Memory>> {
    let Some(memory) = memory else { return Ok(None) };
    check_sequence(memory.sequence, sequence).inside("/state")?;
    read(memory, controller.config()).map(Some).inside("/memory")
}

fn read(memory: &wire::Memory, config: &ControllerConfig) -> Result<Memory> {
    let joints = |values: &Vec<f64>, pointer: &str| joint_list(values, config.robot.joint_count(), pointer);
    let jerk = |jerk: &wire::JerkState| {
        let acceleration = joints(&jerk.acceleration, "/jerk/acceleration")?;
        Ok(JerkState { acceleration, requested: joints(&jerk.requested, "/jerk/requested")? })
    };
    let initial_position = |position| joints(position, "/initial_joint_position");
    let task_velocities = each("/task_velocities", &memory.task_velocities, |_, values| numbers(values, ""))?;
    let initial_pose = pose(&memory.initial_pose)?;
    let last_command = joints(&memory.last_command, "/last_command")?;
    Ok(Memory {
        task_velocities,
        start_time_s: memory.start_time_s.map_or(Ok(0.0), |start| time(start, "/start_time_s"))?,
        initial_pose,
        drive: match &memory.drive {
            None => DriveState::moving(config.drive, &last_command),
            Some(drive) => DriveState {
                velocity: joints(&drive.velocity, "/drive/velocity")?,
                pending: each("/drive/pending", &drive.pending, |_, command| joints(command, ""))?,
            },
        },
        last_command,
        answered: answered_state(memory, config)?,
        jerk: memory.jerk.as_ref().map(jerk).transpose()?,
        active_set: memory.active_set.iter().map(|set| active_set(set, config)).collect::<Result<_>>()?,
        target_streams: target_streams(&memory.target_streams, config)?,
        initial_position: memory.initial_joint_position.as_ref().map(initial_position).transpose()?,
        progress: memory.task_progress.iter().map(progress).collect(),
        rest: memory.rest.as_ref().map(|rest| rest_state(rest, config)).transpose().inside("/rest")?,
        stalls: stalls(&memory.stalls, config)?,
        virtual_arm: memory.virtual_arm.as_ref().map(virtual_arm).transpose().inside("/virtual_arm")?,
        contacts: contact_memory(&memory.contacts, config)?,
        wrench_sensors: sensor_memory(&memory.wrench_sensors, config)?,
        in_transition: memory.in_transition,
        channels: channels::memory(&memory.channels, config)?,
    })
}

fn progress(progress: &wire::Progress) -> Progress {
    let wire::Progress { share, slow_since_s, leaving_since_s, attempts, left_at } = *progress;
    Progress { share, slow_since_s, leaving_since_s, attempts, left_at }
}

fn progress_answer(progress: &Progress) -> wire::Progress {
    let Progress { share, slow_since_s, leaving_since_s, attempts, left_at } = *progress;
    wire::Progress { share, slow_since_s, leaving_since_s, attempts, left_at }
}

/// Reads the joints that did not follow; all others did.
fn stalls(listed: &[wire::Stall], config: &ControllerConfig) -> Result<Vec<Stall>> {
    let read = |_, stall: &wire::Stall| {
        let joint = joint_index(&config.robot, &stall.joint);
        let joint = joint.ok_or_else(|| foreign("/joint", "not a joint of this robot"))?;
        let (commanded, moved) = (number(stall.commanded, "/commanded")?, number(stall.moved, "/moved")?);
        Ok((joint, Stall { commanded, moved, time_s: number(stall.time_s, "/time_s")? }))
    };
    let mut stalls = vec![Stall::NONE; if listed.is_empty() { 0 } else { config.robot.joint_count() }];
    for (joint, stall) in each::<_, _, Vec<_>>("/stalls", listed, read)? {
        stalls[joint] = stall;
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

/// Reads time and joint position of the last state, if the memory has both.
fn last_position(memory: &wire::Memory, config: &ControllerConfig) -> Result<Option<(f64, Vec<f64>)>> {
    let (Some(time_s), Some(position)) = (memory.time_s, &memory.joint_position) else { return Ok(None) };
    let time_s = time(time_s, "/time_s")?;
    Ok(Some((time_s, joint_list(position, config.robot.joint_count(), "/joint_position")?)))
}

fn answered_state(memory: &wire::Memory, config: &ControllerConfig) -> Result<Option<AnsweredState>> {
    let Some((valid_for_ms, (time_s, position))) = memory.valid_for_ms.zip(last_position(memory, config)?) else {
        return Ok(None);
    };
    check(valid_for_ms <= MAX_VALID_FOR_MS, "/valid_for_ms", format_args!("give at most {MAX_VALID_FOR_MS} ms"))?;
    let way = memory.way.as_ref().map(|way| joint_list(way, config.robot.joint_count(), "/way")).transpose()?;
    let stop_time_s = memory.stop_time_s;
    let is_time = stop_time_s.is_none_or(|time| time > 0.0 && time <= 1e9);
    check(is_time, "/stop_time_s", format_args!("give a positive number up to 1e9"))?;
    Ok(Some(AnsweredState { time_s, joint_position: position.into(), way, valid_for_ms, stop_time_s }))
}

/// Reads the last state from the memory of a stateless step; `None` if it has none.
pub fn last_state(memory: Option<&wire::Memory>, controller: &Controller) -> Result<Option<LastState>> {
    let Some(memory) = memory else { return Ok(None) };
    let state = |(time_s, joint_position)| LastState { sequence: memory.sequence, time_s, joint_position };
    last_position(memory, controller.config()).map(|found| found.map(state)).inside("/memory")
}

fn pose(pose: &wire::FramePose) -> Result<IsometryMatrix3<f64>> {
    check_numbers(&pose.position, "/initial_pose/position")?;
    let matrix = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
    let error = (matrix.transpose() * matrix - Matrix3::identity()).amax();
    if !(error <= MAX_ROTATION_ERROR && matrix.determinant() > 0.0) {
        return Err(foreign("/initial_pose/rotation", "not a rotation matrix"));
    }
    let position = Translation3::from(pose.position);
    Ok(IsometryMatrix3::from_parts(position, Rotation3::from_matrix_unchecked(matrix)))
}

fn active_set(names: &[wire::ActiveLimitName], config: &ControllerConfig) -> Result<ActiveSet, ApiError> {
    let id = |limit: &wire::ActiveLimitName| match (&limit.joint, &limit.inequality, &limit.task, limit.row) {
        (Some(name), None, None, None) => {
            config.robot.joints().iter().position(|joint| joint.name == *name).map(BoundId::Joint)
        }
        (None, Some(name), None, row) => {
            let index = config.constraints.iter().position(|constraint| constraint.name() == name)?;
            let row = row.unwrap_or(0);
            (row < config.constraints[index].row_count()).then_some(BoundId::Constraint { index, row })
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
        BoundId::Constraint { index, row: own } => {
            inequality = Some(config.constraints[index].name().to_owned());
            // The first row needs no number: most constraints have one row.
            row = Some(own).filter(|own| *own > 0);
        }
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
        start_time_s: Some(memory.start_time_s).filter(|start| *start > 0.0),
        valid_for_ms: memory.answered.as_ref().map(|answered| answered.valid_for_ms),
        stop_time_s: memory.answered.as_ref().and_then(|answered| answered.stop_time_s),
        way: memory.answered.as_ref().and_then(|answered| Some(answered.way.as_ref()?.as_slice().to_vec())),
        task_velocities: memory.task_velocities.iter().map(|velocity| velocity.as_slice().to_vec()).collect(),
        initial_pose: wire::FramePose {
            position: position.vector.into(),
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
        rest: memory.rest.as_ref().map(|rest| rest_state_answer(rest, controller.config())),
        virtual_arm: memory.virtual_arm.as_ref().map(virtual_arm_answer),
        contacts: contact_memory_answer(&memory.contacts),
        wrench_sensors: sensor_memory_answer(&memory.wrench_sensors),
        in_transition: memory.in_transition,
        channels: channels::memory_answer(&memory.channels, controller.config()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convert::controller;
    use crate::robots::Robots;

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

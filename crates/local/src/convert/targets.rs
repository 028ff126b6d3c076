//! Streamed targets: their settings, and the targets of a state.

use std::collections::BTreeMap;

use revprio_api::wire;
use revprio_core::controller::{Controller, TaskConfig};
use revprio_core::streaming::{
    Quantity, StreamedChunk, StreamedTarget, StreamedValue, Streaming, TargetAhead, TargetError,
};
use revprio_robot::RobotModel;

use super::checks::{Inside, Result, each};
use super::chunks;
use super::numbers::{number, time};
use super::profile::PerRow;
use super::target_values::{joint_positions, misfit, place, read_pose, rows};
use crate::error::ApiError;

/// Reads the settings of a task with `rows` rows.
pub fn streaming(given: Option<&wire::Streaming>, rows: usize) -> Result<Streaming> {
    let Some(given) = given else { return Ok(Streaming::default()) };
    let default = Streaming::default();
    let bounds = |values: &Option<wire::PerAxis<f64>>, field: &str| {
        values.as_ref().map(|values| PerRow { rows }.numbers(values, field)).transpose()
    };
    Ok(Streaming {
        hold_after_s: given.hold_after_s.unwrap_or(default.hold_after_s),
        brake_after_s: given.brake_after_s.unwrap_or(default.brake_after_s),
        delay_s: given.delay_s.unwrap_or(default.delay_s),
        smoothing_s: given.smoothing_s.unwrap_or(default.smoothing_s),
        fade_s: given.fade_s.unwrap_or(default.fade_s),
        max_velocity: bounds(&given.max_velocity, "/max_velocity")?,
        max_acceleration: bounds(&given.max_acceleration, "/max_acceleration")?,
    })
}

/// Reads the targets of a state at `time_s`.
pub fn targets(
    given: &BTreeMap<String, wire::StreamedTarget>,
    time_s: f64,
    controller: &Controller,
) -> Result<(Vec<StreamedTarget>, Vec<StreamedChunk>)> {
    let (mut targets, mut chunks) = (Vec::with_capacity(given.len()), Vec::new());
    for (name, target) in given {
        let inside = |error: ApiError| error.inside(&place(name));
        let task = task_index(name, controller).map_err(inside)?;
        if target.chunk.is_some() || target.align.is_some() {
            chunks.extend(chunks::read(target, task, controller).map_err(inside)?);
        } else {
            targets.extend(read(target, task, time_s, controller).map_err(inside)?);
        }
    }
    Ok((targets, chunks))
}

fn task_index(name: &str, controller: &Controller) -> Result<usize> {
    let tasks = &controller.config().tasks;
    tasks.iter().position(|task| task.name == name).ok_or_else(|| {
        let known = tasks.iter().map(|task| format!("`{}`", task.name)).collect::<Vec<_>>().join(", ");
        ApiError::invalid("", format!("there is no task `{name}`; the tasks of this controller: {known}"))
    })
}

/// Reads the target of one task: one or two quantities.
fn read(
    given: &wire::StreamedTarget,
    index: usize,
    time_s: f64,
    controller: &Controller,
) -> Result<Vec<StreamedTarget>> {
    let task = &controller.config().tasks[index];
    let accepts = |quantity: Quantity| task.accepts(quantity);
    let velocity_fits = accepts(Quantity::Velocity) || given.pose.is_some() || given.joint_position.is_some();
    for (field, is_given, fits) in [
        ("pose", given.pose.is_some(), accepts(Quantity::Pose)),
        ("joint_position", given.joint_position.is_some(), accepts(Quantity::JointPosition)),
        ("force", given.force.is_some(), accepts(Quantity::Force)),
        ("velocity", given.velocity.is_some(), velocity_fits),
    ] {
        if is_given && !fits {
            return Err(ApiError::invalid(format!("/{field}"), misfit(task)));
        }
    }
    let time_s = given.time_s.map_or(Ok(time_s), |given| time(given, "/time_s"))?;
    let mut values = Vec::new();
    if let Some(pose) = &given.pose {
        values.push(read_pose(pose, task).inside("/pose")?);
    }
    if let Some(position) = &given.joint_position {
        values.push(StreamedValue::JointPosition(joint_positions(position, task, &controller.config().robot)?));
    }
    if let Some(force) = &given.force {
        values.push(StreamedValue::Force(rows(force, task, "/force")?));
    }
    let velocity = given.velocity.as_ref().map(|velocity| rows(velocity, task, "/velocity")).transpose()?;
    if let Some(velocity) = velocity.as_ref().filter(|_| accepts(Quantity::Velocity)) {
        values.push(StreamedValue::Velocity(velocity.clone()));
    }
    if values.is_empty() {
        return Err(ApiError::invalid("", misfit(task)));
    }
    let ahead: Vec<_> = each("/ahead", &given.ahead, |_, ahead| read_ahead(ahead, task, &controller.config().robot))?;
    let target = |value: StreamedValue| {
        let is_position = value.quantity().is_position();
        let velocity = velocity.clone().filter(|_| is_position);
        let ahead = if is_position { ahead.clone() } else { Vec::new() };
        StreamedTarget { task: index, time_s, value, velocity, ahead }
    };
    if !(ahead.is_empty() || values.iter().any(|value| value.quantity().is_position())) {
        return Err(ApiError::invalid("/ahead", "only a `pose` or a `joint_position` can have targets ahead"));
    }
    Ok(values.into_iter().map(target).collect())
}

/// Reads a target of a later time.
fn read_ahead(given: &wire::TargetAhead, task: &TaskConfig, robot: &RobotModel) -> Result<TargetAhead> {
    let value = match (&given.pose, &given.joint_position) {
        (Some(pose), None) if task.accepts(Quantity::Pose) => read_pose(pose, task).inside("/pose")?,
        (None, Some(position)) if task.accepts(Quantity::JointPosition) => {
            StreamedValue::JointPosition(joint_positions(position, task, robot)?)
        }
        _ => return Err(ApiError::invalid("", misfit(task))),
    };
    Ok(TargetAhead { after_s: number(given.after_s, "/after_s")?, value })
}

/// Checks the times of targets.
pub fn check_times(targets: &[StreamedTarget], time_s: f64, controller: &Controller) -> Result<()> {
    for target in targets {
        let field = |error: &TargetError| match error {
            TargetError::Ahead { .. } => "/time_s".to_owned(),
            TargetError::Foresight { index } => format!("/ahead/{index}"),
            _ => String::new(),
        };
        target.check(controller.config(), time_s).map_err(|error| {
            let place = place(&controller.config().tasks[target.task].name);
            ApiError::invalid(format!("{place}{}", field(&error)), error)
        })?;
    }
    Ok(())
}

//! Streamed targets: their settings, and the targets of a state.

use std::collections::BTreeMap;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_api::wire::{self, JointVector};
use revprio_core::controller::{Controller, TaskConfig};
use revprio_core::rows::TaskRows;
use revprio_core::streaming::{Quantity, StreamedTarget, StreamedValue, Streaming, TargetAhead, TargetError};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::pose as pose_of;

use super::checks::{Inside, Refused, Result, check, each};
use super::numbers::{by_name, check_numbers, number, numbers, time};
use super::profile::PerRow;
use crate::service::error::{ApiError, escape_pointer};

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
        max_velocity: bounds(&given.max_velocity, "/max_velocity")?,
        max_acceleration: bounds(&given.max_acceleration, "/max_acceleration")?,
    })
}

/// Reads the targets of a state at `time_s`.
pub fn targets(
    given: &BTreeMap<String, wire::StreamedTarget>,
    time_s: f64,
    controller: &Controller,
) -> Result<Vec<StreamedTarget>> {
    let mut targets = Vec::with_capacity(given.len());
    for (name, target) in given {
        let read = task_index(name, controller).and_then(|task| read(target, task, time_s, controller));
        targets.extend(read.map_err(|error| error.inside(&place(name)))?);
    }
    Ok(targets)
}

/// Returns the JSON pointer of the target of a task.
fn place(task: &str) -> String {
    format!("/targets/{}", escape_pointer(task))
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

/// Explains which targets a task accepts.
fn misfit(task: &TaskConfig) -> String {
    let name = &task.name;
    let accepted = |quantity: &Quantity| match quantity {
        Quantity::Pose => "`pose`, if known with its `velocity`",
        Quantity::JointPosition => "`joint_position`, if known with its `velocity`",
        Quantity::Velocity => "`velocity`",
        Quantity::Force => "`force`",
    };
    match task.quantities().iter().map(accepted).collect::<Vec<_>>().as_slice() {
        [] => format!(
            "task `{name}` follows no target, because it has bounds, the target `mid_range` or the law `look_at`"
        ),
        accepted => format!("a target of task `{name}` is {}", accepted.join(", or ")),
    }
}

fn rows(values: &[f64], task: &TaskConfig, pointer: &str) -> Result<Vec<f64>> {
    let (given, expected, name) = (values.len(), task.rows.len(), &task.name);
    let detail = format_args!("{given} numbers for {expected} rows of task `{name}`; give one per row");
    check(given == expected, pointer, detail)?;
    numbers(values, pointer)
}

fn read_pose(pose: &wire::StreamedPose, task: &TaskConfig) -> Result<StreamedValue> {
    let has_axis = |is_linear: bool| match &task.rows {
        TaskRows::Tool(rows) => rows.axes.axes().iter().any(|axis| (axis.index() < 3) == is_linear),
        _ => false,
    };
    for (field, is_given, is_linear) in
        [("position", pose.position.is_some(), true), ("orientation", pose.orientation.is_some(), false)]
    {
        let (name, kind) = (&task.name, if is_linear { "a linear" } else { "an angular" });
        let detail = format_args!("task `{name}` has {kind} axis and needs the `{field}`");
        check(is_given || !has_axis(is_linear), "", detail)?;
    }
    pose.position.map_or(Ok(()), |position| check_numbers(&position, "/position"))?;
    let orientation = pose.orientation.map(|wire::Orientation { w, x, y, z }| {
        let pose = pose_of([0.0; 3], [w, x, y, z]).at("/orientation")?;
        Ok(UnitQuaternion::from_rotation_matrix(&pose.rotation))
    });
    Ok(StreamedValue::Pose { position: pose.position.map(Vector3::from), orientation: orientation.transpose()? })
}

/// Reads one position per joint of the task.
fn joint_positions(given: &JointVector, task: &TaskConfig, robot: &RobotModel) -> Result<Vec<f64>> {
    let field = "/joint_position";
    let named = match given {
        JointVector::Ordered(values) => return rows(values, task, field),
        JointVector::Named(named) => named,
    };
    let names: Vec<&str> = task.rows.joints().iter().map(|&joint| robot.joints()[joint].name.as_str()).collect();
    let unknown = |name: &str| format!("task `{}` has no joint `{name}`; its joints: {}", task.name, names.join(", "));
    by_name(named, &names, field, unknown, |name| format!("the position of joint `{name}` is missing"))
}

//! Chunks of actions.

use revprio_api::wire;
use revprio_core::controller::{Controller, TaskConfig};
use revprio_core::streaming::{Action, Align, ChunkReport, Quantity, StreamedChunk, StreamedValue};
use revprio_robot::RobotModel;

use super::channels;
use super::checks::{Inside, Result, check, each};
use super::numbers::time;
use super::target_values::{action_misfit, joint_positions, place, read_pose, rows};
use crate::error::ApiError;

/// Reads the chunk of a task: one for each quantity of its actions.
pub fn read(given: &wire::StreamedTarget, task: usize, controller: &Controller) -> Result<Vec<StreamedChunk>> {
    let wire::StreamedTarget { time_s, pose, joint_position, velocity, force, ahead, chunk, align } = given;
    let Some(actions) = chunk else {
        return Err(ApiError::invalid("/align", "`align` is for a `chunk`; omit it, or give a chunk"));
    };
    let is_alone = time_s.is_none() && pose.is_none() && joint_position.is_none() && ahead.is_empty();
    let detail = "a chunk stands alone: give its times and values in its actions, and no target next to it";
    check(is_alone && velocity.is_none() && force.is_none(), "/chunk", detail)?;
    let config = controller.config();
    let read: Vec<Vec<Action>> =
        each("/chunk", actions, |_, action| read_action(action, &config.tasks[task], &config.robot))?;
    let quantities = |actions: &[Action]| actions.iter().map(|action| action.value.quantity()).collect::<Vec<_>>();
    let first = read.first().map(|first| quantities(first)).unwrap_or_default();
    if let Some(other) = read.iter().position(|actions| quantities(actions) != first) {
        let detail = "this action has other fields than the first one; send chunks of one kind";
        return Err(ApiError::invalid(format!("/chunk/{other}"), detail));
    }
    check(!first.is_empty(), "/chunk", revprio_core::streaming::ChunkError::Empty)?;
    let align = match align.unwrap_or_default() {
        wire::ChunkAlign::Time => Align::Time,
        wire::ChunkAlign::Progress => Align::Progress,
    };
    let mut channels = channels::of_actions(actions, config).inside("/chunk")?;
    let mut of_quantity = |k: usize| {
        let actions = read.iter().map(|actions| actions[k].clone()).collect();
        // The channels are followed with the first quantity.
        StreamedChunk { task, actions, align, channels: std::mem::take(&mut channels) }
    };
    Ok((0..first.len()).map(&mut of_quantity).collect())
}

/// Reads the values of an action: one or two quantities.
fn read_action(given: &wire::ChunkAction, task: &TaskConfig, robot: &RobotModel) -> Result<Vec<Action>> {
    let wire::ChunkAction { time_s, pose, position, orientation, joint_position, velocity, force, .. } = given;
    let time_s = time(*time_s, "/time_s")?;
    let has_parts = position.is_some() || orientation.is_some();
    check(pose.is_none() || !has_parts, "/pose", "give a `pose`, or `position` and `orientation`, not both")?;
    let parts = has_parts.then_some(wire::StreamedPose { position: *position, orientation: *orientation });
    let mut values = Vec::new();
    if let Some(pose) = pose.or(parts) {
        let pointer = if has_parts { "" } else { "/pose" };
        accepted(task, Quantity::Pose, pointer)?;
        values.push(read_pose(&pose, task).inside(pointer)?);
    }
    if let Some(position) = joint_position {
        accepted(task, Quantity::JointPosition, "/joint_position")?;
        values.push(StreamedValue::JointPosition(joint_positions(position, task, robot)?));
    }
    if let Some(velocity) = velocity {
        accepted(task, Quantity::Velocity, "/velocity")?;
        values.push(StreamedValue::Velocity(rows(velocity, task, "/velocity")?));
    }
    if let Some(force) = force {
        accepted(task, Quantity::Force, "/force")?;
        values.push(StreamedValue::Force(rows(force, task, "/force")?));
    }
    if values.is_empty() {
        return Err(ApiError::invalid("", action_misfit(task)));
    }
    Ok(values.into_iter().map(|value| Action { time_s, value }).collect())
}

/// Refuses an action of a quantity that the task does not follow.
fn accepted(task: &TaskConfig, quantity: Quantity, pointer: &str) -> Result<()> {
    if task.accepts(quantity) { Ok(()) } else { Err(ApiError::invalid(pointer, action_misfit(task))) }
}

/// Checks the times of chunks.
pub fn check_times(chunks: &[StreamedChunk], time_s: f64, controller: &Controller) -> Result<()> {
    for chunk in chunks {
        chunk.check(controller.config(), time_s).map_err(|error| {
            let place = place(&controller.config().tasks[chunk.task].name);
            let field = if error.is_of_time() { "/time_s" } else { "" };
            let action = error.index().map(|index| format!("/{index}{field}")).unwrap_or_default();
            ApiError::invalid(format!("{place}/chunk{action}"), error)
        })?;
    }
    Ok(())
}

/// Returns the chunk that a task follows as a part of an answer.
pub fn status(report: ChunkReport) -> wire::ChunkStatus {
    wire::ChunkStatus {
        actions_left: report.actions_left,
        ends_in_s: report.ends_in_s,
        dropped: report.merged.map(|merged| merged.dropped),
        shift_s: report.merged.map(|merged| merged.shift_s),
    }
}

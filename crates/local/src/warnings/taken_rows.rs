//! Warnings about tasks whose axes are moved by tasks of higher priority: they cannot press, and cannot slow down.

use revprio_api::wire::{self, Axis, Law};

/// Returns the warnings about all tasks.
pub fn warnings(request: &wire::Controller) -> impl Iterator<Item = String> {
    pressing(request).chain(scaled(request))
}

/// Returns a warning for each axis of a law `contact` that an earlier task moves.
fn pressing(request: &wire::Controller) -> impl Iterator<Item = String> {
    let presses = |(_, task): &(usize, &wire::ControllerTask)| matches!(task.law, Some(Law::Contact { .. }));
    request.tasks.iter().enumerate().filter(presses).flat_map(move |(k, pressing)| {
        pressing.axes.iter().flatten().filter_map(move |axis| {
            let first = request.tasks[..k].iter().find(|task| moves(task, *axis, pressing))?;
            Some(format!(
                "task `{}` cannot press along {axis}, which `{}` before it moves already; put `{0}` first, or leave {axis} out of `{1}`",
                pressing.name, first.name
            ))
        })
    })
}

/// Returns a warning for each scaled task to which the tasks before it leave no axis: limits do not damp it.
fn scaled(request: &wire::Controller) -> impl Iterator<Item = String> {
    request.tasks.iter().enumerate().filter(|(_, task)| task.scale).filter_map(|(k, scaled)| {
        let axes = scaled.axes.as_ref().filter(|axes| !axes.is_empty())?;
        let is_taken = |axis: &Axis| request.tasks[..k].iter().any(|task| takes(task, *axis, scaled));
        axes.iter().all(is_taken).then(|| {
            format!(
                "task `{}` has `scale`, but the tasks before it move the same point along all its axes: it uses what little they leave at full speed, and the arm may swing without an end; leave out `scale`",
                scaled.name
            )
        })
    })
}

/// Returns whether a task leaves another one no motion along this axis: it has the same row, or all axes of the kind.
fn takes(task: &wire::ControllerTask, axis: Axis, other: &wire::ControllerTask) -> bool {
    let same_point = task.link == other.link && task.relative_to == other.relative_to;
    let kind = |axis: &Axis| matches!(axis, Axis::X | Axis::Y | Axis::Z);
    let of_kind = task.axes.iter().flatten().filter(|other| kind(other) == kind(&axis)).count();
    moves(task, axis, other) || (task.law.is_some() && same_point && of_kind == 3)
}

/// Returns whether a task has a row of another one along this axis. A task with bounds has no row that it holds.
fn moves(task: &wire::ControllerTask, axis: Axis, pressing: &wire::ControllerTask) -> bool {
    let same_tool = task.link == pressing.link && task.relative_to == pressing.relative_to;
    let same_frame = task.frame == pressing.frame && task.reference_point == pressing.reference_point;
    task.law.is_some() && same_tool && same_frame && task.axes.iter().flatten().any(|other| *other == axis)
}

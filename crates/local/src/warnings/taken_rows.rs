//! Warnings about tasks that cannot press, because a task of higher priority moves the tool along the same axis.

use revprio_api::wire::{self, Axis, Law};

/// Returns a warning for each axis of a law `contact` that an earlier task moves.
pub fn warnings(request: &wire::Controller) -> impl Iterator<Item = String> {
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

/// Returns whether a task has a row of another one along this axis. A task with bounds has no row that it holds.
fn moves(task: &wire::ControllerTask, axis: Axis, pressing: &wire::ControllerTask) -> bool {
    let same_tool = task.link == pressing.link && task.relative_to == pressing.relative_to;
    let same_frame = task.frame == pressing.frame && task.reference_point == pressing.reference_point;
    task.law.is_some() && same_tool && same_frame && task.axes.iter().flatten().any(|other| *other == axis)
}

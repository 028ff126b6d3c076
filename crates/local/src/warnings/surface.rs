//! Warnings about tasks that do not turn with a surface which another task follows.

use revprio_api::wire::{self, Axis, Law};

/// Returns a warning for each task that moves the same tool along other axes than a law with `surface`. It would push the tool into a
/// tilted surface, or off it.
pub fn warnings(request: &wire::Controller) -> impl Iterator<Item = String> {
    let follows = |task: &&wire::ControllerTask| matches!(task.law, Some(Law::Contact { surface: Some(_), .. }));
    request.tasks.iter().filter(follows).flat_map(|pressing| {
        let left_behind = request.tasks.iter().filter(move |task| is_left_behind(task, pressing));
        left_behind.map(|task| {
            format!(
                "task `{}` does not turn with the surface that `{}` follows: their `frame` differs; give both the same, written alike",
                task.name, pressing.name
            )
        })
    })
}

/// Returns whether a task moves the tool of another one along axes that do not turn with it.
fn is_left_behind(task: &wire::ControllerTask, pressing: &wire::ControllerTask) -> bool {
    let is_linear = |axis: &Axis| matches!(axis, Axis::X | Axis::Y | Axis::Z);
    let moves = task.law.is_some() && task.axes.iter().flatten().any(is_linear);
    let same_tool = task.link == pressing.link && task.relative_to == pressing.relative_to;
    moves && same_tool && task.frame != pressing.frame
}

//! Warnings about streamed targets that are late, missing or ignored.

use revprio_core::controller::{Command, Controller, TaskConfig};
use revprio_core::streaming::{Ignored, TargetReport, TargetState};

/// Adds warnings about targets that are late, missing or ignored.
pub fn warn(warnings: &mut Vec<String>, controller: &Controller, command: &Command) {
    for (task, target) in controller.config().tasks.iter().zip(&command.targets) {
        warnings.extend(target.unused.and_then(|ignored| unused(&task.name, ignored)));
        let Some(report) = target.streamed else { continue };
        let touches = target.contact.iter().any(|contact| contact.phase.touches());
        warnings.extend(late(task, &report, touches));
        warnings.extend(report.ignored.and_then(|ignored| unused(&task.name, ignored)));
    }
}

fn unused(task: &str, ignored: Ignored) -> Option<String> {
    match ignored {
        Ignored::Repeated => None,
        Ignored::Older { time_s, newest_s } => Some(format!(
            "task `{task}`: the target or chunk from {time_s} s on is ignored, because it is not newer than the last one, of {newest_s} s; \
             send targets in the order of their times, and a new chunk with a later first action"
        )),
        Ignored::Late { last_s } => Some(format!(
            "task `{task}`: the chunk is ignored, because its last action was due at {last_s} s; send more actions, or align the \
             chunk by `progress`"
        )),
        Ignored::Full => Some(format!(
            "task `{task}`: the chunk is ignored, because it begins after too many actions of earlier chunks; send chunks that \
             begin earlier"
        )),
    }
}

/// `touches`: whether the task presses on a surface, or retreats from one.
fn late(task: &TaskConfig, report: &TargetReport, touches: bool) -> Option<String> {
    let name = &task.name;
    let age = report.age_s.map_or_else(
        || "its targets are past or of another clock".to_owned(),
        |age| format!("its newest target is {age:.3} s old"),
    );
    match report.state {
        TargetState::Following | TargetState::Extrapolating => None,
        TargetState::Holding => Some(format!(
            "task `{name}` holds its last target, because {age}; send targets at least every {} s",
            task.streaming.hold_after_s
        )),
        TargetState::Braking if touches => Some(format!(
            "task `{name}` goes on with its last target force, because {age}; it follows again with the next target. Check the \
             sender and its clock"
        )),
        TargetState::Braking => Some(format!(
            "task `{name}` brakes to rest, because {age}; it follows again with the next target. Check the sender and \
             its clock"
        )),
    }
}

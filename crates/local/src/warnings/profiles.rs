//! Warnings about profiles that have ended before the loop or another controller begins, because they count on another clock than
//! the states, or whose clock stands still.

use revprio_api::wire::{self, LawTarget, Profile};
use revprio_core::controller::UNIX_TIME_S;

/// Until when the target of a task moves, s; infinite if it does for ever.
#[derive(Debug, PartialEq)]
pub struct ProfileEnd {
    task: String,
    end_s: f64,
}

/// Returns the tasks whose target moves.
pub fn ends(request: &wire::Controller) -> Vec<ProfileEnd> {
    let with_law = request.tasks.iter().filter_map(|task| Some((&task.name, task.law.as_ref()?)));
    with_law.filter_map(|(task, law)| Some(ProfileEnd { task: task.clone(), end_s: end_s(target(law)?)? })).collect()
}

/// Adds a warning for each profile that had ended at the time of the first state, s.
pub fn warn(warnings: &mut Vec<String>, ends: &[ProfileEnd], time_s: f64) {
    let missed = ends.iter().filter(|profile| profile.end_s < time_s && time_s <= UNIX_TIME_S);
    warnings.extend(missed.map(|ProfileEnd { task, end_s }| {
        format!(
            "task `{task}`: its profile ended at {end_s} s, before the first state at `time_s` {time_s}, so its target is the end; let \
             the clock of the loop begin at zero, or send Unix time, with which profiles begin at the first state"
        )
    }));
}

/// Adds a warning for each profile of a new controller that has ended when it replaces the old one, at this time of the
/// profiles, s. Profiles that the old one had as well have been followed.
pub fn warn_about_replaced(warnings: &mut Vec<String>, [old, new]: [&[ProfileEnd]; 2], profile_time_s: f64) {
    let missed = new.iter().filter(|profile| profile.end_s < profile_time_s && !old.contains(profile));
    warnings.extend(missed.map(|ProfileEnd { task, end_s }| {
        format!(
            "task `{task}`: its profile ended at {end_s} s, and the clock of the session stands at {profile_time_s} s, so its target is the \
             end at once; add the time of the session to the times of the profile"
        )
    }));
}

/// Adds a warning if a target moves over time, and the time of the state, s, is that of the state before.
pub fn warn_about_clock(warnings: &mut Vec<String>, ends: &[ProfileEnd], before_s: f64, time_s: f64) {
    let moving = ends.iter().find(|profile| profile.end_s > time_s || time_s > UNIX_TIME_S);
    warnings.extend(moving.filter(|_| time_s == before_s).map(|ProfileEnd { task, .. }| {
        format!(
            "`time_s` stands still at {time_s}, and with it the target of task `{task}`; send the time at which each state was measured"
        )
    }));
}

fn target(law: &wire::Law) -> Option<&Profile> {
    match law.target() {
        LawTarget::Velocity(profile) | LawTarget::Joints { position: profile, .. } | LawTarget::Point(profile) => {
            Some(profile)
        }
        LawTarget::Pose { displacement, .. } => displacement,
        LawTarget::None => None,
    }
}

/// Returns when a profile ends, s; `None`: it does not move.
fn end_s(profile: &Profile) -> Option<f64> {
    match profile {
        Profile::Ramp { start_time_s, duration_s, .. } => Some(start_time_s + duration_s),
        Profile::Waypoints { points } | Profile::Steps { points } => {
            points.last().filter(|_| points.len() > 1).map(|point| point.time_s)
        }
        Profile::Sine { .. } => Some(f64::INFINITY),
        Profile::Constant { .. } => None,
    }
}

//! Warnings about new controllers and about streamed targets: sentences that say what to change.

mod channels;
mod contact;
mod deadband;
mod description;
mod free_space;
mod limits;
mod period;
mod profiles;
mod state_bounds;
mod surface;
mod taken_rows;
mod tare;
mod targets;
mod weights;
mod wrench_sensor;

use revprio_api::wire;
use revprio_core::controller::{ControllerConfig, SteepGain};
use revprio_lab::number::significant;

use super::convert::CHARACTERISTIC_LENGTH_M;
use super::error::ApiError;
use super::request_warnings;

pub use channels::warn as warn_about_channels;
pub use description::warnings as of_description;
pub use profiles::{
    ProfileEnd, ends as profile_ends, warn as warn_about_profiles, warn_about_clock, warn_about_replaced,
};
pub use tare::warn as warn_about_tare;
pub use targets::warn as warn_about_targets;
pub use weights::warn as warn_about_weights;

/// Reaches of arms that the default characteristic length of 1 m suits, m.
const ORDINARY_REACH_M: std::ops::RangeInclusive<f64> = 0.3..=4.0;

/// Returns the warnings about a controller, which must be checked before: unstable contacts, tasks that do not follow
/// a surface or cannot press, laws that are unstable in free space, steep gains, a damping that does not suit the size of the arm, then those of [`of_first_step`].
pub fn of_controller(request: &wire::Controller, config: &ControllerConfig) -> Result<Vec<String>, ApiError> {
    let mut warnings = contact::warnings(request)?;
    warnings.extend(deadband::warnings(request));
    warnings.extend(surface::warnings(request));
    warnings.extend(wrench_sensor::warnings(request));
    warnings.extend(taken_rows::warnings(request));
    warnings.extend(state_bounds::warnings(request, config));
    warnings.extend(free_space::warnings(request, config));
    warnings.extend(config.steep_gains().map(|steep| describe(&steep)));
    warnings.extend(description::warnings(&config.robot));
    warnings.extend(unusual_size(request, config));
    warnings.extend(huge_shapes(request, config));
    warnings.extend(uncovered_links(request, config));
    warnings.extend(idle_planes(config));
    warnings.extend(idle_contacts(request, config));
    warnings.extend(of_first_step(request, config));
    Ok(warnings)
}

/// Returns the warnings about a checked controller that the first answer repeats, for loops without a session: a method that does
/// not keep the order of the tasks, numbers in the wrong unit, missing limits, and answers that expire before the next one.
pub fn of_first_step(request: &wire::Controller, config: &ControllerConfig) -> Vec<String> {
    let mut warnings = request_warnings::of_controller(request, &config.robot);
    warnings.extend(contradictory_contacts(request, config));
    warnings.extend(limits::warnings(config));
    warnings.extend(period::warning(config.period_s));
    warnings
}

/// The numbers of a contact law may contradict each other.
fn contradictory_contacts(request: &wire::Controller, config: &ControllerConfig) -> impl Iterator<Item = String> {
    config.contact_contradictions().map(|(place, found)| format!("{}: {found}", task_and_axis(request, place)))
}

/// Names a row of a task by its axis.
fn task_and_axis(request: &wire::Controller, [k, row]: [usize; 2]) -> String {
    let wire::ControllerTask { name, axes, .. } = &request.tasks[k];
    let axis = axes.as_ref().and_then(|axes| axes.get(row)).map_or((row + 1).to_string(), ToString::to_string);
    format!("task `{name}`, axis {axis}")
}

/// A contact law along an axis that the arm lacks would wait for its surface for ever.
fn idle_contacts(request: &wire::Controller, config: &ControllerConfig) -> impl Iterator<Item = String> {
    config.idle_contacts().unwrap_or_default().into_iter().map(|place| {
        format!(
            "{}: no joint moves the tool along it at any posture, so it never presses; choose another axis",
            task_and_axis(request, place)
        )
    })
}

/// A plane that no joint moves its point towards is kept or broken for ever, and no answer says so.
fn idle_planes(config: &ControllerConfig) -> impl Iterator<Item = String> {
    config.idle_planes().unwrap_or_default().into_iter().map(|name| {
        format!("plane `{name}` holds nothing back: no joint moves its point along the normal; name another point of the arm")
    })
}

/// Number of links that a warning names.
const MOST_NAMED: usize = 10;

/// Lengths in millimetres cover everything, so that no pair is watched.
fn huge_shapes(request: &wire::Controller, config: &ControllerConfig) -> Option<String> {
    let robot = &config.robot;
    let model = robot.collision().filter(|_| request.collisions.is_some())?;
    let reach = robot.reach() + robot.travel();
    let huge = model.capsules().iter().find(|capsule| capsule.radius > reach)?;
    Some(format!(
        "a shape of link `{}` has a radius of {} m, more than the reach of the arm; are its lengths in m? Pairs that always touch are \
         not watched",
        robot.links()[huge.link.index()].name,
        huge.radius
    ))
}

/// What no shape covers is not kept clear.
fn uncovered_links(request: &wire::Controller, config: &ControllerConfig) -> Option<String> {
    let uncovered = config.robot.collision().filter(|_| request.collisions.is_some())?.uncovered();
    let more = uncovered.len().saturating_sub(MOST_NAMED);
    let others = if more > 0 { format!(" and {more} more links") } else { String::new() };
    (!uncovered.is_empty()).then(|| {
        format!(
            "no shape covers the links `{}`{others} of `{}`: nothing keeps them clear; cover them by `shape_list` of the robot, on the link \
             that carries them",
            uncovered[..uncovered.len() - more].join("`, `"),
            config.robot.name()
        )
    })
}

/// Singular values of linear rows are proportional to the size of the arm, and the thresholds of damping are not. Where joints slide, they are
/// not proportional either.
#[expect(clippy::float_cmp, reason = "any other length is a choice of the user")]
fn unusual_size(request: &wire::Controller, config: &ControllerConfig) -> Option<String> {
    let (reach, chosen) = (config.robot.reach(), request.characteristic_length_m != 1.0);
    let turns = config.robot.joints().iter().any(|joint| !joint.kind.is_translation());
    let turns = turns && config.robot.travel() == 0.0 && !description::reaches_too_far(&config.robot);
    (turns && config.damping.is_some() && !chosen && !ORDINARY_REACH_M.contains(&reach)).then(|| {
        let (least, most) = CHARACTERISTIC_LENGTH_M;
        let [reach, suits] = [reach, reach.clamp(least, most)].map(|length| significant(length, 3));
        format!(
            "the arm reaches {reach} m, and a characteristic length of 1 m suits arms of about that reach; set \
             `characteristic_length_m` to {suits}, or damping begins at the wrong distance from singularities"
        )
    })
}

fn describe(steep: &SteepGain) -> String {
    let SteepGain { task, gain, joint, ratio, brakes } = steep;
    // As the request wrote it, also if it was computed.
    let gain = (gain * 1e6).round() / 1e6;
    let consequence = if *brakes {
        "far from its target, the law brakes with the joints' acceleration instead of this gain"
    } else {
        "the arm may pass its target; lower the gain, or omit `braking`"
    };
    format!(
        "task `{task}`: the gain {gain} 1/s is above {ratio:.2} 1/s, the ratio of the acceleration and speed limits of joint \
         `{joint}`; {consequence}"
    )
}

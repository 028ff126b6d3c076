//! Warnings about limits that are left out or that do not let the arm rest, and about answers that expire before the next one.

use revprio_core::controller::{ControllerConfig, Limits};
use revprio_core::limits::LimitKind;
use revprio_robot::Joint;

use crate::convert::MAX_VALID_FOR_MS;

/// The shortest period that is not reported, s: an answer is valid for 1 ms at least, and sums of periods are not exact.
const SHORTEST_S: f64 = 0.001 - 1e-9;

/// Returns the warnings.
pub fn warnings(config: &ControllerConfig) -> impl Iterator<Item = String> {
    [missing_accelerations(config), bounds_without_rest(config), short_period(config), short_validity(config)]
        .into_iter()
        .flatten()
}

/// A drive may trip when commands change faster than it can.
fn missing_accelerations(config: &ControllerConfig) -> Option<String> {
    let Limits::Robot(kind @ (LimitKind::PositionVelocity | LimitKind::Velocity)) = config.limits else { return None };
    let is_known = |joint: &Joint| joint.limits.acceleration.is_finite();
    let known = config.robot.joints().iter().any(is_known);
    let name = if kind == LimitKind::Velocity { "velocity" } else { "position_velocity" };
    known.then(|| {
        format!(
            "the limits `{name}` leave out the acceleration limits of `{}`: commands may jump from one speed to another, and a \
             drive may trip; use `position_velocity_acceleration` on an arm",
            config.robot.name()
        )
    })
}

/// An arm must be able to stand still.
fn bounds_without_rest(config: &ControllerConfig) -> Option<String> {
    let Limits::Fixed(bounds) = &config.limits else { return None };
    let sides = bounds.lower().iter().zip(bounds.upper().iter());
    let mut found =
        config.robot.joints().iter().zip(sides).filter(|(_, (lower, upper))| **lower > 0.0 || **upper < 0.0);
    found.next().map(|(joint, (lower, upper))| {
        format!(
            "the bounds of joint `{}` are {lower} and {upper}, so that it never stands still and leaves its range; give bounds with 0 \
             between them",
            joint.name
        )
    })
}

/// A command in full braking is held for longer than its period.
fn short_period(config: &ControllerConfig) -> Option<String> {
    let Limits::Robot(kind) = &config.limits else { return None };
    (kind.includes_position() && config.period_s < SHORTEST_S).then(|| {
        format!(
            "`period_s` is {} s, and `valid_for_ms` counts whole milliseconds: if states come late while a joint brakes at its limit, it \
             leaves its range; use 0.001 s or more, or make sure that no state is late",
            config.period_s
        )
    })
}

/// A watchdog brakes before the next answer comes.
fn short_validity(config: &ControllerConfig) -> Option<String> {
    let (valid, period) = (config.valid_for_ms as f64, config.period_s * 1e3);
    (valid <= period).then(|| {
        format!(
            "answers are valid for {valid} ms, no longer than the period of {period} ms: a watchdog brakes before the next one comes, and \
             the arm moves slowly or not at all, and may leave its ranges if states come late; set `valid_for_ms` to {} or more",
            (2.0 * period).ceil().min(MAX_VALID_FOR_MS as f64)
        )
    })
}

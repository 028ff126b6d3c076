//! How a joint brakes, and how long it moves on before.

use revprio_robot::JointLimits;

/// Minimum of S, s. It covers the longest wait for an answer that the service allows.
const MIN_SPARE_TIME: f64 = 0.01;

/// Time in which a joint without acceleration limit brakes from its speed limit, s. The built-in arms need 0.1 s to 0.3 s.
const DEFAULT_BRAKING_TIME: f64 = 0.25;

/// Distance beyond a position limit that counts as noise of the measured position, rad or m: twice the largest error.
pub(super) const NOISE_TOLERANCE: f64 = 5e-4;

/// Returns S, the time for which a command near a limit can be held, s; `period`: T, s.
pub fn spare_time(period: f64) -> f64 {
    period.max(MIN_SPARE_TIME)
}

/// Returns τ = T + S, the time for which the box lets a joint move on before it brakes, s; `period`: T, s.
pub fn reaction_time(period: f64) -> f64 {
    period + spare_time(period)
}

/// Returns a, the deceleration with which a watchdog brakes a joint, rad/s² or m/s².
///
/// This is the acceleration limit A. A joint without one brakes from its speed limit in 0.25 s. A joint without both
/// limits stops at once: the result is infinite.
pub fn braking_deceleration(limits: &JointLimits) -> f64 {
    if limits.acceleration.is_finite() { limits.acceleration } else { limits.velocity / DEFAULT_BRAKING_TIME }
}

/// Returns the deceleration with which a watchdog brakes a joint from a command u, rad/s² or m/s²: |u|/t if all joints stop together
/// after the time t (`stop_time`, s), else a.
pub fn ramp_deceleration(limits: &JointLimits, command: f64, stop_time: Option<f64>) -> f64 {
    match stop_time {
        Some(time) if command != 0.0 => command.abs() / time,
        _ => braking_deceleration(limits),
    }
}

/// Returns b, the deceleration with which a joint must be able to stop before the ends of its range: a, or the D of its velocity
/// envelope if that is smaller.
pub(super) fn stopping_deceleration(limits: &JointLimits) -> f64 {
    braking_deceleration(limits).min(limits.envelope.deceleration)
}

/// Returns τ + o/D, the time for which a joint must be able to move on before it stops; `period`: T, s.
pub(super) fn stopping_reaction_time(limits: &JointLimits, period: f64) -> f64 {
    reaction_time(period) + limits.envelope.reaction_time()
}

/// Returns the acceleration that a command keeps, rad/s² or m/s²: A, or [`braking_deceleration`] for a joint that has a jerk
/// limit and no A. If its speed could jump, its jerk would have no bound.
pub fn kept_acceleration(limits: &JointLimits) -> f64 {
    if limits.jerk.is_finite() { braking_deceleration(limits) } else { limits.acceleration }
}

/// Returns whether the speed of a joint may jump from one command to the next, even with all limits of the robot.
pub fn may_jump(limits: &JointLimits) -> bool {
    kept_acceleration(limits).is_infinite()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: JointLimits =
        JointLimits { lower: -1.0, upper: 2.0, velocity: 2.0, acceleration: 8.0, ..JointLimits::NONE };

    #[test]
    fn the_deceleration_is_the_acceleration_limit_or_stops_the_top_speed_in_a_quarter_of_a_second() {
        assert_eq!(braking_deceleration(&LIMITS), 8.0);
        assert_eq!(braking_deceleration(&JointLimits { acceleration: f64::INFINITY, ..LIMITS }), 8.0);
        let slow = JointLimits { acceleration: f64::INFINITY, velocity: 0.5, ..LIMITS };
        assert_eq!(braking_deceleration(&slow), 2.0);
        assert_eq!(braking_deceleration(&JointLimits::NONE), f64::INFINITY);
    }
}

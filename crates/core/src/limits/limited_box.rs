//! The velocity box that the limits of a robot leave after the last command.

use revprio_robot::{JointLimits, RobotModel};

use super::braking::{NOISE_TOLERANCE, braking_deceleration, reaction_time};
use super::jerk::JerkLimit;
use super::limit_kind::LimitKind;
use revprio_problem::VelocityBox;

/// A box of allowed velocities, with the joints whose acceleration or jerk limit it does not keep.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitedBox {
    /// The velocities allowed in this period.
    pub velocity_box: VelocityBox,
    /// Joints (index from 0) whose acceleration or jerk limit contradicts position or velocity limits and is not kept.
    pub conflicts: Vec<usize>,
}

/// The motion of the joints before a command.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion<'a> {
    /// q, measured position, n.
    pub position: &'a [f64],
    /// p − q, how far the joints move on if all later commands are zero, n; empty: they stop at once. See
    /// [`DriveState`](super::DriveState).
    pub distance_to_rest: &'a [f64],
    /// q̇⁻, the last command, n.
    pub last_command: &'a [f64],
    /// a⁻, the acceleration of the last command, n; empty: jerk limits do not apply.
    pub last_acceleration: &'a [f64],
}

impl JointMotion<'_> {
    /// Returns the same motion with joints that stop at once.
    pub(super) fn stopping_at_once(self) -> Self {
        Self { distance_to_rest: &[], ..self }
    }

    /// Returns the distances of a joint to its lower and to its upper limit, as it is now and as it comes to rest,
    /// whichever is smaller.
    pub(super) fn distances(&self, joint: usize, limits: &JointLimits) -> (f64, f64) {
        let (q, to_rest) = (self.position[joint], self.distance_to_rest.get(joint).copied().unwrap_or(0.0));
        (q - limits.lower + to_rest.min(0.0), limits.upper - q - to_rest.max(0.0))
    }
}

/// Returns the box of a robot's own limits at a state; `period`: T > 0, s.
pub fn robot_box(robot: &RobotModel, kind: LimitKind, motion: JointMotion, period: f64) -> LimitedBox {
    let mut limited = LimitedBox::unbounded(robot.joint_count());
    limited.update(robot, kind, motion, period);
    limited
}

impl LimitedBox {
    /// Returns the box without bounds, for n joints.
    pub fn unbounded(n: usize) -> Self {
        Self { velocity_box: VelocityBox::unbounded(n), conflicts: Vec::new() }
    }

    /// Narrows the box, so that joints with a jerk limit reach the velocities `requested` (n) without passing them: a joint
    /// that cannot have its velocity yet gets the nearest one from which it levels off there. Another joint may move on either
    /// side of its velocity alike, because answers near singularities tend to the middle of the box.
    ///
    /// A joint that accelerates would otherwise pass the velocity that its task wants, by a²/2J, then come back as fast, and
    /// so on. `last_requested`: the requests of the last period, n. The motion has accelerations.
    pub fn approach(
        &mut self,
        robot: &RobotModel,
        motion: JointMotion,
        requested: &[f64],
        last_requested: &[f64],
        period: f64,
    ) {
        for (i, joint) in robot.joints().iter().enumerate() {
            if let Some(jerk) = JerkLimit::of(&joint.limits, period) {
                let bounds = (self.velocity_box.lower()[i], self.velocity_box.upper()[i]);
                let last = (motion.last_command[i], motion.last_acceleration[i]);
                let (lower, upper) = jerk.around(bounds, last, requested[i], last_requested[i]);
                self.velocity_box.set_joint(i, lower, upper);
            }
        }
    }

    /// Updates the box to the result of [`robot_box`], for a robot with the same number of joints.
    pub fn update(&mut self, robot: &RobotModel, kind: LimitKind, motion: JointMotion, period: f64) {
        self.conflicts.clear();
        for (i, joint) in robot.joints().iter().enumerate() {
            let interval = Interval::from_limits(&joint.limits, kind, motion, i, period);
            self.velocity_box.set_joint(i, interval.lower, interval.upper);
            if interval.conflict {
                self.conflicts.push(i);
            }
        }
    }
}

/// Contradiction of limits, rad/s, above which a joint is reported as a conflict; less counts as rounding.
const CONFLICT_TOLERANCE: f64 = 1e-9;

/// The allowed velocities of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) conflict: bool,
}

impl Interval {
    pub(super) fn from_limits(
        limits: &JointLimits,
        kind: LimitKind,
        motion: JointMotion,
        joint: usize,
        period: f64,
    ) -> Self {
        let velocity = limits.velocity;
        let (lower, upper) = match kind {
            LimitKind::None => (f64::NEG_INFINITY, f64::INFINITY),
            LimitKind::Velocity => (-velocity, velocity),
            LimitKind::PositionVelocity => {
                let stop = |distance: f64| max_speed(limits, distance.abs(), period).copysign(distance);
                let (to_lower, to_upper) = motion.distances(joint, limits);
                ordered(-stop(to_lower), stop(to_upper), to_upper)
            }
            LimitKind::PositionVelocityAcceleration => return Self::with_acceleration(limits, motion, joint, period),
        };
        Self { lower, upper, conflict: false }
    }

    /// Returns the interval of all limits.
    fn with_acceleration(limits: &JointLimits, motion: JointMotion, joint: usize, period: f64) -> Self {
        let last = motion.last_command[joint];
        let max_change = limits.acceleration * period;
        let (slowest, fastest) = (last - max_change, last + max_change);
        let stop = |distance: f64, last: f64| max_speed_towards(limits, distance, last, period);
        let (to_lower, to_upper) = motion.distances(joint, limits);
        let bounds = |(to_lower, to_upper)| ordered(-stop(to_lower, -last), stop(to_upper, last), to_upper);
        let at_once = bounds(motion.stopping_at_once().distances(joint, limits));
        let forgiving = (-stop(to_lower + NOISE_TOLERANCE, -last), stop(to_upper + NOISE_TOLERANCE, last));
        let (mut lower, mut upper) = bounds((to_lower, to_upper));
        // A drive that is faster than stated can ask for more than full braking, and then needs less. So can noise.
        lower = lower.min(if fastest >= forgiving.0 { fastest } else { fastest.max(at_once.0) });
        upper = upper.max(if slowest <= forgiving.1 { slowest } else { slowest.min(at_once.1) });
        let interval = Self {
            lower: slowest.clamp(lower, upper),
            upper: fastest.clamp(lower, upper),
            conflict: slowest > upper + CONFLICT_TOLERANCE || fastest < lower - CONFLICT_TOLERANCE,
        };
        let jerk = motion.last_acceleration.get(joint).zip(JerkLimit::of(limits, period));
        jerk.map_or(interval, |(&acceleration, jerk)| {
            interval.keeping_jerk(&jerk, (last, acceleration), (to_lower, to_upper), forgiving)
        })
    }

    /// Restricts the interval of the other limits by a jerk limit, as far as they allow it; `acceleration`: a⁻.
    ///
    /// `forgiving`: the position limits, give or take noise. They give way to full braking with the jerk.
    fn keeping_jerk(
        self,
        jerk: &JerkLimit,
        (last, acceleration): (f64, f64),
        (to_lower, to_upper): (f64, f64),
        forgiving: (f64, f64),
    ) -> Self {
        let (least, greatest) = jerk.reach(last, acceleration);
        // A return from beyond a limit begins as fast as the jerk allows it.
        let highest = if least <= forgiving.1.max(0.0) { self.upper.max(least) } else { self.upper };
        let lowest = if greatest >= forgiving.0.min(0.0) { self.lower.min(greatest) } else { self.lower };
        let upper = jerk.largest(last, acceleration, to_upper);
        let lower = (-jerk.largest(-last, -acceleration, to_lower)).min(upper);
        Self {
            lower: lower.clamp(lowest, highest),
            upper: upper.clamp(lowest, highest),
            conflict: self.conflict || least > highest + CONFLICT_TOLERANCE || greatest < lowest - CONFLICT_TOLERANCE,
        }
    }
}

/// Returns the bounds of a joint so that they do not cross: a return from beyond one limit must stop before the other.
fn ordered(lower: f64, upper: f64, to_upper: f64) -> (f64, f64) {
    if to_upper < 0.0 { (lower, upper.max(lower)) } else { (lower.min(upper), upper) }
}

/// Returns the maximum speed from which a joint can stop within `distance` ≥ 0: the braking term of the module `limits`, at
/// most V.
fn max_speed(limits: &JointLimits, distance: f64, period: f64) -> f64 {
    let (reaction, deceleration) = (reaction_time(period), braking_deceleration(limits));
    // a(−τ + √(τ² + 2d/a)), rewritten: no cancellation for small d. For infinite d and a it is NaN, which `min` ignores.
    let speed = 2.0 * distance / (reaction + (reaction * reaction + 2.0 * distance / deceleration).sqrt());
    speed.min(limits.velocity)
}

/// Returns the maximum speed towards a limit at `distance`.
///
/// If the joint is beyond the limit (negative `distance`), the result is negative or zero, a motion back. Its speed is
/// the mirrored braking term, as far as the acceleration limit allows it after the last command.
fn max_speed_towards(limits: &JointLimits, distance: f64, last: f64, period: f64) -> f64 {
    if distance >= 0.0 {
        max_speed(limits, distance, period)
    } else {
        (-max_speed(limits, -distance, period)).max(last - limits.acceleration * period).min(0.0)
    }
}

#[cfg(test)]
mod tests;

//! The velocity box that the limits of a robot leave after the last command.

use revprio_robot::{JointLimits, RobotModel};

use super::bound_cause::BoundCause;
use super::braking::{
    NOISE_TOLERANCE, braking_deceleration, kept_acceleration, stopping_deceleration, stopping_reaction_time,
};
use super::jerk::JerkLimit;
use super::limit_kind::LimitKind;
use crate::arm_state::JointMotion;
use revprio_problem::{Side, VelocityBox};

/// A box of allowed velocities, with the limit that sets each bound, and the joints whose acceleration or jerk limit it does not
/// keep.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitedBox {
    /// The velocities allowed in this period.
    pub velocity_box: VelocityBox,
    /// Joints (index from 0) whose acceleration or jerk limit contradicts position or velocity limits and is not kept.
    pub conflicts: Vec<usize>,
    /// What sets the lower and the upper bound, n.
    causes: Vec<[BoundCause; 2]>,
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
        let causes = vec![[BoundCause::Unlimited; 2]; n];
        Self { velocity_box: VelocityBox::unbounded(n), conflicts: Vec::new(), causes }
    }

    /// Returns a given box, which does not depend on a state.
    pub fn given(velocity_box: VelocityBox) -> Self {
        let causes = vec![[BoundCause::Given; 2]; velocity_box.joint_count()];
        Self { velocity_box, conflicts: Vec::new(), causes }
    }

    /// Updates the box to that of [`Self::given`], for the same number of joints.
    pub fn set_given(&mut self, velocity_box: &VelocityBox) {
        self.velocity_box.copy_from(velocity_box);
        self.conflicts.clear();
        self.causes.fill([BoundCause::Given; 2]);
    }

    /// Copies a box for the same number of joints.
    pub fn copy_from(&mut self, other: &Self) {
        self.velocity_box.copy_from(&other.velocity_box);
        self.conflicts.clone_from(&other.conflicts);
        self.causes.copy_from_slice(&other.causes);
    }

    /// Returns the limit that sets a bound of a joint (index from 0).
    pub fn cause(&self, joint: usize, side: Side) -> BoundCause {
        self.causes[joint][usize::from(side == Side::Upper)]
    }

    fn set_joint(&mut self, joint: usize, interval: &Interval) {
        self.velocity_box.set_joint(joint, interval.lower, interval.upper);
        self.causes[joint] = interval.causes;
    }

    /// Restricts the box to velocities that the joints which `jump` may change to from the last command (n) within a period (T, s),
    /// in a transition. Where there is none, it becomes the reachable velocity nearest to the box.
    pub fn bound_changes(
        &mut self,
        robot: &RobotModel,
        last_command: &[f64],
        period: f64,
        jump: impl Fn(&JointLimits) -> bool,
    ) {
        let joints = robot.joints().iter().zip(last_command).enumerate();
        for (i, (joint, last)) in joints.filter(|(_, (joint, _))| jump(&joint.limits)) {
            let max_change = braking_deceleration(&joint.limits) * period;
            let reachable = |bound: f64| bound.clamp(last - max_change, last + max_change);
            self.change_joint(i, BoundCause::Transition, |lower, upper| (reachable(lower), reachable(upper)));
        }
    }

    /// Shrinks the box to a share of its size about a velocity inside it, n.
    pub fn shrink(&mut self, centre: &[f64], share: f64) {
        for (joint, &centre) in centre.iter().enumerate() {
            self.change_joint(joint, BoundCause::Distance, |lower, upper| {
                (centre + share * (lower - centre), centre + share * (upper - centre))
            });
        }
    }

    /// Changes the bounds of a joint. Those that differ afterwards have another cause.
    fn change_joint(&mut self, joint: usize, cause: BoundCause, change: impl FnOnce(f64, f64) -> (f64, f64)) {
        let before = (self.velocity_box.lower()[joint], self.velocity_box.upper()[joint]);
        let after = change(before.0, before.1);
        self.velocity_box.set_joint(joint, after.0, after.1);
        for (known, (before, after)) in self.causes[joint].iter_mut().zip([(before.0, after.0), (before.1, after.1)]) {
            if !is_same(before, after) {
                *known = cause;
            }
        }
    }

    /// Narrows the box, so that joints with a jerk limit reach the velocities `requested` (n) without passing them: a joint
    /// that cannot have its velocity yet gets the nearest one from which it levels off there. Another joint may move on either
    /// side of its velocity alike, because answers near singularities tend to the middle of the box.
    ///
    /// With [`Pace::AtMost`], the joint may also approach its velocity more slowly, or go away from it.
    ///
    /// A joint that accelerates would otherwise pass the velocity that its task wants, by a²/2J, then come back as fast, and
    /// so on. `last_requested`: the requests of the last period, n. The motion has accelerations.
    pub fn approach(
        &mut self,
        (robot, period): (&RobotModel, f64),
        motion: JointMotion,
        (requested, last_requested): (&[f64], &[f64]),
        pace: Pace,
    ) {
        for (i, joint) in robot.joints().iter().enumerate() {
            if let Some(jerk) = JerkLimit::of(&joint.limits, period) {
                let last = (motion.last_command[i], motion.last_acceleration[i]);
                self.change_joint(i, BoundCause::LevellingOff, |lower, upper| match pace {
                    Pace::Fast => jerk.around((lower, upper), last, requested[i], last_requested[i]),
                    Pace::AtMost => jerk.towards((lower, upper), last, requested[i], last_requested[i]),
                });
            }
        }
    }

    /// Updates the box to the result of [`robot_box`], for a robot with the same number of joints.
    pub fn update(&mut self, robot: &RobotModel, kind: LimitKind, motion: JointMotion, period: f64) {
        self.conflicts.clear();
        for (i, joint) in robot.joints().iter().enumerate() {
            let interval = Interval::from_limits(&joint.limits, kind, motion, i, period);
            self.set_joint(i, &interval);
            if interval.conflict {
                self.conflicts.push(i);
            }
        }
    }
}

/// Contradiction of limits, rad/s, above which a joint is reported as a conflict; less counts as rounding.
const CONFLICT_TOLERANCE: f64 = 1e-9;

/// How fast joints with a jerk limit approach the velocities that their tasks want.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pace {
    /// As fast as they can.
    Fast,
    /// As fast as they can, more slowly, or not at all.
    AtMost,
}

/// The allowed velocities of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Interval {
    pub(super) lower: f64,
    pub(super) upper: f64,
    pub(super) conflict: bool,
    /// What sets the lower and the upper bound.
    pub(super) causes: [BoundCause; 2],
}

/// Returns whether two bounds are the same, to the last bit. So the terms of a bound tell which of them sets it.
fn is_same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits()
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
            LimitKind::None => {
                let causes = [BoundCause::Unlimited; 2];
                return Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY, conflict: false, causes };
            }
            LimitKind::Velocity => (-velocity, velocity),
            LimitKind::PositionVelocity => {
                let stop = |distance: f64| max_speed(limits, distance.abs(), period).copysign(distance);
                let (to_lower, to_upper) = motion.distances(joint, limits);
                ordered(-stop(to_lower), stop(to_upper), to_upper)
            }
            LimitKind::PositionVelocityAcceleration => return Self::with_acceleration(limits, motion, joint, period),
        };
        let cause = |bound: f64| {
            if is_same(bound.abs(), velocity) { BoundCause::Velocity } else { BoundCause::of_stop(limits) }
        };
        Self { lower, upper, conflict: false, causes: [cause(lower), cause(upper)] }
    }

    /// Returns the interval of all limits.
    fn with_acceleration(limits: &JointLimits, motion: JointMotion, joint: usize, period: f64) -> Self {
        let last = motion.last_command[joint];
        let max_change = kept_acceleration(limits) * period;
        let (slowest, fastest) = (last - max_change, last + max_change);
        let stop = |distance: f64, last: f64| max_speed_towards(limits, distance, last, period);
        let (to_lower, to_upper) = motion.distances(joint, limits);
        let bounds = |(to_lower, to_upper)| ordered(-stop(to_lower, -last), stop(to_upper, last), to_upper);
        let at_once = bounds(motion.stopping_at_once().distances(joint, limits));
        let forgiving = (-stop(to_lower + NOISE_TOLERANCE, -last), stop(to_upper + NOISE_TOLERANCE, last));
        let (mut lower, mut upper) = bounds((to_lower, to_upper));
        // After lost states, with noise, or with a drive that is faster than stated, the box can ask for more than full braking.
        // It need not if full braking from now on stops the joint in time.
        let stops = |speed: f64, forgiving: f64, distance: f64| {
            speed <= forgiving || speed <= max_braking_speed(limits, distance, period)
        };
        let (stops_lower, stops_upper) =
            (stops(-fastest, -forgiving.0, to_lower), stops(slowest, forgiving.1, to_upper));
        lower = lower.min(if stops_lower { fastest } else { fastest.max(at_once.0) });
        upper = upper.max(if stops_upper { slowest } else { slowest.min(at_once.1) });
        let cause = |bound: f64| match bound {
            _ if is_same(bound, slowest) || is_same(bound, fastest) => BoundCause::Acceleration,
            _ if is_same(bound.abs(), limits.velocity) => BoundCause::Velocity,
            _ => BoundCause::of_stop(limits),
        };
        let (lowest, highest) = (slowest.clamp(lower, upper), fastest.clamp(lower, upper));
        let interval = Self {
            lower: lowest,
            upper: highest,
            causes: [cause(lowest), cause(highest)],
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
        let (upper, upper_cause) = jerk.largest(last, acceleration, to_upper);
        let (lower, lower_cause) = jerk.largest(-last, -acceleration, to_lower);
        let lower = (-lower).min(upper);
        // A return from beyond a limit begins as fast as the jerk allows it, and levels off in time for the other limits.
        let slowest_return = if to_upper < 0.0 { lower } else { least };
        let highest = if slowest_return <= forgiving.1.max(0.0) { self.upper.max(slowest_return) } else { self.upper };
        let fastest_return = if to_lower < 0.0 { upper } else { greatest };
        let lowest = if fastest_return >= forgiving.0.min(0.0) { self.lower.min(fastest_return) } else { self.lower };
        // What remains of a bound after the other limits, or else what the other limits made of it.
        let kept = |bound: f64, cause, other| {
            let kept = bound.clamp(lowest, highest);
            (kept, if is_same(kept, bound) { cause } else { other })
        };
        let (lower, lower_cause) = kept(lower, lower_cause, self.causes[0]);
        let (upper, upper_cause) = kept(upper, upper_cause, self.causes[1]);
        Self {
            lower,
            upper,
            causes: [lower_cause, upper_cause],
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
    max_speed_after(limits, distance, stopping_reaction_time(limits, period))
}

/// Returns the maximum speed of a command from which full braking, a T less in each period, stops a joint within `distance`, δ and A T²/8
/// more; zero beyond that.
fn max_braking_speed(limits: &JointLimits, distance: f64, period: f64) -> f64 {
    // The commands v, v − a T, … move it by v²/2a + v T/2 + a T²/8 at most; the last term is left out.
    max_speed_after(limits, (distance + NOISE_TOLERANCE).max(0.0), 0.5 * period + limits.envelope.reaction_time())
}

/// Returns the maximum speed, at most V, from which a joint can stop within `distance` ≥ 0 if it begins after the time `reaction`.
fn max_speed_after(limits: &JointLimits, distance: f64, reaction: f64) -> f64 {
    let deceleration = stopping_deceleration(limits);
    // b(−τ + √(τ² + 2d/b)), rewritten: no cancellation for small d. For infinite d and b it is NaN, which `min` ignores.
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
        (-max_speed(limits, -distance, period)).max(last - kept_acceleration(limits) * period).min(0.0)
    }
}

#[cfg(test)]
mod tests;

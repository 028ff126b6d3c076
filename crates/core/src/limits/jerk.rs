//! The jerk limit of a joint: how its speed may change, so that the joint can still level off and stop.
//!
//! # The box
//!
//! A joint has the jerk limit J, the acceleration limit A (or [`braking_deceleration`], which it then keeps like an A) and the speed limit V. q̇⁻ is the last
//! command, a⁻ its acceleration, T the period, τ the reaction time and d the distance to the upper limit. A command v has the
//! acceleration a = (v − q̇⁻)/T. It is allowed if
//!
//! |a − a⁻| ≤ J T, |a| ≤ A, v + T Σᵢ max(0, a − i J T) ≤ V for i = 1, 2, …, and H(v, a) ≤ d.
//!
//! - The sum is what the speed still gains while the acceleration falls to zero.
//! - With s = v + a|a|/2J, the speed at which the joint would level off, and p = v + a²/2J,
//!
//!   H = M + v a/J + a³/3J² + D(p) for s > 0, with D(p) = p √(p/J) for p ≤ A²/J, p²/2A + p A/2J beyond, and
//!   M = v τ for a ≤ 0, p (τ + σ) for a > 0, σ = 50 ms;
//!   H = v τ + v t + a t²/2 + J t³/6 for s ≤ 0 < v, where v + a t + J t²/2 = 0 for the first time; otherwise H = 0.
//!
//!   Without the terms with τ and σ, H is the distance of the stop with the jerk J and the acceleration A at most (s > 0), or the
//!   distance until the joint turns back, although its acceleration already rises at J (s ≤ 0).
//!
//! All terms grow with v, so the allowed commands are an interval. The lower limits are mirrored.
//!
//! Outside the range, d < 0, a command is also allowed if v ≤ 0 and s ≤ 0: the joint moves back, or stands. The speed at which the joint
//! must return gives way to the sum and to the other end.
//!
//! A joint with a velocity envelope has b and τ' = τ + o/D of the module `limits` in the place of A and τ of H, the end of the margin as
//! its limit, and max(a, −D) in the place of a: it need not have the distance of a stop harder than D.
//!
//! # Why the box is never empty
//!
//! Let the last command be allowed, and τ ≥ 2 T. Let v̂ be the command within |a − a⁻| ≤ J T and |a| ≤ A with the smallest
//! |s|. It satisfies both sides. Take the upper one; d = d⁻ − q̇⁻ T.
//!
//! - s > 0: v̂ brakes fully, a = max(a⁻ − J T, −A). Continuous braking from (q̇⁻, a⁻) to a moves by at least
//!   q̇⁻ T − α T²/2 with α = max(0, −a), and ends at a speed of at least v̂, because the period holds the final acceleration
//!   and it falls. H without τ loses what the joint moves, and grows with the speed. So H(v̂, a) ≤ H(q̇⁻, a⁻) − q̇⁻ T +
//!   α T²/2 − α T τ for a⁻ ≤ 0, and τ ≥ T/2 suffices. For a⁻ > 0 the term M does not grow either. The sum loses its first
//!   term and v̂ gains it.
//! - s = 0, v̂ = α²/2J with a = −α: q̇⁻ = v̂ + α T, and H(v̂, a) + q̇⁻ T ≤ H(q̇⁻, a⁻) amounts to (τ − T) α T ≥ 0 at the
//!   smallest possible a⁻. For v̂ ≤ 0 there is nothing to show: the joint does not move towards the limit.
//! - s < 0: v̂ = q̇⁻ + T (a⁻ + J T) turns as late as possible. For v̂ > 0, H(v̂, a) + q̇⁻ T ≤ H(q̇⁻, a⁻) follows from
//!   α (τ − T) ≥ J T²/3, or, for α < J T/3, from v̂ ≤ α²/2J.
//!
//! The mirrored cases are those of the lower side, so v̂ lies in the box.
//!
//! With a velocity envelope, let ṽ with the acceleration ã be v̂ of a joint with b in the place of A, after q̇⁻ and max(a⁻, −D). As shown,
//! H(ṽ, ã) ≤ d. The joint itself reaches harder braking, so v̂ ≤ ṽ and max(â, −D) ≤ ã. H grows with the speed and with the acceleration,
//! so v̂ is allowed. H is at least v τ' + v²/2b, so the command keeps the envelope.
//!
//! # Why noise of the measured position is no conflict
//!
//! Let each measured distance be off by at most ε, and 2 ε ≤ δ = 0.5 mm or mrad. Then H(v, a) ≤ max(0, d + ε) after every command,
//! for the true d: a command in the box of the measured distance has H ≤ d + ε, and v̂ keeps the inequality as above.
//! The position limits give way to v̂ if it obeys the braking term for the measured distance + δ. It does, because
//! v̂ τ + v̂²/2A ≤ H ≤ d + ε. So no limits contradict each other, and H ≥ 0 bounds the excess by ε. The same holds for the
//! acceleration limit with v τ + v²/2A in the place of H.
//!
//! If more is demanded than noise explains, position and speed limits win, and the joint is reported as a conflict.
//!
//! # What σ is for
//!
//! If the drive is faster than stated, p recedes while the joint brakes, the limit seems further away, and the joint may
//! accelerate again. Its acceleration then rises and falls with the jerk and swings for ever. The joint must see σ p more
//! room before it accelerates again than when it brakes, which is more than p recedes.

use revprio_robot::JointLimits;

use super::bound_cause::BoundCause;
use super::braking::{braking_deceleration, stopping_deceleration, stopping_reaction_time};

/// Halvings that find the end of the box, from a width of at most 2 J T² to rounding.
const HALVINGS: usize = 45;

/// Time, s, by which the drive may be faster than stated without a swing: the default L + 2 T for T = 10 ms. A joint that
/// accelerates towards a limit must be able to move on for this time too.
const DRIVE_ERROR: f64 = 0.05;

/// Distance from a velocity, rad/s, that counts as rounding.
const ROUNDING: f64 = 1e-12;

/// The jerk limit of a joint, with what belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JerkLimit {
    jerk: f64,
    acceleration: f64,
    /// b, the deceleration with which the joint must be able to stop.
    deceleration: f64,
    /// D of the velocity envelope; infinite without one.
    envelope: f64,
    velocity: f64,
    period: f64,
    reaction: f64,
    stop_cause: BoundCause,
}

impl JerkLimit {
    /// Returns the jerk limit of a joint; `None` if it has none, or if its acceleration limit already implies it: a change
    /// from −A to A within a period (T, s) is allowed.
    pub fn of(limits: &JointLimits, period: f64) -> Option<Self> {
        let acceleration = braking_deceleration(limits);
        let binds = limits.jerk * period < 2.0 * acceleration;
        binds.then(|| Self {
            jerk: limits.jerk,
            acceleration,
            deceleration: stopping_deceleration(limits),
            envelope: limits.envelope.deceleration,
            velocity: limits.velocity,
            period,
            reaction: stopping_reaction_time(limits, period),
            stop_cause: BoundCause::of_stop(limits),
        })
    }

    /// Returns the smallest and the largest command that the jerk allows after the last command and its acceleration.
    pub(super) fn reach(&self, last: f64, acceleration: f64) -> (f64, f64) {
        let (change, largest) = (self.jerk * self.period, self.acceleration);
        let [least, greatest] = [acceleration - change, acceleration + change].map(|a| a.clamp(-largest, largest));
        (last + self.period * least, last + self.period * greatest)
    }

    /// Returns v̂ of the module: the command with the smallest |s| after the last command and its acceleration.
    ///
    /// s = v + a|a|/2J grows with a, and for v = q̇⁻ + a T it is zero at |a| = J (√(T² + 2|q̇⁻|/J) − T), against q̇⁻.
    pub(super) fn braking(&self, last: f64, acceleration: f64) -> f64 {
        let (period, jerk) = (self.period, self.jerk);
        let needed = 2.0 * last.abs() / (period + (period * period + 2.0 * last.abs() / jerk).sqrt());
        let (least, greatest) = self.reach(last, acceleration);
        (last - period * needed.copysign(last)).clamp(least, greatest)
    }

    /// Returns the acceleration to remember after a command, at most J T away from that before it. A command that does not
    /// keep the jerk thus counts as a jump of the speed, and the joint need not level off from it.
    pub fn next_acceleration(&self, acceleration: f64, last: f64, command: f64) -> f64 {
        let change = self.jerk * self.period;
        let next = ((command - last) / self.period).clamp(acceleration - change, acceleration + change);
        next.clamp(-self.acceleration, self.acceleration)
    }

    /// Returns the largest command that jerk, speed limit and an upper limit at `distance` allow, at least that of full
    /// braking, and which of them sets it.
    pub(super) fn largest(&self, last: f64, acceleration: f64, distance: f64) -> (f64, BoundCause) {
        let (least, reached) = self.reach(last, acceleration);
        let greatest = reached.min(self.levelling_off(last, self.velocity));
        let allowed = |v: f64| {
            let a = (v - last) / self.period;
            let may_stay_beyond = self.level(v, a) <= 0.0;
            self.stop_distance(v, a) <= if may_stay_beyond { distance.max(0.0) } else { distance }
        };
        if greatest <= least || allowed(greatest) {
            let cause = if greatest < self.velocity { BoundCause::Jerk } else { BoundCause::Velocity };
            return (greatest.max(least), cause);
        }
        let (mut inside, mut outside) = (least, greatest);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            *(if allowed(middle) { &mut inside } else { &mut outside }) = middle;
        }
        (inside, self.stop_cause)
    }

    /// Returns the largest command from which the joint levels off at the speed `target` or below it: v + T Σᵢ max(0, a −
    /// i J T) = `target`.
    fn levelling_off(&self, last: f64, target: f64) -> f64 {
        let unit = self.jerk * self.period * self.period;
        let gap = (target - last) / unit;
        if !(1.0..f64::INFINITY).contains(&gap) {
            return target;
        }
        let further = (0.5 * ((1.0 + 8.0 * gap).sqrt() - 1.0)).floor();
        last + (gap + 0.5 * further * (further + 1.0)) / (further + 1.0) * unit
    }

    /// Returns the part of the interval from `lower` to `upper` around the velocity `requested` if the joint can have it, otherwise
    /// the velocity of [`Self::approach`] alone.
    pub(super) fn around(
        &self,
        (lower, upper): (f64, f64),
        last: (f64, f64),
        requested: f64,
        last_requested: f64,
    ) -> (f64, f64) {
        let (least, greatest) = self.approach((lower, upper), last, requested, last_requested);
        let nearest = requested.clamp(least, greatest);
        if (nearest - requested).abs() > ROUNDING {
            return (nearest, nearest);
        }
        let width = (nearest - lower).min(upper - nearest);
        (nearest - width, nearest + width)
    }

    /// Returns the part of the interval from `lower` to `upper` around the velocity that the joint has if its acceleration falls to zero,
    /// up to that of [`Self::approach`] if the joint cannot have the velocity `requested`.
    pub(super) fn towards(
        &self,
        (lower, upper): (f64, f64),
        (last, acceleration): (f64, f64),
        requested: f64,
        last_requested: f64,
    ) -> (f64, f64) {
        let (least, greatest) = self.approach((lower, upper), (last, acceleration), requested, last_requested);
        let nearest = requested.clamp(least, greatest);
        let change = self.jerk * self.period;
        let going_on = (last + self.period * (acceleration - acceleration.clamp(-change, change))).clamp(lower, upper);
        let reach = (going_on - lower).min(upper - going_on);
        let width = if (nearest - requested).abs() > ROUNDING { (nearest - going_on).abs() } else { reach };
        ((going_on - width).max(lower), (going_on + width).min(upper))
    }

    /// Narrows the interval from `lower` to `upper`, so that the joint reaches the velocity `requested` without passing it.
    ///
    /// The request is taken to go on as since the last period. But its acceleration counts only between 0 and that of the
    /// joint, give or take J T: noise of the request is not followed, and a joint that crosses the request levels off.
    /// `last_requested`: the request of the last period.
    fn approach(
        &self,
        (lower, upper): (f64, f64),
        (last, acceleration): (f64, f64),
        requested: f64,
        last_requested: f64,
    ) -> (f64, f64) {
        let (least, greatest) = (acceleration.min(0.0), acceleration.max(0.0));
        let change_in_reach = self.jerk * self.period;
        let [least, greatest] = [least - change_in_reach, greatest + change_in_reach].map(|a| a * self.period);
        let change = (requested - last_requested).clamp(least, greatest);
        let before = requested - change;
        if before >= last {
            (lower, upper.min(change + self.levelling_off(last, before)).max(lower))
        } else {
            (lower.max(change - self.levelling_off(-last, -before)).min(upper), upper)
        }
    }

    /// Returns s of the module, the speed at which the joint would level off.
    fn level(&self, v: f64, a: f64) -> f64 {
        v + a * a.abs() / (2.0 * self.jerk)
    }

    /// Returns H(v, a) of the module.
    fn stop_distance(&self, v: f64, a: f64) -> f64 {
        let (jerk, reaction, a) = (self.jerk, self.reaction, a.max(-self.envelope));
        let peak = v + a * a / (2.0 * jerk);
        if self.level(v, a) > 0.0 {
            let moves_on = if a > 0.0 { peak * (reaction + DRIVE_ERROR) } else { v * reaction };
            moves_on + (v + a * a / (3.0 * jerk)) * a / jerk + self.stop_from(peak)
        } else if v > 0.0 {
            let time = 2.0 * v / ((a * a - 2.0 * jerk * v).max(0.0).sqrt() - a);
            v * reaction + time * (v + time * (0.5 * a + time * jerk / 6.0))
        } else {
            0.0
        }
    }

    /// Returns D(p), the distance of a stop from a constant speed p ≥ 0.
    fn stop_from(&self, p: f64) -> f64 {
        let (jerk, deceleration) = (self.jerk, self.deceleration);
        if p * jerk <= deceleration * deceleration {
            p * (p / jerk).sqrt()
        } else {
            0.5 * p * (p / deceleration + deceleration / jerk)
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use revprio_robot::VelocityEnvelope;

    use super::super::LimitKind;
    use super::super::braking::NOISE_TOLERANCE;
    use super::super::limited_box::Interval;
    use super::*;
    use crate::arm_state::JointMotion;

    fn interval(limits: &JointLimits, q: f64, last: f64, acceleration: f64, period: f64) -> Interval {
        let motion = JointMotion {
            position: &[q],
            distance_to_rest: &[],
            last_command: &[last],
            last_acceleration: &[acceleration],
        };
        Interval::from_limits(limits, LimitKind::PositionVelocityAcceleration, motion, 0, period)
    }

    const SOFT: JointLimits =
        JointLimits { lower: -1.0, upper: 2.0, velocity: 1.5, acceleration: 8.0, jerk: 100.0, ..JointLimits::NONE };

    fn jerk_limit(period: f64) -> JerkLimit {
        JerkLimit::of(&SOFT, period).unwrap()
    }

    #[test]
    fn a_jerk_limit_that_the_acceleration_limit_implies_does_not_count() {
        assert!(JerkLimit::of(&JointLimits { jerk: 15_999.0, ..SOFT }, 1e-3).is_some());
        assert!(JerkLimit::of(&JointLimits { jerk: 16_000.0, ..SOFT }, 1e-3).is_none());
        assert!(JerkLimit::of(&JointLimits { jerk: f64::INFINITY, ..SOFT }, 1e-3).is_none());
        assert!(JerkLimit::of(&JointLimits::NONE, 1e-3).is_none());
    }

    /// Integrates the stop from a speed and an acceleration.
    fn integrated_stop(v: f64, a: f64) -> f64 {
        let (mut q, mut v, mut a, step) = (0.0, v, a, 1e-6);
        while v > 0.0 {
            let jerk = if v + a * a.abs() / (2.0 * SOFT.jerk) > 0.0 { -SOFT.jerk } else { SOFT.jerk };
            let next = (a + jerk * step).max(-SOFT.acceleration);
            (q, v, a) = (q + step * v, v + 0.5 * step * (a + next), next);
        }
        q
    }

    #[test]
    fn the_distance_of_a_stop_is_that_of_its_motion() {
        let limit = JerkLimit { reaction: 0.0, ..jerk_limit(1e-3) };
        for (v, a) in [(1.0, 0.0), (0.3, 0.0), (0.5, 5.0), (0.6, -4.0), (0.05, -8.0), (1.2, -8.0), (1e-3, -2.0)] {
            let to_accelerate = if a > 0.0 { DRIVE_ERROR * (v + a * a / 2.0 / SOFT.jerk) } else { 0.0 };
            let (found, expected) = (limit.stop_distance(v, a), integrated_stop(v, a) + to_accelerate);
            assert!((found - expected).abs() < 1e-4 * (1.0 + expected), "{v} {a}: {found} {expected}");
        }
        assert_eq!(limit.stop_distance(-1.0, -1.0), 0.0);
    }

    /// A joint that brakes harder than its envelope assumes must still have the distance that the envelope asks for its speed.
    #[test]
    fn the_distance_of_a_stop_is_not_less_than_a_velocity_envelope_asks() {
        for deceleration in [0.3, 2.0, 7.0, 20.0] {
            let envelope = revprio_robot::VelocityEnvelope { deceleration, offset: 0.2 };
            let limit = JerkLimit::of(&JointLimits { envelope, ..SOFT }, 1e-3).unwrap();
            for v in [1e-3, 0.01, 0.05, 0.1, 0.3, 1.0] {
                let least = v * limit.reaction + v * v / (2.0 * deceleration.min(SOFT.acceleration));
                let mut before = 0.0;
                for a in (-80..=80).map(|step| 0.1 * f64::from(step)) {
                    let found = limit.stop_distance(v, a);
                    assert!(found >= least * (1.0 - 1e-12), "{deceleration} {v} {a}: {found} {least}");
                    assert!(found >= before * (1.0 - 1e-12), "{deceleration} {v} {a}: {found} after {before}");
                    before = found;
                }
            }
        }
    }

    #[test]
    fn a_joint_levels_off_exactly_at_its_speed_limit() {
        let period = 1e-3;
        let (mut last, mut acceleration, mut largest) = (0.0, 0.0, 0.0_f64);
        for _ in 0..1000 {
            let command = jerk_limit(period).largest(last, acceleration, f64::INFINITY).0;
            let next = (command - last) / period;
            assert!((next - acceleration).abs() <= SOFT.jerk * period + 1e-9 && next <= SOFT.acceleration + 1e-9);
            (last, acceleration, largest) = (command, next, largest.max(next));
        }
        assert!(last == SOFT.velocity && largest > 0.99 * SOFT.acceleration, "{last} {largest}");
    }

    #[test]
    fn a_joint_arrives_at_a_velocity_that_its_task_wants_and_stays_there() {
        let period = 1e-3;
        for ramp in [0.0, 3.0] {
            let (mut last, mut acceleration, mut error) = (0.0, 0.0, 0.0);
            let mut passed = 0.0_f64;
            for number in 0..600 {
                let requested = |number: i32| 0.4 + ramp * period * f64::from(number.min(300));
                let wanted = requested(number);
                let reach = jerk_limit(period).reach(last, acceleration);
                let (lower, upper) =
                    jerk_limit(period).approach(reach, (last, acceleration), wanted, requested(number - 1));
                let command = wanted.clamp(lower, upper);
                acceleration = jerk_limit(period).next_acceleration(acceleration, last, command);
                (last, error) = (command, command - wanted);
                passed = passed.max(error);
            }
            // The ramp ends without notice, so the joint passes it by a²/2J.
            let unavoidable = ramp * ramp / (2.0 * SOFT.jerk);
            assert!(error == 0.0 && passed <= unavoidable + 1e-9, "{ramp}: {error} {passed}");
        }
    }

    #[test]
    fn after_a_jump_position_and_acceleration_win_and_a_conflict_is_reported() {
        let at = |q, last, acceleration| interval(&SOFT, q, last, acceleration, 1e-3);
        let push = at(2.0, 0.2, 0.0);
        assert!(push.conflict && push.upper == 0.0, "{push:?}");
        for last in [0.05, 0.044] {
            let slower = at(2.0, last, 0.0);
            assert!(slower.conflict && (slower.upper - (last - 0.008)).abs() < 1e-12, "{slower:?}");
        }
        // Noise may explain what a slower joint shows: it brakes with its jerk.
        let noisy = at(2.0, 0.02, 0.0);
        assert!(!noisy.conflict && (noisy.upper - 0.0199).abs() < 1e-12, "{noisy:?}");
        let fast = at(0.0, 1.6, 0.0);
        assert!(fast.conflict && fast.upper == 1.5, "{fast:?}");
        // Beyond the limit the joint begins to return as fast as the jerk allows.
        let beyond = at(2.1, 0.0, 0.0);
        assert!(!beyond.conflict && (beyond.upper + 1e-4).abs() < 1e-12, "{beyond:?}");
        // The jump itself is not remembered as an acceleration.
        assert!((jerk_limit(1e-3).next_acceleration(0.0, 1e-3, 0.0) + 0.1).abs() < 1e-12);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The box is never empty, whatever happened before.
        #[test]
        fn no_box_is_empty(
            q in -20.0..20.0_f64,
            range in 0.0..10.0_f64,
            velocity in 1e-2..10.0_f64,
            acceleration in prop::option::of(1e-1..100.0_f64),
            jerk in 1e-1..1e4_f64,
            last in -20.0..20.0_f64,
            share in -1.0..1.0_f64,
            period in 1e-4..0.1_f64,
        ) {
            let acceleration = acceleration.unwrap_or(f64::INFINITY);
            let limits = JointLimits { lower: -0.3 * range, upper: 0.7 * range, velocity, acceleration, jerk, ..JointLimits::NONE };
            let before = share * braking_deceleration(&limits);
            let Interval { lower, upper, .. } = interval(&limits, q, last, before, period);
            prop_assert!(lower <= upper, "{lower} {upper}");
        }

        /// The commands are adversarial but inside the box, and the joint follows them: no limit is exceeded, and the jerk
        /// never contradicts another limit.
        #[test]
        fn limits_hold_at_all_times_after_a_start_inside(
            start in 0.0..=1.0_f64,
            range in 1e-3..10.0_f64,
            [velocity, acceleration] in [1e-2..10.0_f64, 1e-1..100.0],
            jerk in (0.0..4.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
            period in 1e-4..0.1_f64,
            choices in prop::collection::vec(0.0..=1.0_f64, 10),
            persistence in 1_usize..30,
        ) {
            let limits = JointLimits { lower: -0.3 * range, upper: 0.7 * range, velocity, acceleration, jerk, ..JointLimits::NONE };
            let Some(limit) = JerkLimit::of(&limits, period) else { return Ok(()) };
            let (mut q, mut last, mut before) = (limits.lower + start * range, 0.0_f64, 0.0_f64);
            for choice in choices.iter().flat_map(|choice| std::iter::repeat_n(choice, persistence)) {
                let allowed = interval(&limits, q, last, before, period);
                prop_assert!(!allowed.conflict && allowed.lower <= allowed.upper);
                // Choose a bound of the box about every second time.
                let choice = (2.0 * choice - 0.5).clamp(0.0, 1.0);
                let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
                let rounding = 1e-9 / period;
                let now = (command - last) / period;
                prop_assert!(command.abs() <= velocity + 1e-12 && now.abs() <= acceleration + rounding);
                prop_assert!((now - before).abs() <= jerk * period + rounding, "{now} {before}");
                q += period * command;
                prop_assert!((limits.lower - 1e-9..=limits.upper + 1e-9).contains(&q));
                (before, last) = (limit.next_acceleration(before, last, command), command);
            }
        }

        /// A jerk limit without an acceleration limit is kept, whether it is above or below what a jump of the speed needs,
        /// also without a speed limit.
        #[test]
        fn a_jerk_limit_alone_is_kept(
            range in 0.1..10.0_f64,
            velocity in prop::option::of(1e-2..10.0_f64),
            jerk in (0.0..6.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
            period in 1e-3..0.02_f64,
            choices in prop::collection::vec(0.0..=1.0_f64, 100),
        ) {
            let velocity = velocity.unwrap_or(f64::INFINITY);
            let acceleration = f64::INFINITY;
            let limits = JointLimits { lower: -range, upper: range, velocity, acceleration, jerk, ..JointLimits::NONE };
            let limit = JerkLimit::of(&limits, period);
            let (mut q, mut last, mut before) = (0.0, 0.0_f64, 0.0_f64);
            for choice in choices {
                let allowed = interval(&limits, q, last, before, period);
                prop_assert!(!allowed.conflict && allowed.lower <= allowed.upper, "{allowed:?}");
                let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
                let now = (command - last) / period;
                prop_assert!((now - before).abs() <= jerk * period * (1.0 + 1e-9) + 1e-9 / period, "{now} {before}");
                q += period * command;
                prop_assert!((-range - 1e-9..=range + 1e-9).contains(&q), "{q}");
                before = limit.map_or(now, |limit| limit.next_acceleration(before, last, command));
                last = command;
            }
        }

        /// A joint that starts at rest outside its range, or inside the margin of its envelope, keeps all limits on its way back. The
        /// commands are adversarial but inside the box.
        #[test]
        fn the_way_back_keeps_the_limits(
            beyond in 1e-4..2.0_f64,
            side in prop::sample::select(vec![-1.0, 1.0]),
            range in 0.1..10.0_f64,
            [velocity, acceleration] in [1e-2..10.0_f64, 1e-1..100.0],
            jerk in (0.0..4.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
            envelope in prop::option::of([0.2..3.0_f64, 0.01..0.3]),
            period in 1e-4..0.02_f64,
            choices in prop::collection::vec(0.0..=1.0_f64, 10),
            persistence in 1_usize..200,
        ) {
            let mut limits = JointLimits { lower: -range, upper: range, velocity, acceleration, jerk, ..JointLimits::NONE };
            if let Some([factor, share]) = envelope {
                let deceleration = factor * acceleration;
                limits.envelope = VelocityEnvelope { deceleration, offset: (share * range * deceleration).sqrt() };
            }
            let Some(limit) = JerkLimit::of(&limits, period) else { return Ok(()) };
            let end = limits.resting_range()[1];
            let (mut q, mut last, mut before) = (side * (end + beyond), 0.0_f64, 0.0_f64);
            for choice in choices.iter().flat_map(|choice| std::iter::repeat_n(choice, persistence)) {
                let allowed = interval(&limits, q, last, before, period);
                prop_assert!(!allowed.conflict && allowed.lower <= allowed.upper, "{allowed:?}");
                let choice = (2.0 * choice - 0.5).clamp(0.0, 1.0);
                let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
                let rounding = 1e-9 / period;
                let now = (command - last) / period;
                prop_assert!(command.abs() <= velocity + 1e-12 && now.abs() <= acceleration + rounding);
                prop_assert!((now - before).abs() <= jerk * period + rounding, "{now} {before}");
                prop_assert!(side * q <= end || side * command <= 1e-12, "{command} away from the range");
                q += period * command;
                prop_assert!(side * q >= -end - 1e-9, "{q}");
                (before, last) = (limit.next_acceleration(before, last, command), command);
            }
        }

        /// Noise of the measured position contradicts no limit, with and without a jerk limit, and the joint passes its range by
        /// the noise at most. The commands are adversarial but inside the box.
        #[test]
        fn noise_is_no_conflict(
            start in 0.0..=1.0_f64,
            range in 0.1..10.0_f64,
            [velocity, acceleration] in [1e-2..10.0_f64, 1e-1..100.0],
            jerk in prop::option::of((0.0..4.0_f64).prop_map(|exponent| 10_f64.powf(exponent))),
            period in 1e-4..0.02_f64,
            choices in prop::collection::vec((0.0..=1.0_f64, -1.0..=1.0_f64), 100),
            persistence in 1_usize..30,
        ) {
            let noise = 0.5 * NOISE_TOLERANCE;
            let jerk = jerk.unwrap_or(f64::INFINITY);
            let limits = JointLimits { lower: -0.3 * range, upper: 0.7 * range, velocity, acceleration, jerk, ..JointLimits::NONE };
            let limit = JerkLimit::of(&limits, period);
            let (mut q, mut last, mut before) = (limits.lower + start * range, 0.0_f64, 0.0_f64);
            for (number, (_, error)) in choices.iter().enumerate() {
                let allowed = interval(&limits, q + noise * error, last, before, period);
                prop_assert!(!allowed.conflict && allowed.lower <= allowed.upper, "{allowed:?}");
                let choice = (2.0 * choices[number / persistence].0 - 0.5).clamp(0.0, 1.0);
                let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
                let (rounding, now) = (1e-9 / period, (command - last) / period);
                prop_assert!(command.abs() <= velocity + 1e-12 && now.abs() <= acceleration + rounding);
                prop_assert!((now - before).abs() <= jerk * period + rounding, "{now} {before}");
                q += period * command;
                prop_assert!((limits.lower - noise - 1e-9..=limits.upper + noise + 1e-9).contains(&q), "{q}");
                before = limit.map_or(now, |limit| limit.next_acceleration(before, last, command));
                last = command;
            }
        }
    }
}

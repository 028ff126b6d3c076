//! Joints with a velocity envelope: every command keeps it, at the measured position and until the next command, and so does a stop.

use proptest::prelude::*;
use revprio_robot::{JointLimits, VelocityEnvelope};

use super::bound_cause::BoundCause;
use super::braking::{NOISE_TOLERANCE, braking_deceleration, reaction_time};
use super::full_braking::full_braking;
use super::jerk::JerkLimit;
use super::limit_kind::LimitKind;
use super::limited_box::Interval;
use crate::arm_state::JointMotion;

/// The second joint of Franka's arm, with a rounder range.
const JOINT: JointLimits = JointLimits {
    lower: -1.8,
    upper: 1.8,
    velocity: 2.62,
    acceleration: 10.0,
    jerk: f64::INFINITY,
    envelope: VelocityEnvelope { deceleration: 2.585, offset: 0.2 },
};

const ALL: LimitKind = LimitKind::PositionVelocityAcceleration;

/// One joint that follows its commands at once.
#[derive(Debug, Clone, Copy)]
struct Motion {
    q: f64,
    last: f64,
    acceleration: f64,
}

impl Motion {
    fn at_rest(q: f64) -> Self {
        Self { q, last: 0.0, acceleration: 0.0 }
    }

    fn interval(&self, limits: &JointLimits, kind: LimitKind, period: f64) -> Interval {
        let motion = JointMotion {
            position: &[self.q],
            distance_to_rest: &[],
            last_command: &[self.last],
            last_acceleration: &[self.acceleration],
        };
        Interval::from_limits(limits, kind, motion, 0, period)
    }

    fn follow(&mut self, command: f64, limits: &JointLimits, period: f64) {
        let now = (command - self.last) / period;
        let jerk = JerkLimit::of(limits, period);
        self.acceleration = jerk.map_or(now, |jerk| jerk.next_acceleration(self.acceleration, self.last, command));
        (self.q, self.last) = (self.q + period * command, command);
    }
}

/// Returns how much further away the end that a joint moves to would have to be for its velocity: negative inside the envelope.
fn missing_distance(limits: &JointLimits, q: f64, v: f64) -> f64 {
    let VelocityEnvelope { deceleration, offset } = limits.envelope;
    let distance = if v > 0.0 { limits.upper - q } else { q - limits.lower };
    if v == 0.0 { f64::NEG_INFINITY } else { (v.abs() + offset).powi(2) / (2.0 * deceleration) - distance }
}

/// Returns limits with an envelope; `share`: o²/2D as a share of half of the range.
fn enveloped(range: f64, share: f64, deceleration: f64, others: JointLimits) -> JointLimits {
    let offset = (share * range * deceleration).sqrt();
    let envelope = VelocityEnvelope { deceleration, offset };
    JointLimits { lower: -0.3 * range, upper: 0.7 * range, envelope, ..others }
}

#[test]
fn the_bound_is_the_envelope_at_the_position_at_the_end_of_the_reaction_time() {
    for period in [1e-3, 4e-3, 2e-2] {
        for distance in [0.01, 0.1, 0.5] {
            let motion = Motion::at_rest(JOINT.upper - distance);
            let upper = motion.interval(&JOINT, LimitKind::PositionVelocity, period).upper;
            let later = JOINT.envelope.max_speed(distance - upper * reaction_time(period));
            assert!((upper - later).abs() < 1e-12 && upper < JOINT.envelope.max_speed(distance), "{upper} {later}");
        }
    }
}

#[test]
fn the_bound_names_the_envelope() {
    let causes = |q, kind| Motion::at_rest(q).interval(&JOINT, kind, 1e-3).causes;
    let soft = JointLimits { jerk: 1e3, ..JOINT };
    assert_eq!(causes(1.78, LimitKind::PositionVelocity), [BoundCause::Velocity, BoundCause::Envelope]);
    assert_eq!(causes(-1.78, LimitKind::PositionVelocity), [BoundCause::Envelope, BoundCause::Velocity]);
    assert_eq!(causes(JOINT.resting_range()[1], ALL), [BoundCause::Acceleration, BoundCause::Envelope]);
    let at_the_margin = Motion::at_rest(JOINT.resting_range()[1] - 1e-9).interval(&soft, ALL, 1e-3);
    assert_eq!(at_the_margin.causes, [BoundCause::Jerk, BoundCause::Envelope]);
}

/// A joint within its margin, or outside its range, moves back to the margin and can then move on; a joint that is too fast brakes.
#[test]
fn a_start_outside_the_envelope_leads_back_into_it() {
    let period = 1e-3;
    let [_, margin] = JOINT.resting_range();
    for jerk in [f64::INFINITY, 2e3] {
        let limits = JointLimits { jerk, ..JOINT };
        for (q, last) in [(margin + 1e-3, 0.0), (1.799, 0.0), (1.9, 0.0), (1.7, 1.5), (1.5, 2.6)] {
            let mut motion = Motion { last, ..Motion::at_rest(q) };
            for _ in 0..2000 {
                let allowed = motion.interval(&limits, ALL, period);
                let change = (allowed.upper - motion.last).abs();
                assert!(allowed.conflict || change <= limits.acceleration * period + 1e-12, "{allowed:?}");
                motion.follow(allowed.upper, &limits, period);
            }
            assert!((motion.q - margin).abs() < 1e-4, "{q} {last}: {motion:?}");
            let free = motion.interval(&limits, ALL, period);
            assert!(free.lower < 0.0 && !free.conflict, "{free:?}");
        }
    }
}

/// Other joints do not change: without an envelope each term is the one of before, to the last bit.
#[test]
fn a_joint_without_an_envelope_keeps_its_bounds_to_the_last_bit() {
    let joint = JointLimits { envelope: VelocityEnvelope::NONE, ..JOINT };
    for (number, period) in (0..3000).zip([1e-3, 4e-3, 1e-2].into_iter().cycle()) {
        let distance = 1e-6 * 1.005_f64.powi(number);
        let q = joint.upper - distance;
        let (reaction, d) = (reaction_time(period), joint.upper - q);
        let expected = (2.0 * d / (reaction + (reaction * reaction + 2.0 * d / 10.0).sqrt())).min(joint.velocity);
        let found = Motion::at_rest(q).interval(&joint, LimitKind::PositionVelocity, period).upper;
        assert_eq!(found.to_bits(), expected.to_bits());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// The box is never empty, whatever happened before.
    #[test]
    fn no_box_is_empty(
        q in -20.0..20.0_f64,
        range in 0.0..10.0_f64,
        share in 0.0..=1.0_f64,
        deceleration in (-3.0..3.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        velocity in 1e-2..10.0_f64,
        acceleration in prop::option::of(1e-1..100.0_f64),
        jerk in prop::option::of(1e-1..1e4_f64),
        last in -20.0..20.0_f64,
        before in -1.0..1.0_f64,
        period in 1e-4..0.1_f64,
    ) {
        let [acceleration, jerk] = [acceleration, jerk].map(|limit| limit.unwrap_or(f64::INFINITY));
        let limits = enveloped(range, share, deceleration, JointLimits { velocity, acceleration, jerk, ..JOINT });
        let motion = Motion { q, last, acceleration: before * braking_deceleration(&limits) };
        for kind in [LimitKind::PositionVelocity, ALL] {
            let Interval { lower, upper, .. } = motion.interval(&limits, kind, period);
            prop_assert!(lower <= upper, "{kind:?}: {lower} {upper}");
        }
    }

    /// The commands are adversarial but inside the box, and the joint follows them. Each keeps the envelope during its period and until the
    /// end of the reaction time, no limits contradict each other, and full braking and the ramp of the watchdog keep it too. With noise
    /// of the position, the envelope is that of an end further away by the noise.
    #[test]
    fn commands_and_stops_keep_the_envelope(
        start in 0.0..=1.0_f64,
        range in 1e-2..10.0_f64,
        share in 0.0..0.9_f64,
        // From much softer to much harder than the acceleration limit.
        softness in (-2.0..1.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        [velocity, acceleration] in [1e-2..10.0_f64, 1e-1..100.0],
        jerk in prop::option::of((0.0..4.0_f64).prop_map(|exponent| 10_f64.powf(exponent))),
        period in 1e-4..0.1_f64,
        noise in prop_oneof![Just(0.0), Just(0.5 * NOISE_TOLERANCE)],
        choices in prop::collection::vec((0.0..=1.0_f64, -1.0..=1.0_f64), 100),
        persistence in 1_usize..30,
    ) {
        let jerk = jerk.unwrap_or(f64::INFINITY);
        let others = JointLimits { velocity, acceleration, jerk, ..JOINT };
        let limits = enveloped(range, share, softness * acceleration, others);
        let [lowest, highest] = limits.resting_range();
        let mut motion = Motion::at_rest(lowest + start * (highest - lowest));
        let tolerance = noise + 1e-9 * (1.0 + range);
        for number in 0..choices.len() {
            let measured = Motion { q: motion.q + noise * choices[number].1, ..motion };
            let allowed = measured.interval(&limits, ALL, period);
            prop_assert!(!allowed.conflict && allowed.lower <= allowed.upper, "{allowed:?}");
            let choice = (2.0 * choices[number / persistence].0 - 0.5).clamp(0.0, 1.0);
            let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
            let full = full_braking(&limits, (motion.last, Some(motion.acceleration)), period);
            let is_allowed = (allowed.lower - 1e-9..=allowed.upper + 1e-9).contains(&full);
            // A joint that seems to be outside must move back.
            prop_assert!(is_allowed || noise > 0.0, "{full} {allowed:?}");
            for time in [0.0, period, reaction_time(period)] {
                let missing = missing_distance(&limits, motion.q + time * command, command);
                prop_assert!(missing <= tolerance, "{missing} at {time} s of {motion:?}");
            }
            let rounding = 1e-9 / period;
            let now = (command - motion.last) / period;
            prop_assert!(now.abs() <= acceleration + rounding && command.abs() <= velocity + 1e-12);
            prop_assert!((now - motion.acceleration).abs() <= jerk * period + rounding || jerk.is_infinite());
            motion.follow(command, &limits, period);
            let mut ramp = motion;
            while ramp.last != 0.0 {
                let change = braking_deceleration(&limits) * period;
                let slower = ramp.last - ramp.last.clamp(-change, change);
                ramp.follow(slower, &limits, period);
                prop_assert!(missing_distance(&limits, ramp.q, slower) <= tolerance, "{ramp:?}");
            }
            prop_assert!((lowest - tolerance..=highest + tolerance).contains(&motion.q), "{motion:?}");
        }
    }

    /// A joint that may jump from one speed to another keeps the envelope as well.
    #[test]
    fn commands_that_jump_keep_the_envelope(
        start in 0.0..=1.0_f64,
        range in 1e-2..10.0_f64,
        share in 0.0..0.9_f64,
        deceleration in (-2.0..2.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        velocity in 1e-2..10.0_f64,
        period in 1e-4..0.1_f64,
        choices in prop::collection::vec(prop::bool::ANY, 100),
    ) {
        let limits = enveloped(range, share, deceleration, JointLimits { velocity, ..JOINT });
        let [lowest, highest] = limits.resting_range();
        let mut motion = Motion::at_rest(lowest + start * (highest - lowest));
        for up in choices {
            let allowed = motion.interval(&limits, LimitKind::PositionVelocity, period);
            let command = if up { allowed.upper } else { allowed.lower };
            motion.follow(command, &limits, period);
            let missing = missing_distance(&limits, motion.q, command);
            prop_assert!(missing <= 1e-9 * (1.0 + range), "{missing}: {motion:?}");
        }
    }
}

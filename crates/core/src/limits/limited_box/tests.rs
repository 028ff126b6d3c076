//! Intervals of one joint: the terms of each kind of limits, and that they are never empty.

use proptest::prelude::*;

use super::*;

const LIMITS: JointLimits =
    JointLimits { lower: -1.0, upper: 2.0, velocity: 1.5, acceleration: 8.0, ..JointLimits::NONE };
const T: f64 = 0.01;

/// Returns the interval of a joint that follows its commands at once.
fn at(limits: &JointLimits, kind: LimitKind, q: f64, last: f64, period: f64) -> Interval {
    let motion = JointMotion { position: &[q], distance_to_rest: &[], last_command: &[last], last_acceleration: &[] };
    Interval::from_limits(limits, kind, motion, 0, period)
}

fn interval(kind: LimitKind, q: f64, last: f64) -> (f64, f64, bool) {
    let Interval { lower, upper, conflict, .. } = at(&LIMITS, kind, q, last, T);
    (lower, upper, conflict)
}

#[test]
fn each_kind_adds_its_terms() {
    use LimitKind::{None, PositionVelocity, PositionVelocityAcceleration, Velocity};
    assert_eq!(interval(None, 0.0, 0.0), (f64::NEG_INFINITY, f64::INFINITY, false));
    assert_eq!(interval(Velocity, 1.999, 0.0), (-1.5, 1.5, false));
    let reaction = 2.0 * T;
    let (lower, upper, _) = interval(PositionVelocity, 1.999, 0.0);
    assert_eq!(lower, -1.5);
    assert!((upper * reaction + upper * upper / 16.0 - 0.001).abs() < 1e-15);
    assert_eq!(interval(PositionVelocity, 1.999, 1.5), (lower, upper, false));
    let (lower, upper, conflict) = interval(PositionVelocityAcceleration, 1.999, 0.0);
    assert_eq!(lower, -0.08);
    assert!((upper * reaction + upper * upper / 16.0 - 0.001).abs() < 1e-15 && !conflict);
}

#[test]
fn each_bound_names_the_limit_that_sets_it() {
    use BoundCause::{Acceleration, Position, Unlimited, Velocity};
    use LimitKind::PositionVelocityAcceleration as All;
    let causes = |kind, q, last| {
        let [lower, upper] = at(&LIMITS, kind, q, last, T).causes;
        (lower, upper)
    };
    assert_eq!(causes(LimitKind::None, 0.0, 0.0), (Unlimited, Unlimited));
    assert_eq!(causes(LimitKind::Velocity, 1.999, 0.0), (Velocity, Velocity));
    assert_eq!(causes(LimitKind::PositionVelocity, 1.999, 0.0), (Velocity, Position));
    assert_eq!(causes(All, 1.999, 0.0), (Acceleration, Position));
    assert_eq!(causes(All, 0.0, 1.49), (Acceleration, Velocity));
    // Beyond its range the joint must move back as fast as it can.
    assert_eq!(causes(All, 2.1, 0.0), (Acceleration, Acceleration));
    assert_eq!(causes(All, 2.0, 0.0), (Acceleration, Position));
    assert_eq!(causes(All, -1.0, 0.0), (Position, Acceleration));
}

#[test]
fn a_joint_outside_its_range_moves_back_within_velocity_and_acceleration_limits() {
    use LimitKind::{PositionVelocity, PositionVelocityAcceleration};
    let (lower, upper, _) = interval(PositionVelocity, 2.1, 0.0);
    let reaction = 2.0 * T;
    assert!(lower == -1.5 && (-upper * reaction + upper * upper / 16.0 - 0.1).abs() < 1e-12);
    assert_eq!(interval(PositionVelocityAcceleration, 2.1, 0.0), (-0.08, -0.08, false));
    let (lower, upper, conflict) = interval(PositionVelocityAcceleration, -1.1, 0.05);
    assert_eq!((lower, upper, conflict), (0.05 + 0.08, 0.05 + 0.08, false));
}

#[test]
fn after_a_jump_the_position_limit_holds_and_a_conflict_is_reported() {
    assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.0, 1.0), (0.0, 0.0, true));
    assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.5, 1.0), (0.0, 0.0, true));
    assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 0.0, 3.0), (1.5, 1.5, true));
    // Noise may explain what a slower joint shows: it brakes fully.
    for (last, allowed) in [(0.09, 0.01), (0.12, 0.04)] {
        let (_, upper, conflict) = interval(LimitKind::PositionVelocityAcceleration, 2.0001, last);
        assert!((upper - allowed).abs() < 1e-12 && !conflict, "{last}: {upper}");
    }
    assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.0001, 0.15), (0.0, 0.0, true));
}

/// Lost states leave less room than the box keeps. The acceleration limit holds as long as full braking is enough.
#[test]
fn a_joint_that_full_braking_still_stops_brakes_fully() {
    let (lower, upper, conflict) = interval(LimitKind::PositionVelocityAcceleration, 1.9, 1.25);
    assert!(lower == upper && (upper - 1.17).abs() < 1e-12 && !conflict, "{upper}");
    let (lower, upper, conflict) = interval(LimitKind::PositionVelocityAcceleration, 1.9, 1.4);
    assert!(lower == upper && upper < 1.12 && conflict, "{upper}");
}

#[test]
fn joints_without_limits_are_unbounded() {
    let free = at(&JointLimits::NONE, LimitKind::PositionVelocityAcceleration, 3.0, 1.0, T);
    assert_eq!((free.lower, free.upper, free.conflict), (f64::NEG_INFINITY, f64::INFINITY, false));
    let range = JointLimits { acceleration: f64::INFINITY, velocity: f64::INFINITY, ..LIMITS };
    let upper = at(&range, LimitKind::PositionVelocityAcceleration, 1.0, 0.0, T).upper;
    assert!((upper - 50.0).abs() < 1e-9);
}

#[test]
fn a_return_into_a_narrow_range_stops_before_its_other_end() {
    let narrow = JointLimits { lower: -0.01, upper: 0.01, ..LIMITS };
    for kind in [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration] {
        for q in [-1.0, -0.1, -0.011, 0.011, 0.1, 1.0] {
            let Interval { lower, upper, .. } = at(&narrow, kind, q, 0.0, T);
            assert!(lower <= upper, "{kind:?} {q}: {lower} {upper}");
            let speed = if q > 0.0 { -lower } else { upper };
            assert!(speed * T + speed * speed / 16.0 <= q.abs() + 0.01, "{kind:?} {q}: {lower} {upper}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// The box is never empty, wherever the joint is and whatever its last command was.
    #[test]
    fn no_box_is_empty(
        q in -20.0..20.0_f64,
        range in 0.0..10.0_f64,
        velocity in 1e-2..10.0_f64,
        acceleration in prop::option::of(1e-1..100.0_f64),
        last in -20.0..20.0_f64,
        period in 1e-4..0.1_f64,
    ) {
        let acceleration = acceleration.unwrap_or(f64::INFINITY);
        let (lower, upper) = (-0.3 * range, 0.7 * range);
        let limits = JointLimits { lower, upper, velocity, acceleration, ..JointLimits::NONE };
        for kind in [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration] {
            let Interval { lower, upper, .. } = at(&limits, kind, q, last, period);
            prop_assert!(lower <= upper, "{kind:?}: {lower} {upper}");
        }
    }

    /// The commands are adversarial but inside the box, and the joint follows them: no limit is exceeded and no box
    /// is empty.
    #[test]
    fn limits_hold_at_all_times_after_a_start_inside(
        start in 0.0..=1.0_f64,
        range in 1e-3..10.0_f64,
        velocity in 1e-2..10.0_f64,
        acceleration in 1e-1..100.0_f64,
        period in 1e-4..0.1_f64,
        choices in prop::collection::vec(0.0..=1.0_f64, 100),
    ) {
        let (lower, upper) = (-0.3 * range, 0.7 * range);
        let limits = JointLimits { lower, upper, velocity, acceleration, ..JointLimits::NONE };
        let (mut q, mut last) = (limits.lower + start * range, 0.0_f64);
        for choice in choices {
            let allowed =
                at(&limits, LimitKind::PositionVelocityAcceleration, q, last, period);
            prop_assert!(allowed.lower <= allowed.upper);
            // The two limits may contradict each other by rounding only.
            prop_assert!(last - acceleration * period <= allowed.upper + 1e-9);
            prop_assert!(last + acceleration * period >= allowed.lower - 1e-9);
            // Choose a bound of the box about every second time.
            let choice = (2.0 * choice - 0.5).clamp(0.0, 1.0);
            let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
            prop_assert!(command.abs() <= velocity && (command - last).abs() <= acceleration * period + 1e-9);
            q += period * command;
            prop_assert!((limits.lower - 1e-9..=limits.upper + 1e-9).contains(&q));
            last = command;
        }
    }

    #[test]
    fn a_start_outside_returns_within_400_periods_and_stays_inside(distance in 0.0..2.0_f64, side in prop::bool::ANY) {
        let mut q = if side { LIMITS.upper + distance } else { LIMITS.lower - distance };
        let mut last = 0.0_f64;
        for _ in 0..400 {
            let allowed = at(&LIMITS, LimitKind::PositionVelocityAcceleration, q, last, T);
            prop_assert!(!allowed.conflict);
            // Command the outward bound of the box.
            let command = if side { allowed.upper } else { allowed.lower };
            prop_assert!((command - last).abs() <= LIMITS.acceleration * T + 1e-12);
            q += T * command;
            last = command;
        }
        prop_assert!((LIMITS.lower - 1e-6..=LIMITS.upper + 1e-6).contains(&q));
    }
}

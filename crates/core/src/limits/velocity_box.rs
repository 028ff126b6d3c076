//! The velocity box, and its computation from the limits of a robot.

use revprio_robot::{JointLimits, RobotModel};

use super::braking::{NOISE_TOLERANCE, braking_deceleration, reaction_time};
use super::jerk::JerkLimit;
use crate::linalg::Vector;

/// The limits of a robot that apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// No limits: an unbounded box.
    None,
    /// The speed limit.
    Velocity,
    /// The speed limit and the position limits: the joint can still stop before a position limit. The change of the velocity
    /// from period to period has no limit.
    PositionVelocity,
    /// All limits: the acceleration limit also bounds the change of the velocity from period to period, and the jerk limit
    /// that of the acceleration.
    PositionVelocityAcceleration,
}

impl LimitKind {
    /// Returns whether the speed limit applies.
    pub fn includes_velocity(self) -> bool {
        self != Self::None
    }

    /// Returns whether the position limits apply.
    pub fn includes_position(self) -> bool {
        matches!(self, Self::PositionVelocity | Self::PositionVelocityAcceleration)
    }

    /// Returns whether the acceleration limit applies.
    pub fn includes_acceleration(self) -> bool {
        self == Self::PositionVelocityAcceleration
    }
}

/// Why a box is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VelocityBoxError {
    /// The numbers of lower and upper bounds differ.
    #[error("{lower} lower and {upper} upper bounds; give one of each per joint")]
    Size {
        /// Lower bounds given.
        lower: usize,
        /// Upper bounds given.
        upper: usize,
    },
    /// No finite velocity lies between the bounds, or a bound is NaN.
    #[error("lower bound {lower} is not at or below upper bound {upper}")]
    Empty {
        /// Joint index, from 0.
        joint: usize,
        /// Its lower bound.
        lower: f64,
        /// Its upper bound.
        upper: f64,
    },
}

/// The box lo ≤ q̇ ≤ hi, never empty; rad/s (m/s for prismatic joints); infinite where there is no limit.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityBox {
    lower: Vector,
    upper: Vector,
}

impl VelocityBox {
    /// Checks and builds a box from its bounds, n each.
    pub fn new(lower: &[f64], upper: &[f64]) -> Result<Self, VelocityBoxError> {
        if lower.len() != upper.len() {
            return Err(VelocityBoxError::Size { lower: lower.len(), upper: upper.len() });
        }
        // False for NaN, and for a bound that only an infinite velocity satisfies.
        let allows = |i: usize| lower[i] <= upper[i] && lower[i] < f64::INFINITY && upper[i] > f64::NEG_INFINITY;
        if let Some(joint) = (0..lower.len()).find(|&i| !allows(i)) {
            return Err(VelocityBoxError::Empty { joint, lower: lower[joint], upper: upper[joint] });
        }
        Ok(Self { lower: Vector::from_row_slice(lower), upper: Vector::from_row_slice(upper) })
    }

    /// Returns the box without bounds, for n joints.
    pub fn unbounded(n: usize) -> Self {
        Self { lower: Vector::repeat(n, f64::NEG_INFINITY), upper: Vector::repeat(n, f64::INFINITY) }
    }

    /// Copies a box for the same number of joints, without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        self.lower.copy_from(&other.lower);
        self.upper.copy_from(&other.upper);
    }

    /// Restricts the box to velocities that the robot reaches from the last command (n) within a period (T, s). Where there
    /// is none, it becomes the reachable velocity nearest to the box.
    pub fn bound_changes(&mut self, robot: &RobotModel, last_command: &[f64], period: f64) {
        for (i, (joint, last)) in robot.joints().iter().zip(last_command).enumerate() {
            let max_change = joint.limits.acceleration * period;
            for bound in [&mut self.lower[i], &mut self.upper[i]] {
                *bound = bound.clamp(last - max_change, last + max_change);
            }
        }
    }

    /// Returns lo, n.
    pub fn lower(&self) -> &Vector {
        &self.lower
    }

    /// Returns hi, n.
    pub fn upper(&self) -> &Vector {
        &self.upper
    }

    /// Returns n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.lower.len()
    }

    /// Returns the point of the box nearest to `velocity`.
    pub fn clamp(&self, velocity: &Vector) -> Vector {
        velocity.zip_zip_map(&self.lower, &self.upper, |v, lo, hi| v.max(lo).min(hi))
    }

    /// Returns whether `velocity` (n) lies inside; false if an entry is NaN.
    pub fn allows(&self, velocity: &[f64]) -> bool {
        let bounds = self.lower.iter().zip(self.upper.iter());
        velocity.iter().zip(bounds).all(|(v, (lower, upper))| lower <= v && v <= upper)
    }

    /// Returns the largest distance of an entry of `velocity` from the box, rad/s; 0 inside.
    pub fn violation(&self, velocity: &Vector) -> f64 {
        (velocity - self.clamp(velocity)).amax()
    }
}

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
                let VelocityBox { lower, upper } = &mut self.velocity_box;
                let last = (motion.last_command[i], motion.last_acceleration[i]);
                (lower[i], upper[i]) = jerk.around((lower[i], upper[i]), last, requested[i], last_requested[i]);
            }
        }
    }

    /// Updates the box to the result of [`robot_box`], for a robot with the same number of joints.
    pub fn update(&mut self, robot: &RobotModel, kind: LimitKind, motion: JointMotion, period: f64) {
        self.conflicts.clear();
        for (i, joint) in robot.joints().iter().enumerate() {
            let interval = Interval::from_limits(&joint.limits, kind, motion, i, period);
            self.velocity_box.lower[i] = interval.lower;
            self.velocity_box.upper[i] = interval.upper;
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
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LIMITS: JointLimits =
        JointLimits { lower: -1.0, upper: 2.0, velocity: 1.5, acceleration: 8.0, jerk: f64::INFINITY };
    const T: f64 = 0.01;

    /// Returns the interval of a joint that follows its commands at once.
    fn at(limits: &JointLimits, kind: LimitKind, q: f64, last: f64, period: f64) -> Interval {
        let motion =
            JointMotion { position: &[q], distance_to_rest: &[], last_command: &[last], last_acceleration: &[] };
        Interval::from_limits(limits, kind, motion, 0, period)
    }

    fn interval(kind: LimitKind, q: f64, last: f64) -> (f64, f64, bool) {
        let Interval { lower, upper, conflict } = at(&LIMITS, kind, q, last, T);
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
        let (_, upper, conflict) = interval(LimitKind::PositionVelocityAcceleration, 2.0001, 0.09);
        assert!((upper - 0.01).abs() < 1e-12 && !conflict, "{upper}");
        assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.0001, 0.12), (0.0, 0.0, true));
    }

    #[test]
    fn joints_without_limits_are_unbounded() {
        let free = at(&JointLimits::NONE, LimitKind::PositionVelocityAcceleration, 3.0, 1.0, T);
        assert_eq!(free, Interval { lower: f64::NEG_INFINITY, upper: f64::INFINITY, conflict: false });
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

    #[test]
    fn a_box_allows_its_bounds_and_nothing_outside() {
        let bounds = VelocityBox::new(&[-1.0, 0.0], &[2.0, 0.0]).unwrap();
        let entries = |vector: &Vector| vector.iter().copied().collect::<Vec<_>>();
        assert_eq!((entries(bounds.lower()), entries(bounds.upper())), (vec![-1.0, 0.0], vec![2.0, 0.0]));
        for inside in [[-1.0, 0.0], [0.5, 0.0], [2.0, 0.0]] {
            assert!(bounds.allows(&inside) && bounds.violation(&Vector::from_vec(inside.into())) == 0.0, "{inside:?}");
        }
        for outside in [[-1.5, 0.0], [2.5, 0.0], [0.0, 0.5], [0.0, -0.5]] {
            assert!(!bounds.allows(&outside), "{outside:?}");
            assert_eq!(bounds.violation(&Vector::from_vec(outside.into())), 0.5, "{outside:?}");
        }
        assert!(!bounds.allows(&[f64::NAN, 0.0]));
    }

    #[test]
    fn empty_boxes_are_refused() {
        assert!(matches!(VelocityBox::new(&[0.0, 1.0], &[0.0, 0.5]), Err(VelocityBoxError::Empty { joint: 1, .. })));
        assert!(matches!(VelocityBox::new(&[f64::NAN], &[0.0]), Err(VelocityBoxError::Empty { joint: 0, .. })));
        assert!(matches!(VelocityBox::new(&[0.0], &[]), Err(VelocityBoxError::Size { .. })));
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
}

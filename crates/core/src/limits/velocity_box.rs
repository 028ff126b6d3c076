//! The box itself, and how a robot's limits become one.

use revprio_robot::{JointLimits, RobotModel};

use crate::linalg::Vector;

/// Which of a robot's limits count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// None: an unbounded box.
    None,
    /// Speed alone.
    Velocity,
    /// Speed, and no more than the remaining way in one period.
    PositionVelocity,
    /// Speed, acceleration, and the speed from which the joint can still stop.
    PositionVelocityAcceleration,
}

/// Why a box is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum VelocityBoxError {
    /// Both sides need one bound per joint.
    #[error("{lower} lower and {upper} upper bounds; give one of each per joint")]
    Size {
        /// Lower bounds given.
        lower: usize,
        /// Upper bounds given.
        upper: usize,
    },
    /// No finite velocity is allowed, or a bound is NaN.
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

/// lo ≤ q̇ ≤ hi, never empty; rad/s (m/s for prismatic joints); infinite where there is no limit.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityBox {
    lower: Vector,
    upper: Vector,
}

impl VelocityBox {
    /// A box from its bounds, n each.
    pub fn new(lower: &[f64], upper: &[f64]) -> Result<Self, VelocityBoxError> {
        if lower.len() != upper.len() {
            return Err(VelocityBoxError::Size { lower: lower.len(), upper: upper.len() });
        }
        // NaN fails, and so does a bound that only an infinite velocity satisfies.
        let allows = |i: usize| lower[i] <= upper[i] && lower[i] < f64::INFINITY && upper[i] > f64::NEG_INFINITY;
        if let Some(joint) = (0..lower.len()).find(|&i| !allows(i)) {
            return Err(VelocityBoxError::Empty { joint, lower: lower[joint], upper: upper[joint] });
        }
        Ok(Self { lower: Vector::from_row_slice(lower), upper: Vector::from_row_slice(upper) })
    }

    /// The box without bounds, for n joints.
    pub fn unbounded(n: usize) -> Self {
        Self { lower: Vector::repeat(n, f64::NEG_INFINITY), upper: Vector::repeat(n, f64::INFINITY) }
    }

    /// Becomes a copy of a box for as many joints.
    pub fn copy_from(&mut self, other: &Self) {
        self.lower.copy_from(&other.lower);
        self.upper.copy_from(&other.upper);
    }

    /// lo, n.
    pub fn lower(&self) -> &Vector {
        &self.lower
    }

    /// hi, n.
    pub fn upper(&self) -> &Vector {
        &self.upper
    }

    /// n.
    pub fn joint_count(&self) -> usize {
        self.lower.len()
    }

    /// The point of the box nearest to `velocity`.
    pub fn clamp(&self, velocity: &Vector) -> Vector {
        velocity.zip_zip_map(&self.lower, &self.upper, |v, lo, hi| v.max(lo).min(hi))
    }

    /// Whether `velocity`, n, lies inside; never one that is not a number.
    pub fn allows(&self, velocity: &[f64]) -> bool {
        let bounds = self.lower.iter().zip(self.upper.iter());
        velocity.iter().zip(bounds).all(|(v, (lower, upper))| lower <= v && v <= upper)
    }

    /// How far `velocity` lies outside, of the worst joint, rad/s; 0 inside.
    pub fn violation(&self, velocity: &Vector) -> f64 {
        (velocity - self.clamp(velocity)).amax()
    }
}

/// A box with what had to give way to make it.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitedBox {
    /// The velocities allowed in this period.
    pub velocity_box: VelocityBox,
    /// Joints (index from 0) whose acceleration limit contradicts position or velocity and was overruled.
    pub conflicts: Vec<usize>,
}

/// The box of a robot's own limits at a state.
///
/// `joint_position` and `last_velocity`: n, as measured and as last commanded; `period`: T > 0, s.
pub fn robot_box(
    robot: &RobotModel,
    kind: LimitKind,
    joint_position: &[f64],
    last_velocity: &[f64],
    period: f64,
) -> LimitedBox {
    let mut limited = LimitedBox::unbounded(robot.joint_count());
    limited.update(robot, kind, joint_position, last_velocity, period);
    limited
}

impl LimitedBox {
    /// The box without bounds, for n joints.
    pub fn unbounded(n: usize) -> Self {
        Self { velocity_box: VelocityBox::unbounded(n), conflicts: Vec::new() }
    }

    /// Becomes what [`robot_box`] gives for a robot of as many joints.
    pub fn update(
        &mut self,
        robot: &RobotModel,
        kind: LimitKind,
        joint_position: &[f64],
        last_velocity: &[f64],
        period: f64,
    ) {
        self.conflicts.clear();
        for (i, joint) in robot.joints().iter().enumerate() {
            let interval = Interval::of(&joint.limits, kind, joint_position[i], last_velocity[i], period);
            self.velocity_box.lower[i] = interval.lower;
            self.velocity_box.upper[i] = interval.upper;
            if interval.conflict {
                self.conflicts.push(i);
            }
        }
    }
}

/// Disagreement of limits, rad/s, that counts as more than rounding.
const CONFLICT_TOLERANCE: f64 = 1e-9;

/// The allowed velocities of one joint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Interval {
    lower: f64,
    upper: f64,
    conflict: bool,
}

impl Interval {
    fn of(limits: &JointLimits, kind: LimitKind, q: f64, last: f64, period: f64) -> Self {
        let velocity = limits.velocity;
        let reach = limits.acceleration * period;
        let (lower, upper) = match kind {
            LimitKind::None => (f64::NEG_INFINITY, f64::INFINITY),
            LimitKind::Velocity => (-velocity, velocity),
            LimitKind::PositionVelocity => {
                let one_period = |way: f64| (way / period).clamp(-velocity, velocity);
                (one_period(limits.lower - q), one_period(limits.upper - q))
            }
            LimitKind::PositionVelocityAcceleration => {
                let stop = |way: f64, last: f64| towards(way, last, velocity, limits.acceleration, period);
                let (lower, upper) = (-stop(q - limits.lower, -last), stop(limits.upper - q, last));
                return Self {
                    lower: (last - reach).clamp(lower, upper),
                    upper: (last + reach).clamp(lower, upper),
                    conflict: last - reach > upper + CONFLICT_TOLERANCE || last + reach < lower - CONFLICT_TOLERANCE,
                };
            }
        };
        Self { lower, upper, conflict: false }
    }
}

/// Largest speed towards a limit `way` ahead: the braking term of the module's documentation, at most V.
///
/// A negative `way` (the limit is passed) demands the way back: mirrored, it is the speed that can still stop at the
/// limit, reached no faster than the acceleration allows, and never a further step outwards.
fn towards(way: f64, last: f64, velocity: f64, acceleration: f64, period: f64) -> f64 {
    // A(−T + √(T² + 2d/A)) without the cancellation for small d, and right for infinite d.
    let braking = |way: f64| match 2.0 * way / (period + (period * period + 2.0 * way / acceleration).sqrt()) {
        speed if speed.is_nan() => velocity,
        speed => speed.min(velocity),
    };
    if way >= 0.0 { braking(way) } else { (-braking(-way)).max(last - acceleration * period).min(0.0) }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const LIMITS: JointLimits = JointLimits { lower: -1.0, upper: 2.0, velocity: 1.5, acceleration: 8.0 };
    const T: f64 = 0.01;

    fn interval(kind: LimitKind, q: f64, last: f64) -> (f64, f64, bool) {
        let Interval { lower, upper, conflict } = Interval::of(&LIMITS, kind, q, last, T);
        (lower, upper, conflict)
    }

    #[test]
    fn each_kind_adds_its_terms() {
        use LimitKind::{None, PositionVelocity, PositionVelocityAcceleration, Velocity};
        assert_eq!(interval(None, 0.0, 0.0), (f64::NEG_INFINITY, f64::INFINITY, false));
        assert_eq!(interval(Velocity, 1.999, 0.0), (-1.5, 1.5, false));
        let (lower, upper, _) = interval(PositionVelocity, 1.999, 0.0);
        assert_eq!((lower, (upper * 1e9).round()), (-1.5, 1e8));
        let (lower, upper, conflict) = interval(PositionVelocityAcceleration, 1.999, 0.0);
        assert_eq!(lower, -0.08);
        assert!((upper * T + upper * upper / 16.0 - 0.001).abs() < 1e-15 && !conflict);
    }

    #[test]
    fn a_start_outside_is_driven_back_within_velocity_and_acceleration() {
        use LimitKind::{PositionVelocity, PositionVelocityAcceleration};
        assert_eq!(interval(PositionVelocity, 2.1, 0.0), (-1.5, -1.5, false));
        assert_eq!(interval(PositionVelocityAcceleration, 2.1, 0.0), (-0.08, -0.08, false));
        let (lower, upper, conflict) = interval(PositionVelocityAcceleration, -1.1, 0.05);
        assert_eq!((lower, upper, conflict), (0.05 + 0.08, 0.05 + 0.08, false));
    }

    #[test]
    fn a_jump_is_a_conflict_and_position_wins() {
        assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.0, 1.0), (0.0, 0.0, true));
        assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 2.5, 1.0), (0.0, 0.0, true));
        assert_eq!(interval(LimitKind::PositionVelocityAcceleration, 0.0, 3.0), (1.5, 1.5, true));
    }

    #[test]
    fn joints_without_limits_are_unbounded() {
        let free = Interval::of(&JointLimits::NONE, LimitKind::PositionVelocityAcceleration, 3.0, 1.0, T);
        assert_eq!(free, Interval { lower: f64::NEG_INFINITY, upper: f64::INFINITY, conflict: false });
        let range = JointLimits { acceleration: f64::INFINITY, velocity: f64::INFINITY, ..LIMITS };
        let upper = Interval::of(&range, LimitKind::PositionVelocityAcceleration, 1.0, 0.0, T).upper;
        assert!((upper - 100.0).abs() < 1e-9);
    }

    #[test]
    fn boxes_that_allow_nothing_do_not_exist() {
        assert!(matches!(VelocityBox::new(&[0.0, 1.0], &[0.0, 0.5]), Err(VelocityBoxError::Empty { joint: 1, .. })));
        assert!(matches!(VelocityBox::new(&[f64::NAN], &[0.0]), Err(VelocityBoxError::Empty { joint: 0, .. })));
        assert!(matches!(VelocityBox::new(&[0.0], &[]), Err(VelocityBoxError::Size { .. })));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// Adversarial commands inside the box, with a tracked velocity: no limit is ever broken, no box is empty.
        #[test]
        fn limits_hold_for_ever_from_a_start_inside(
            start in 0.0..=1.0_f64,
            range in 1e-3..10.0_f64,
            velocity in 1e-2..10.0_f64,
            acceleration in 1e-1..100.0_f64,
            period in 1e-4..0.1_f64,
            choices in prop::collection::vec(0.0..=1.0_f64, 100),
        ) {
            let limits = JointLimits { lower: -0.3 * range, upper: 0.7 * range, velocity, acceleration };
            let (mut q, mut last) = (limits.lower + start * range, 0.0_f64);
            for choice in choices {
                let allowed =
                    Interval::of(&limits, LimitKind::PositionVelocityAcceleration, q, last, period);
                prop_assert!(allowed.lower <= allowed.upper);
                // Rounding may make the last bit of the two limits disagree; more than that would be a flaw.
                prop_assert!(last - acceleration * period <= allowed.upper + 1e-9);
                prop_assert!(last + acceleration * period >= allowed.lower - 1e-9);
                // Full speed one way or the other more often than not.
                let choice = (2.0 * choice - 0.5).clamp(0.0, 1.0);
                let command = (allowed.lower + choice * (allowed.upper - allowed.lower)).min(allowed.upper);
                prop_assert!(command.abs() <= velocity && (command - last).abs() <= acceleration * period + 1e-9);
                q += period * command;
                prop_assert!((limits.lower - 1e-9..=limits.upper + 1e-9).contains(&q));
                last = command;
            }
        }

        /// From anywhere outside, the joint is back inside in bounded time and stays.
        #[test]
        fn a_start_outside_returns_and_stays(distance in 0.0..2.0_f64, side in prop::bool::ANY) {
            let mut q = if side { LIMITS.upper + distance } else { LIMITS.lower - distance };
            let mut last = 0.0_f64;
            for _ in 0..400 {
                let allowed = Interval::of(&LIMITS, LimitKind::PositionVelocityAcceleration, q, last, T);
                prop_assert!(!allowed.conflict);
                // Push outwards as hard as the box allows.
                let command = if side { allowed.upper } else { allowed.lower };
                prop_assert!((command - last).abs() <= LIMITS.acceleration * T + 1e-12);
                q += T * command;
                last = command;
            }
            prop_assert!((LIMITS.lower - 1e-6..=LIMITS.upper + 1e-6).contains(&q));
        }
    }
}

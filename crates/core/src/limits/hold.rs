//! The hold time of a command: how long it may be held before braking still ends inside the position range.
//!
//! # The bound
//!
//! A joint is at q and gets the command v > 0. It has the upper limit q_hi and brakes at a ([`braking_deceleration`](super::braking_deceleration)).
//! The last command was v⁻; T is the period and S = max(T, 10 ms). The hold time counts from the measurement of q:
//!
//! t = (q_hi − q − max(0, v⁻ − v) S − v²/2a) / v.
//!
//! # Why a watchdog that holds until t and then brakes ends inside
//!
//! The command reaches the joint at a time L ≤ S after the measurement. Until then the joint moves at v⁻ at most. The
//! command is held until t, and braking from v at a takes the distance v²/2a. So the joint comes to rest at most at
//!
//! q + v⁻ L + v (t − L) + v²/2a = q + v t + (v⁻ − v) L + v²/2a ≤ q + v t + max(0, v⁻ − v) S + v²/2a = q_hi.
//!
//! A watchdog sends commands once in a while. If each is at most the ramp at the time of the *next* one, then the
//! commanded velocity never exceeds the ramp, and the bound holds. The mirrored formula holds for v < 0. A joint at rest
//! has no bound. If v⁻ and v have opposite signs, the motion until L is covered by the box of the last command, because
//! T + L ≤ T + S = τ ([`reaction_time`](super::reaction_time)).
//!
//! For a joint with a velocity envelope, v²/2a becomes v²/2b + v o/D, and q_hi the end of the margin, see the module `limits`. Until t the
//! command keeps the envelope, and so does the ramp, which is not slower than b.
//!
//! # Why a command inside the box can be held for at least S
//!
//! The box demands v τ + v²/2a ≤ d with the reaction time τ = T + S, where d = q_hi − q. Let the last command obey its own
//! box and be followed: d ≥ v⁻ τ + v⁻²/2a − v⁻ T = v⁻ S + v⁻²/2a. If v⁻ ≤ v, then v t = d − v²/2a ≥ v τ. Otherwise
//!
//! v t ≥ v⁻ S + v⁻²/2a − (v⁻ − v) S − v²/2a ≥ v S.
//!
//! With an envelope the terms v⁻ o/D and v o/D are added, and v⁻ o/D is not less.
//!
//! The measured distance is noisy. A time below S counts as noise if δ = 0.5 mm or mrad of distance more would allow it. A
//! hold at rest on a limit then passes the limit by δ at most.

use revprio_robot::{JointLimits, RobotModel};

use super::LimitKind;
use super::braking::{NOISE_TOLERANCE, spare_time, stopping_deceleration};
use crate::arm_state::JointMotion;

/// Part of a period that rounding may add, ms.
const ROUNDING_MS: f64 = 1e-9;

/// Distance beyond a limit that counts as inside, rad or m, because measured positions are rounded.
const POSITION_TOLERANCE: f64 = 5e-7;

/// Distance beyond a limit up to which a measured velocity is not reported, rad or m, because it is noisy.
const SPEED_NOISE_TOLERANCE: f64 = 1e-3;

/// How long a command may be held.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Maximum time from the measurement to the start of braking, s; in an answer at least a period; infinite without a bound.
    pub time_s: f64,
    /// Joints (index from 0) that cannot stop inside their range, even if they brake now.
    pub too_fast: Vec<usize>,
}

impl Default for Hold {
    fn default() -> Self {
        Self { time_s: f64::INFINITY, too_fast: Vec::new() }
    }
}

impl Hold {
    /// Returns how long the command may be held, at most `longest`, whole ms.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the value is from 0 to the maximum")]
    pub fn valid_for_ms(&self, longest: u64) -> u64 {
        (self.time_s * 1e3).min(longest as f64) as u64
    }

    /// Shortens the hold to a time (s), and to no less than a period T (`period`, s).
    pub fn shorten(&mut self, time: f64, period: f64) {
        self.time_s = self.time_s.min(time);
        self.last_a_period(period);
    }

    /// Lets a command be held for a period T (`period`, s) at least, rounded down to whole ms, and for 1 ms.
    ///
    /// The next period counts with the command. A client that threw it away would go on with an older one, which may be faster.
    /// Rounded up, each state that comes late while the joint brakes fully would let it move further, and these ways would add up.
    fn last_a_period(&mut self, period: f64) {
        self.time_s = self.time_s.max((period * 1e3 + ROUNDING_MS).floor().max(1.0) * 1e-3);
    }

    /// Updates the hold time of a command. Limits without positions do not bound it.
    ///
    /// - `measured`: measured velocity, n.
    /// - `command`: the new command, n.
    /// - `period`: T, s.
    pub fn update(
        &mut self,
        robot: &RobotModel,
        kind: LimitKind,
        motion: JointMotion,
        measured: &[f64],
        command: &[f64],
        period: f64,
    ) {
        self.too_fast.clear();
        self.time_s = f64::INFINITY;
        if !kind.includes_position() {
            return;
        }
        for (i, joint) in robot.joints().iter().enumerate() {
            let (limits, last) = (&joint.limits, motion.last_command[i]);
            let (command, measured) = (command[i], measured[i]);
            let at_once = motion.stopping_at_once();
            let distance = |motion: JointMotion, velocity: f64| {
                let (to_lower, to_upper) = motion.distances(i, limits);
                if velocity > 0.0 { to_upper } else { to_lower }
            };
            let overshoots = |motion: JointMotion, velocity: f64, needed: f64, tolerance: f64| {
                velocity != 0.0 && needed > distance(motion, velocity) + tolerance
            };
            // The offset of an envelope counts for the command alone, because a measured velocity at rest is noise.
            let [to_stop, stopping] = [stop_distance(limits, command), braking_distance(limits, measured)];
            if overshoots(motion, command, to_stop, NOISE_TOLERANCE)
                || overshoots(at_once, measured, stopping, SPEED_NOISE_TOLERANCE)
            {
                self.too_fast.push(i);
            }
            if command != 0.0 {
                let joint_time =
                    hold_time(limits, distance(motion, command), command.abs(), last * command.signum(), period);
                self.time_s = self.time_s.min(joint_time);
            }
        }
    }
}

/// Returns v²/2b + |v| o/D, the distance that a joint with the velocity v must have; without an envelope the way of its stop at a.
fn stop_distance(limits: &JointLimits, v: f64) -> f64 {
    braking_distance(limits, v) + v.abs() * limits.envelope.reaction_time()
}

/// Returns v²/2b.
fn braking_distance(limits: &JointLimits, v: f64) -> f64 {
    v * v / 2.0 / stopping_deceleration(limits)
}

/// Returns t of the module for a joint with the speed v > 0 towards a limit at `distance`; `last`: v⁻.
fn hold_time(limits: &JointLimits, distance: f64, v: f64, last: f64, period: f64) -> f64 {
    let braking = stop_distance(limits, v);
    let delayed = (last - v).max(0.0) * spare_time(period);
    let [exact, forgiving] =
        [POSITION_TOLERANCE, NOISE_TOLERANCE].map(|tolerance| (distance + tolerance - delayed - braking) / v);
    exact.max(forgiving.min(spare_time(period))).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::super::braking_deceleration;
    use super::*;

    const LIMITS: JointLimits =
        JointLimits { lower: -1.0, upper: 2.0, velocity: 2.0, acceleration: 8.0, ..JointLimits::NONE };

    /// Returns the hold of the first joint of an arm, 1 mm before its upper limit. The other joints rest in their middle.
    fn near_the_limit(kind: LimitKind, command: f64, measured: f64) -> Hold {
        let robot = &revprio_robot::built_in()[0];
        let mut joint_position: Vec<f64> =
            robot.joints().iter().map(|joint| 0.5 * (joint.limits.lower + joint.limits.upper)).collect();
        joint_position[0] = robot.joints()[0].limits.upper - 1e-3;
        let mut velocities = vec![vec![0.0; robot.joint_count()]; 2];
        (velocities[0][0], velocities[1][0]) = (command, measured);
        let motion = JointMotion {
            position: &joint_position,
            distance_to_rest: &[],
            last_command: &velocities[0],
            last_acceleration: &[],
        };
        let mut hold = Hold::default();
        hold.update(robot, kind, motion, &velocities[1], &velocities[0], 0.001);
        hold
    }

    #[test]
    fn a_fast_command_and_a_fast_joint_are_each_reported() {
        let hold = |command, measured| near_the_limit(LimitKind::PositionVelocity, command, measured);
        assert_eq!((hold(1.0, 0.0).too_fast, hold(0.0, 1.0).too_fast), (vec![0], vec![0]));
        // The joint at rest needs no distance to stop; away from the limit there is enough.
        assert_eq!((hold(0.0, 0.0).too_fast, hold(-1.0, -1.0).too_fast), (vec![], vec![]));
        let slow = hold(0.01, 0.01);
        assert!(slow.too_fast.is_empty() && slow.time_s > 0.0 && slow.time_s < 0.1, "{slow:?}");
        assert_eq!((hold(1.0, 0.0).time_s, hold(0.0, 0.0).time_s), (0.0, f64::INFINITY));
    }

    #[test]
    fn a_speed_that_stops_within_the_distance_is_not_reported() {
        let joint = &revprio_robot::built_in()[0].joints()[0].limits;
        // v²/2a = d, give or take noise
        let fastest = (2.0 * (1e-3 + NOISE_TOLERANCE) * braking_deceleration(joint)).sqrt();
        let is_reported =
            |velocity: f64| !near_the_limit(LimitKind::PositionVelocity, velocity, 0.0).too_fast.is_empty();
        assert!(!is_reported(0.99 * fastest) && is_reported(1.01 * fastest));
        let range = joint.upper - joint.lower - 1e-3 + NOISE_TOLERANCE;
        let fastest_back = (2.0 * range * braking_deceleration(joint)).sqrt();
        assert!(!is_reported(-0.99 * fastest_back) && is_reported(-1.01 * fastest_back));
    }

    #[test]
    fn noise_of_the_velocity_at_the_margin_of_an_envelope_is_not_reported() {
        let robot = revprio_robot::built_in().iter().find(|robot| robot.name() == "fr3").unwrap();
        let mut position = vec![0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0];
        position[1] = robot.joints()[1].limits.resting_range()[1];
        let too_fast = |speed: f64| {
            let velocity = [0.0, speed, 0.0, 0.0, 0.0, 0.0, 0.0];
            let motion = JointMotion {
                position: &position,
                distance_to_rest: &[],
                last_command: &[0.0; 7],
                last_acceleration: &[],
            };
            let mut hold = Hold::default();
            hold.update(robot, LimitKind::PositionVelocity, motion, &velocity, &[0.0; 7], 0.001);
            hold.too_fast
        };
        // √(2 · 2.585 · 1e-3) = 0.072
        assert_eq!((too_fast(0.07), too_fast(0.075)), (vec![], vec![1]));
    }

    #[test]
    fn limits_without_positions_bound_no_hold() {
        for kind in [LimitKind::None, LimitKind::Velocity] {
            assert_eq!(near_the_limit(kind, 1.0, 1.0), Hold::default(), "{kind:?}");
        }
    }

    #[test]
    fn the_hold_time_leaves_room_for_braking_and_for_the_last_command() {
        let close = |given: f64, expected: f64| assert!((given - expected).abs() < 1e-5, "{given} {expected}");
        close(hold_time(&LIMITS, 0.1, 1.0, 0.0, 0.01), 0.1 - 1.0 / 16.0);
        close(hold_time(&LIMITS, 0.1, 1.0, 1.5, 0.01), 0.1 - 1.0 / 16.0 - 0.005);
        assert_eq!(hold_time(&LIMITS, 0.05, 1.0, 0.0, 0.01), 0.0);
        // A measured position may be noisy: beyond the point where braking must start, the time is S at most.
        let at_the_point = hold_time(&LIMITS, 1.0 / 16.0, 1.0, 0.0, 0.01);
        assert!((at_the_point - NOISE_TOLERANCE).abs() < 1e-12, "{at_the_point}");
        assert!((hold_time(&LIMITS, 0.0, 0.01, 0.0, 0.01) - 0.01).abs() < 1e-12);
        assert_eq!(hold_time(&LIMITS, f64::INFINITY, 1.0, 0.0, 0.01), f64::INFINITY);
        close(
            hold_time(
                &JointLimits { acceleration: f64::INFINITY, velocity: f64::INFINITY, ..LIMITS },
                0.1,
                2.0,
                0.0,
                0.01,
            ),
            0.05,
        );
    }
}

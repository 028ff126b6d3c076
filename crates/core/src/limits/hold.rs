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
//! # Joints that stop together
//!
//! Joints that brake at a each come to rest one after the other, and the tool turns away from its direction meanwhile: one that slides along
//! a surface is pushed into it. So where that presses less, the watchdog of a controller with the law `contact` lowers all speeds by the same
//! share per time, from u to 0 in the time t_s = max |uⱼ|/aⱼ ≤ 0.25 s. No joint then brakes faster than a. The proof above holds with |v|/t_s in place of a, and v²/2a becomes
//! v t_s/2; with an envelope, the smaller one of |v|/t_s and b takes the place of b. Where this leaves less than max(2 T, 10 ms), because
//! a joint is near the end of its range, the joints brake at a each.
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

use std::ops::RangeInclusive;

use revprio_robot::{JointLimits, RobotModel};

use super::LimitKind;
use super::braking::{NOISE_TOLERANCE, braking_deceleration, ramp_deceleration, spare_time, stopping_deceleration};
use crate::arm_state::JointMotion;

/// Part of a period that rounding may add, ms.
const ROUNDING_MS: f64 = 1e-9;

/// Distance beyond a limit that counts as inside, rad or m, because measured positions are rounded.
const POSITION_TOLERANCE: f64 = 5e-7;

/// Distance beyond a limit up to which a measured velocity is not reported, rad or m, because it is noisy.
const SPEED_NOISE_TOLERANCE: f64 = 1e-3;

/// Times of a common stop, s: below, times count as equal; above, one slow joint would make all others go on for long.
const STOP_TIMES: RangeInclusive<f64> = 1e-9..=0.25;

/// How long a command may be held, and how a watchdog brakes afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Hold {
    /// Maximum time from the measurement to the start of braking, s; in an answer at least a period; infinite without a bound.
    pub time_s: f64,
    /// t_s, time in which all joints come to rest together after that, s; `None`: each brakes at its own deceleration.
    pub stop_time_s: Option<f64>,
    /// Joints (index from 0) that cannot stop inside their range, even if they brake now.
    pub too_fast: Vec<usize>,
}

impl Default for Hold {
    fn default() -> Self {
        Self { time_s: f64::INFINITY, stop_time_s: None, too_fast: Vec::new() }
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
        (self.time_s, self.stop_time_s) = (f64::INFINITY, None);
        if !kind.includes_position() {
            return;
        }
        for (i, joint) in robot.joints().iter().enumerate() {
            let limits = &joint.limits;
            let (command, measured) = (command[i], measured[i]);
            let at_once = motion.stopping_at_once();
            let overshoots = |motion: JointMotion, velocity: f64, needed: f64, tolerance: f64| {
                velocity != 0.0 && needed > distance(motion, i, limits, velocity) + tolerance
            };
            // The offset of an envelope counts for the command alone, because a measured velocity at rest is noise.
            let own = stopping_deceleration(limits);
            let [to_stop, stopping] = [stop_distance(limits, command, own), braking_distance(measured, own)];
            if overshoots(motion, command, to_stop, NOISE_TOLERANCE)
                || overshoots(at_once, measured, stopping, SPEED_NOISE_TOLERANCE)
            {
                self.too_fast.push(i);
            }
        }
        self.time_s = shortest_time(robot, motion, command, period, None);
    }

    /// Lets all joints stop together after the hold, unless one has too little way for that. To be called after [`update`](Self::update),
    /// with its arguments; `kind`: `None` for a controller that keeps no limits.
    pub fn stop_together(
        &mut self,
        robot: &RobotModel,
        kind: Option<LimitKind>,
        motion: JointMotion,
        command: &[f64],
        period: f64,
    ) {
        let times = robot.joints().iter().zip(command).map(|(joint, u)| u.abs() / braking_deceleration(&joint.limits));
        let stop_time = times.fold(0.0, f64::max);
        if !STOP_TIMES.contains(&stop_time) {
            return;
        }
        let is_ranged = kind.is_some_and(LimitKind::includes_position);
        let time =
            if is_ranged { shortest_time(robot, motion, command, period, Some(stop_time)) } else { f64::INFINITY };
        if time >= spare_time(2.0 * period) {
            (self.time_s, self.stop_time_s) = (time, Some(stop_time));
        }
    }
}

/// Returns the smallest hold time of all joints, s; infinite at rest. `stop_time`: t_s, s; `None`: each joint brakes at a, and a time below S
/// may count as noise.
fn shortest_time(robot: &RobotModel, motion: JointMotion, command: &[f64], period: f64, stop_time: Option<f64>) -> f64 {
    let moving = robot.joints().iter().zip(command).enumerate().filter(|(_, (_, u))| **u != 0.0);
    let times = moving.map(|(i, (joint, &u))| {
        let limits = &joint.limits;
        let deceleration = stopping_deceleration(limits).min(ramp_deceleration(limits, u, stop_time));
        let (distance, last) = (distance(motion, i, limits, u), motion.last_command[i] * u.signum());
        let [exact, forgiving] = hold_times(limits, deceleration, distance, (u.abs(), last), period);
        if stop_time.is_some() { exact } else { exact.max(forgiving.min(spare_time(period))).max(0.0) }
    });
    times.fold(f64::INFINITY, f64::min)
}

/// Returns the distance of joint `i` to the end of the range to which it moves, rad or m.
fn distance(motion: JointMotion, i: usize, limits: &JointLimits, velocity: f64) -> f64 {
    let (to_lower, to_upper) = motion.distances(i, limits);
    if velocity > 0.0 { to_upper } else { to_lower }
}

/// Returns v²/2b + |v| o/D, the distance that a joint with the velocity v must have to stop with the deceleration b.
fn stop_distance(limits: &JointLimits, v: f64, deceleration: f64) -> f64 {
    braking_distance(v, deceleration) + v.abs() * limits.envelope.reaction_time()
}

/// Returns v²/2b.
fn braking_distance(v: f64, deceleration: f64) -> f64 {
    v * v / 2.0 / deceleration
}

/// Returns t of the module for a joint with the speed v > 0 towards a limit at `distance`, which stops with a deceleration, and the same if δ
/// of the distance is noise; `last`: v⁻.
fn hold_times(limits: &JointLimits, deceleration: f64, distance: f64, (v, last): (f64, f64), period: f64) -> [f64; 2] {
    let braking = stop_distance(limits, v, deceleration);
    let delayed = (last - v).max(0.0) * spare_time(period);
    [POSITION_TOLERANCE, NOISE_TOLERANCE].map(|tolerance| (distance + tolerance - delayed - braking) / v)
}

#[cfg(test)]
mod tests {
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
        let times = |distance, v, last| hold_times(&LIMITS, 8.0, distance, (v, last), 0.01);
        let close = |given: f64, expected: f64| assert!((given - expected).abs() < 1e-5, "{given} {expected}");
        close(times(0.1, 1.0, 0.0)[0], 0.1 - 1.0 / 16.0);
        close(times(0.1, 1.0, 1.5)[0], 0.1 - 1.0 / 16.0 - 0.005);
        assert!(times(0.05, 1.0, 0.0)[0] < 0.0);
        close(times(1.0 / 16.0, 1.0, 0.0)[1], NOISE_TOLERANCE);
        assert_eq!(times(f64::INFINITY, 1.0, 0.0), [f64::INFINITY; 2]);
        let free = JointLimits { acceleration: f64::INFINITY, velocity: f64::INFINITY, ..LIMITS };
        close(hold_times(&free, f64::INFINITY, 0.1, (2.0, 0.0), 0.01)[0], 0.05);
    }

    /// A measured position may be noisy: beyond the point where braking must start, the time is S at most.
    #[test]
    fn noise_of_the_position_shortens_a_hold_to_the_spare_time_at_most() {
        let deceleration = braking_deceleration(&revprio_robot::built_in()[0].joints()[0].limits);
        let fastest = (2e-3 * deceleration).sqrt();
        let time_at = |share: f64| near_the_limit(LimitKind::PositionVelocity, share * fastest, 0.0).time_s;
        let way_in = |share: f64, noise: f64| (1e-3 * (1.0 - share * share) + noise) / (share * fastest);
        assert!((time_at(1.0) - way_in(1.0, NOISE_TOLERANCE)).abs() < 1e-12);
        assert!(way_in(0.6, 0.0) < spare_time(0.001) && way_in(0.6, NOISE_TOLERANCE) > spare_time(0.001));
        assert_eq!(time_at(0.6), spare_time(0.001));
        assert!((time_at(0.5) - way_in(0.5, POSITION_TOLERANCE)).abs() < 1e-12);
    }

    #[test]
    fn joints_stop_together_where_each_has_the_way_for_it() {
        let robot = &revprio_robot::built_in()[0];
        let middle = |joint: &revprio_robot::Joint| 0.5 * (joint.limits.lower + joint.limits.upper);
        let position: Vec<f64> = robot.joints().iter().map(middle).collect();
        let mut last = vec![0.0; robot.joint_count()];
        (last[0], last[2]) = (1.0, -0.1);
        let slowest = 1.0 / braking_deceleration(&robot.joints()[0].limits);
        let hold_at = |distance: f64, kind: Option<LimitKind>| {
            let mut position = position.clone();
            position[2] = robot.joints()[2].limits.lower + distance;
            let motion =
                JointMotion { position: &position, distance_to_rest: &[], last_command: &last, last_acceleration: &[] };
            let mut hold = Hold::default();
            if let Some(kind) = kind {
                hold.update(robot, kind, motion, &last, &last, 0.001);
            }
            hold.stop_together(robot, kind, motion, &last, 0.001);
            (hold.time_s, hold.stop_time_s)
        };
        let ranged = Some(LimitKind::PositionVelocity);
        let (time, stop) = hold_at(1.0, ranged);
        assert_eq!(stop, Some(slowest));
        assert!(time > 1.0, "{time}");
        // 0.1 rad/s · (t + t_s/2)
        let (time, stop) = hold_at(0.1 * (0.02 + 0.5 * slowest), ranged);
        assert!(stop.is_some() && (time - 0.02).abs() < 1e-5, "{time} {stop:?}");
        assert_eq!(hold_at(0.1 * (0.009 + 0.5 * slowest), ranged).1, None);
        for kind in [None, Some(LimitKind::Velocity)] {
            assert_eq!(hold_at(0.0, kind), (f64::INFINITY, Some(slowest)));
        }
    }
}

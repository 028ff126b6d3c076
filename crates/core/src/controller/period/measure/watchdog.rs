//! The commands that the watchdog of an arm sends while no answer comes, and where they lead the arm.
//!
//! A joint has the command u when its last answer comes. The watchdog holds u while it is valid, then it lowers |u| with the
//! deceleration of the joint to 0, or with one that lets all joints stop together. So the commands are two [`Ramp`]s, then zeros. The velocity behind a first-order lag with
//! v ← u + (v − u) r, r = e^(−T/L), follows the commands f, f + s, f + 2 s, … with
//!
//! vᵢ = v₀ + (f − v₀) (1 − rⁱ) + s (i − (1 − rⁱ)/(1 − r)).
//!
//! The commands that were on their way act first, one by one. So the time for all this does not depend on the
//! number of periods.

use revprio_robot::{JointLimits, RobotModel};

use crate::controller::state::AnsweredState;
use crate::limits::{Drive, DriveState, ramp_deceleration};
use crate::linalg::Vector;

/// Tolerance of the age of a command, s, because sums of periods are not exact.
const ROUNDING_S: f64 = 1e-9;

/// The watchdog of an arm.
pub(super) struct Watchdog<'a> {
    pub robot: &'a RobotModel,
    /// The command of the last answer, n, rad/s or m/s.
    pub command: &'a Vector,
    pub answered: &'a AnsweredState,
    pub drive: Drive,
    /// T, s.
    pub period: f64,
}

/// What an arm did while no answer came.
pub(super) struct Unanswered {
    pub drive: DriveState,
    /// The last command of the watchdog, n, rad/s or m/s.
    pub command: Vector,
    /// How far the position of rest p moved, n, rad or m.
    pub rest_moved: Vector,
}

impl Watchdog<'_> {
    /// Returns what the arm does in `periods` periods without an answer; `before`: its drive before them.
    pub fn follow(&self, before: &DriveState, periods: usize) -> Unanswered {
        let mut after = Unanswered {
            drive: before.clone(),
            command: self.command.clone(),
            rest_moved: Vector::zeros(self.command.len()),
        };
        for (i, joint) in self.robot.joints().iter().enumerate() {
            let sent = SentCommands::new(self.command[i], &joint.limits, self.answered, self.period);
            after.command[i] = sent.at(periods as f64);
            after.rest_moved[i] = self.period * sent.ramps(periods as f64).map(|ramp| ramp.sum()).sum::<f64>();
            after.drive.velocity[i] = self.velocity_after(before, i, &sent, periods);
            for (k, on_its_way) in after.drive.pending.iter_mut().enumerate() {
                on_its_way[i] = match before.pending.get(k + periods) {
                    Some(earlier) => earlier[i],
                    None => sent.at((k + periods + 1 - before.pending.len()) as f64),
                };
            }
        }
        after
    }

    /// Returns whether the ramp begins within some periods without an answer.
    pub fn brakes_within(&self, periods: usize) -> bool {
        (periods as f64 + 1.0) * self.period > self.answered.valid_for_ms as f64 / 1e3 + ROUNDING_S
    }

    /// Returns the velocity of a joint behind the drive after some periods, rad/s or m/s.
    fn velocity_after(&self, before: &DriveState, joint: usize, sent: &SentCommands, periods: usize) -> f64 {
        let rate = self.period / self.drive.lag_s;
        let remaining = (-rate).exp();
        let arriving = before.pending.iter().take(periods).map(|command| command[joint]);
        let velocity = arriving.fold(before.velocity[joint], |v, u| u + (v - u) * remaining);
        let ramps = sent.ramps(periods.saturating_sub(before.pending.len()) as f64);
        ramps.fold(velocity, |velocity, ramp| ramp.velocity_after(velocity, rate))
    }
}

/// Commands that change evenly: f, f + s, f + 2 s, …
#[derive(Debug, Clone, Copy)]
struct Ramp {
    /// f, rad/s or m/s.
    first: f64,
    /// s, rad/s or m/s per period.
    slope: f64,
    /// How many there are.
    periods: f64,
}

impl Ramp {
    /// Returns the sum of all commands, rad/s or m/s.
    fn sum(&self) -> f64 {
        self.periods * (self.first + 0.5 * self.slope * (self.periods - 1.0))
    }

    /// Returns the velocity behind a lag after these commands; `rate`: T/L.
    fn velocity_after(&self, velocity: f64, rate: f64) -> f64 {
        let closed = |periods: f64| -(-rate * periods).exp_m1();
        let (one, all) = (closed(1.0), closed(self.periods));
        // A lag beyond all periods: nothing moves.
        if one == 0.0 {
            return velocity;
        }
        velocity + (self.first - velocity) * all + self.slope * (self.periods - all / one)
    }
}

/// The commands that a watchdog sends to one joint. Their numbers count the periods after the state; that of the answer is 0.
struct SentCommands {
    /// u, the command of the answer, rad/s or m/s.
    full: f64,
    /// By how much a period of the ramp lowers |u|, rad/s or m/s.
    decrease: f64,
    /// How long the answer is valid, periods.
    valid: f64,
    /// How many commands are u.
    held: f64,
}

impl SentCommands {
    fn new(full: f64, limits: &JointLimits, answered: &AnsweredState, period: f64) -> Self {
        let valid = answered.valid_for_ms as f64 / 1e3 / period;
        let held = (valid + ROUNDING_S / period - 1.0).floor().max(0.0);
        let decrease = ramp_deceleration(limits, full, answered.stop_time_s) * period;
        Self { full, decrease, valid, held }
    }

    /// Returns a command, from number 1 on: that of the ramp at the end of its period.
    fn at(&self, number: f64) -> f64 {
        if number <= self.held {
            return self.full;
        }
        let late = number + 1.0 - self.valid;
        (self.full.abs() - self.decrease * late).max(0.0).copysign(self.full)
    }

    /// Returns the commands from number 1 on, `count` of them: those that are held, the ramp, and zeros.
    fn ramps(&self, count: f64) -> impl Iterator<Item = Ramp> {
        let held = self.held.min(count);
        let last_of_ramp = (self.valid + self.full.abs() / self.decrease - 1.0).ceil() - 1.0;
        let falling = (last_of_ramp - held).max(0.0).min(count - held);
        let ramps = [
            Ramp { first: self.full, slope: 0.0, periods: held },
            Ramp { first: self.at(held + 1.0), slope: self.decrease.copysign(-self.full), periods: falling },
            Ramp { first: 0.0, slope: 0.0, periods: count - held - falling },
        ];
        ramps.into_iter().filter(|ramp| ramp.periods > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use revprio_robot::built_in;

    use super::*;
    use crate::limits::braking_deceleration;

    const T: f64 = 0.004;

    /// Follows the watchdog period by period, as the arm does.
    fn period_by_period(watchdog: &Watchdog, before: &DriveState, periods: usize) -> Unanswered {
        let mut after = Unanswered {
            drive: before.clone(),
            command: watchdog.command.clone(),
            rest_moved: Vector::zeros(watchdog.command.len()),
        };
        for k in 1..=periods {
            let late_s = (k + 1) as f64 * T - watchdog.answered.valid_for_ms as f64 / 1e3;
            if late_s > ROUNDING_S {
                for (i, joint) in watchdog.robot.joints().iter().enumerate() {
                    let full = watchdog.command[i];
                    let decrease = match watchdog.answered.stop_time_s {
                        Some(time) => full.abs() * (late_s / time).min(1.0),
                        None => braking_deceleration(&joint.limits) * late_s,
                    };
                    after.command[i] = (full.abs() - decrease).max(0.0).copysign(full);
                }
            }
            after.drive.advance(watchdog.drive, &after.command, T);
            after.rest_moved.axpy(T, &after.command, 1.0);
        }
        after
    }

    proptest! {
        #[test]
        fn the_closed_form_is_that_of_single_periods(
            lag_s in prop_oneof![Just(0.0), 1e-4..0.5_f64, Just(1e300)],
            delay_periods in 0_usize..8,
            valid_for_ms in 0..500_u64,
            stop_time_s in prop::option::of(prop_oneof![1e-9..1e-3, 1e-3..2.0_f64, Just(1e300)]),
            periods in prop_oneof![1..20_usize, 1..2000_usize],
            robot in 0..built_in().len(),
            speeds in prop::collection::vec(prop_oneof![Just(0.0), -2.0..2.0_f64], 80),
        ) {
            let robot = &built_in()[robot];
            let n = robot.joint_count();
            let vector = |which: usize| Vector::from_fn(n, |i, _| speeds[(7 * which + i) % speeds.len()]);
            let drive = Drive { lag_s, delay_periods };
            let before = DriveState { velocity: vector(9), pending: (0..delay_periods).map(vector).collect() };
            let answered = AnsweredState { time_s: 0.0, joint_position: Vector::zeros(n), way: None, valid_for_ms, stop_time_s };
            let command = vector(10);
            let watchdog = Watchdog { robot, command: &command, answered: &answered, drive, period: T };
            let (expected, found) = (period_by_period(&watchdog, &before, periods), watchdog.follow(&before, periods));
            // Written so that NaN differs.
            let differ = |a: &Vector, b: &Vector| !a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10);
            prop_assert!(!differ(&expected.command, &found.command));
            prop_assert!(!differ(&expected.rest_moved, &found.rest_moved));
            prop_assert!(!differ(&expected.drive.velocity, &found.drive.velocity));
            let mut pending = expected.drive.pending.iter().zip(&found.drive.pending);
            prop_assert!(!pending.any(|(a, b)| differ(a, b)), "{:?}, not {:?}", found.drive, expected.drive);
        }
    }
    /// A loop over the periods would take minutes.
    #[test]
    fn a_command_that_stays_valid_for_a_billion_periods_is_followed() {
        let robot = &built_in()[0];
        let command = Vector::from_element(robot.joint_count(), 0.5);
        let (drive, joint_position) = (Drive { lag_s: 0.05, delay_periods: 64 }, Vector::zeros(command.len()));
        let before = DriveState { velocity: Vector::zeros(command.len()), pending: vec![joint_position.clone(); 64] };
        let answered =
            AnsweredState { time_s: 0.0, joint_position, way: None, valid_for_ms: u64::MAX, stop_time_s: None };
        let watchdog = Watchdog { robot, command: &command, answered: &answered, drive, period: T };
        let after = watchdog.follow(&before, 1_000_000_000);
        assert_eq!((&after.command, &after.drive.velocity), (&command, &command));
        assert!(after.drive.pending.iter().all(|on_its_way| *on_its_way == command));
        assert!((after.rest_moved[0] / (0.5e9 * T) - 1.0).abs() < 1e-12);
    }
}

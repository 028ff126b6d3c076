//! States that come late: the arm holds its command and brakes, as its watchdog says, and the controller knows it.

use std::iter;
use std::sync::Arc;

use revprio_core::controller::{
    AnsweredState, Command, Controller, ControllerConfig, Limits, Measurement, Memory, MemoryError, StepError, Stepper,
    TaskConfig,
};
use revprio_core::law::ContactSettings;
use revprio_core::limits::{Drive, LimitKind, braking_deceleration, ramp_deceleration};
use revprio_core::linalg::Vector;
use revprio_robot::kinematics::Axis;
use revprio_robot::{Joint, JointLimits, RobotModel, built_in};

use super::arms::{
    Loop, NOMINAL, PERIOD, Random, config, contact, controller, joint_rows, measurement, missing_distance, position,
    sawyer, step, task, with_envelopes, with_free_joints, with_jerk,
};
use super::drives::{LaggingArm, OVERSHOOT};
use super::hold::middle;

/// Largest distance outside the range that counts as inside, rad or m.
const TOLERANCE: f64 = 1e-6;

/// δ of docs/limits.md: the distance outside the range that limits permit where noise could explain it, rad or m.
const NOISE_MARGIN: f64 = 5e-4;

/// The drives of the runs.
const DRIVES: [Drive; 5] = [
    Drive::IDEAL,
    Drive { lag_s: 0.0, delay_periods: 2 },
    Drive { lag_s: 0.02, delay_periods: 1 },
    Drive::CONSERVATIVE,
    Drive { lag_s: 0.06, delay_periods: 3 },
];

/// Which states of a run come late.
#[derive(Debug, Clone, Copy)]
struct Lateness {
    /// Percentage of states that are late.
    percent: u64,
    /// Most extra periods.
    most: usize,
    /// Whether the program of the arm dies now and then, for up to 1 s.
    kills: bool,
}

impl Lateness {
    /// Returns how many periods pass until the next state.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
    fn periods(self, period: f64, random: &mut Random) -> u64 {
        let is_late = (random.below(100) as u64) < self.percent;
        let late = if is_late { 1 + random.below(self.most) } else { 0 };
        let dies = self.kills && random.below((0.5 / period) as usize) == 0;
        let killed = if dies { random.below((1.0 / period) as usize) } else { 0 };
        (1 + late + killed) as u64
    }
}

/// A client of a controller: it sends the commands of an arm, and those of its watchdog.
struct Client {
    arm: LaggingArm,
    sent: Vec<f64>,
    /// Whether the commands return to the answers, after a ramp.
    resumes: bool,
}

impl Client {
    /// Sends a command for some periods, as docs/limits.md says.
    fn hold(
        &mut self,
        robot: &RobotModel,
        command: &Command,
        periods: u64,
        period: f64,
        mut each: impl FnMut(&LaggingArm, &[f64]),
    ) {
        let valid = command.hold.valid_for_ms(100) as f64 / 1e3;
        for k in 1..=periods {
            // As the watchdogs of the clients do: what the ramp has at the end of the period.
            let late = k as f64 * period - valid;
            self.resumes |= late > 1e-9;
            let mut arrived = true;
            for (joint, (sent, answer)) in
                robot.joints().iter().zip(self.sent.iter_mut().zip(command.resolution.joint_velocity.iter()))
            {
                let deceleration = braking_deceleration(&joint.limits);
                let braking = ramp_deceleration(&joint.limits, *answer, command.hold.stop_time_s);
                let ramp = (answer.abs() - (braking * late.max(0.0)).min(f64::MAX)).max(0.0).copysign(*answer);
                let reach = if self.resumes { deceleration * period } else { f64::INFINITY };
                *sent = ramp.max(*sent - reach).min(*sent + reach);
                arrived &= (*sent - ramp).abs() <= 1e-9;
            }
            self.resumes &= !arrived;
            self.arm.follow(&self.sent, period);
            each(&self.arm, &self.sent);
        }
    }
}

/// Returns controllers that drive all joints beyond random ends of their ranges.
fn controllers(robot: &Arc<RobotModel>, run: &Run, random: &mut Random) -> Vec<Stepper> {
    let (drive, period) = (run.stated, run.period);
    let beyond = |joint: &Joint, upper: bool| {
        let (lower, upper_end) = (joint.limits.lower.max(-3.0), joint.limits.upper.min(3.0));
        if upper { upper_end + 1.0 } else { lower - 1.0 }
    };
    (0..12)
        .map(|_| {
            let target: Vec<f64> = robot.joints().iter().map(|joint| beyond(joint, random.below(2) == 0)).collect();
            let gain = [2.0, 10.0, 50.0][random.below(if period < 0.01 { 3 } else { 2 })];
            let posture = TaskConfig { rows: joint_rows(&target), ..task(&[Axis::X], position(target.len(), gain)) };
            let limits = Limits::Robot(run.limits);
            let yields = run.touches.then(|| task(&[Axis::Z], contact(&[-5.0], ContactSettings::default())));
            let config = config(robot, iter::once(posture).chain(yields).collect());
            Stepper::new(controller(ControllerConfig { limits, drive, period_s: period, ..config })).unwrap()
        })
        .collect()
}

/// A run of an arm.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_excessive_bools, reason = "each is a property of a run by itself")]
struct Run {
    period: f64,
    /// For how long the joints move to one target, s.
    targets_s: f64,
    /// The drive of the arm.
    drive: Drive,
    /// The drive that the controller knows.
    stated: Drive,
    lateness: Lateness,
    clock: Clock,
    /// Whether the memory knows when the last state was measured.
    knows_times: bool,
    limits: LimitKind,
    /// Whether some joints state no acceleration limit.
    free_joints: bool,
    /// Whether all joints have velocity envelopes; those of `fr3` do.
    envelopes: bool,
    /// Whether the lowest task may touch, so that a watchdog lets all joints stop together where that presses less.
    touches: bool,
}

/// The clock of the states.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Clock {
    Exact,
    /// One state in 200 jumps by up to 1000 s, in both directions.
    Jumps,
    /// Each time is wrong by up to 0.6 periods.
    Jitters,
}

/// What a run shows.
#[derive(Debug, Clone, Copy)]
struct Findings {
    /// Largest distance outside the range, or missing for the velocity envelope of the measured motion, rad.
    outside: f64,
    /// Largest change of a command from period to period, in multiples of A T.
    change: f64,
    /// Answers after which all joints stop together.
    together: u64,
}

impl Run {
    /// Runs a robot for 4 s.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small positive numbers")]
    fn on(self, robot: &Arc<RobotModel>, seed: u64) -> Findings {
        let Self { period, drive, lateness, .. } = self;
        let mut random = Random(seed);
        let mut steppers = controllers(robot, &self, &mut random);
        let arm = LaggingArm::at_rest(&middle(robot), drive, 0.0, seed);
        let mut client = Client { arm, sent: vec![0.0; robot.joint_count()], resumes: false };
        let (mut memory, mut passed, mut offset) = (None::<Memory>, 0_u64, 0.0);
        let mut found = Findings { outside: f64::NEG_INFINITY, change: 0.0, together: 0 };
        while (passed as f64) * period < 4.0 {
            let elapsed = passed as f64 * period;
            let current = (elapsed / self.targets_s) as usize % steppers.len();
            match self.clock {
                Clock::Jumps if random.below(200) == 0 => offset = 1e3 * random.signed(),
                Clock::Jitters => offset = 0.6 * period * random.signed(),
                _ => {}
            }
            if let Some(memory) = memory.as_mut().filter(|_| !self.knows_times) {
                memory.answered = None;
            }
            let command = steppers[current].step(&mut memory, &client.arm.measure(elapsed + offset)).unwrap();
            found.together += u64::from(command.hold.stop_time_s.is_some());
            let periods = lateness.periods(period, &mut random);
            let mut last = client.sent.clone();
            client.hold(robot, command, periods, period, |arm, sent| {
                for (i, joint) in robot.joints().iter().enumerate() {
                    let (limits, q) = (&joint.limits, arm.q[i]);
                    let [lowest, highest] = limits.resting_range();
                    let missing = missing_distance(limits, q, arm.velocity[i]);
                    found.outside = found.outside.max((q - highest).max(lowest - q)).max(missing);
                    let change = (sent[i] - last[i]).abs() / (braking_deceleration(limits) * period);
                    found.change = found.change.max(change);
                }
                last.copy_from_slice(sent);
            });
            passed += periods;
        }
        found
    }

    /// Returns the worst findings of all built-in robots.
    fn worst(self, seed: u64) -> Findings {
        let arm = |robot: &Arc<RobotModel>| {
            let robot = if self.free_joints { Arc::new(with_free_joints(robot)) } else { Arc::clone(robot) };
            if self.envelopes { Arc::new(with_envelopes(&robot)) } else { robot }
        };
        let runs = built_in().iter().map(|robot| self.on(&arm(robot), seed));
        let worst = |a: Findings, b: Findings| Findings {
            outside: a.outside.max(b.outside),
            change: a.change.max(b.change),
            together: a.together + b.together,
        };
        runs.reduce(worst).unwrap()
    }
}

/// An ideal arm whose states come in time, with all limits.
const RUN: Run = Run {
    period: 0.01,
    targets_s: 0.4,
    drive: Drive::IDEAL,
    stated: Drive::IDEAL,
    lateness: NEVER,
    clock: Clock::Exact,
    knows_times: true,
    limits: LimitKind::PositionVelocityAcceleration,
    free_joints: false,
    envelopes: false,
    touches: false,
};

const NEVER: Lateness = Lateness { percent: 0, most: 1, kills: false };

#[test]
fn late_states_lead_no_joint_out_of_its_range_behind_a_drive() {
    let (mut seed, mut outside, mut change) = (0, [f64::NEG_INFINITY; 2], 0.0_f64);
    for period in [0.001, 0.004, 0.01] {
        for (percent, most, kills) in [(0, 1, true), (3, 1, false), (10, 1, true), (30, 3, true)] {
            let lateness = Lateness { percent, most, kills };
            for drive in DRIVES {
                seed += 1;
                for (knows_times, outside) in [true, false].into_iter().zip(&mut outside) {
                    let run = Run { period, drive, stated: drive, lateness, clock: Clock::Exact, knows_times, ..RUN };
                    let found = run.worst(seed);
                    *outside = outside.max(found.outside);
                    change = if knows_times { change.max(found.change) } else { change };
                }
            }
        }
    }
    println!("largest change of a command {change} A T");
    println!("outside {:.1e} rad, {:.1e} rad if the memory does not know the times", outside[0], outside[1]);
    assert!(outside[0] < NOISE_MARGIN, "{outside:?}");
    assert!(change < 1.0 + 1e-9, "{change} A T");
    assert!(outside[1] > 0.01, "the runs do not show what late states do: {outside:?}");
}

/// All joints stop together where that presses less, as long as each has the way for it.
#[test]
fn late_states_lead_no_joint_out_of_its_range_if_all_stop_together() {
    let (mut seed, mut outside, mut change, mut together) = (100, f64::NEG_INFINITY, 0.0_f64, 0);
    let kinds = [LimitKind::PositionVelocityAcceleration, LimitKind::PositionVelocity];
    for (limits, envelopes) in kinds.into_iter().flat_map(|kind| [(kind, false), (kind, true)]) {
        for (period, (percent, most, kills)) in [0.001, 0.004, 0.01]
            .into_iter()
            .flat_map(|period| [(3, 1, false), (30, 3, true)].map(|late| (period, late)))
        {
            let lateness = Lateness { percent, most, kills };
            for drive in DRIVES {
                seed += 1;
                let run = Run { period, drive, stated: drive, lateness, limits, envelopes, touches: true, ..RUN };
                let found = run.worst(seed);
                outside = outside.max(found.outside);
                together += found.together;
                let keeps_acceleration = limits == LimitKind::PositionVelocityAcceleration;
                change = if keeps_acceleration { change.max(found.change) } else { change };
            }
        }
    }
    println!(
        "all joints stop together after {together} answers: outside {outside:.1e} rad, largest change {change} A T"
    );
    assert!(together > 10_000, "{together}");
    assert!(outside < 2.0 * NOISE_MARGIN, "{outside:e}");
    assert!(change < 1.0 + 1e-9, "{change} A T");
}

/// `valid_for_ms` counts whole milliseconds, and periods need not be some. Also if a client manages every second state only.
#[test]
fn late_states_lead_no_joint_out_of_its_range_if_periods_are_no_whole_milliseconds() {
    let (mut seed, mut outside, mut change) = (0, f64::NEG_INFINITY, 0.0_f64);
    for period in [0.0015, 0.0025, 1.0 / 240.0, 1.0 / 120.0, 0.0125] {
        for (percent, most) in [(100, 1), (30, 3), (10, 1)] {
            let lateness = Lateness { percent, most, kills: true };
            for drive in DRIVES {
                seed += 1;
                let found = Run { period, drive, stated: drive, lateness, ..RUN }.worst(seed);
                outside = outside.max(found.outside);
                change = change.max(found.change);
            }
        }
    }
    println!("periods of fractions of milliseconds: outside {outside:.1e} rad, largest change {change} A T");
    assert!(outside < 2.0 * NOISE_MARGIN, "{outside:e}");
    assert!(change < 2.0, "{change} A T");
}

/// Strong joints with narrow ranges turn back while states are missing. Positions then fit one period nearly as well as several.
#[test]
fn late_states_of_joints_that_turn_back_are_not_taken_for_a_jump_of_the_clock() {
    let narrow = |joint: &Joint| {
        let middle = 0.5 * (joint.limits.lower + joint.limits.upper);
        let limits =
            JointLimits { lower: middle - 0.1, upper: middle + 0.1, velocity: 2.0, acceleration: 50.0, ..joint.limits };
        Joint { limits, ..joint.clone() }
    };
    let joint = narrow(&built_in()[1].joints()[0]);
    let robot = Arc::new(RobotModel::new("narrow", "", vec![joint], *built_in()[1].tool()).unwrap());
    let (mut seed, mut outside) = (0, [f64::NEG_INFINITY; 2]);
    for (limits, outside) in
        [LimitKind::PositionVelocityAcceleration, LimitKind::PositionVelocity].into_iter().zip(&mut outside)
    {
        for drive in DRIVES {
            for _ in 0..20 {
                seed += 1;
                let lateness = Lateness { percent: 30, most: 4, kills: false };
                let run = Run { period: 0.02, targets_s: 0.1, drive, stated: drive, lateness, limits, ..RUN };
                *outside = outside.max(run.on(&robot, seed).outside);
            }
        }
    }
    println!("joints that turn back: outside {outside:?} rad");
    assert!(outside.iter().all(|outside| *outside < 2.0 * NOISE_MARGIN), "{outside:?}");
}

/// Joints that may jump: the watchdog limits the change to the first answer after a ramp, and the answer keeps it.
#[test]
fn late_states_lead_no_joint_that_may_jump_out_of_its_range() {
    let (mut seed, mut worst) = (0, f64::NEG_INFINITY);
    for (limits, free_joints) in [
        (LimitKind::PositionVelocityAcceleration, true),
        (LimitKind::PositionVelocity, false),
        (LimitKind::PositionVelocity, true),
    ] {
        for period in [0.001, 0.004, 0.01] {
            for (percent, most, kills) in [(3, 1, false), (10, 1, true), (30, 3, true), (30, 30, true)] {
                let lateness = Lateness { percent, most, kills };
                for drive in DRIVES {
                    seed += 1;
                    let run = Run { period, drive, stated: drive, lateness, limits, free_joints, ..RUN };
                    let outside = run.worst(seed).outside;
                    worst = worst.max(outside);
                }
            }
        }
    }
    println!("joints that may jump: outside {worst:.1e} rad");
    // The box permits δ, and so does a hold.
    assert!(worst < 2.0 * NOISE_MARGIN, "{worst:e}");
}

/// Velocity envelopes hold for the measured motion, as if the ends were 2 δ further away.
#[test]
fn late_states_lead_no_joint_out_of_its_velocity_envelope() {
    let (mut seed, mut worst) = (0, f64::NEG_INFINITY);
    for (limits, free_joints) in [
        (LimitKind::PositionVelocityAcceleration, false),
        (LimitKind::PositionVelocityAcceleration, true),
        (LimitKind::PositionVelocity, false),
    ] {
        for (period, lateness) in [0.001, 0.004, 0.01].into_iter().flat_map(|period| {
            [NEVER, Lateness { percent: 10, most: 1, kills: true }, Lateness { percent: 30, most: 30, kills: true }]
                .map(|lateness| (period, lateness))
        }) {
            for drive in DRIVES {
                seed += 1;
                let run = Run { period, drive, stated: drive, lateness, limits, free_joints, envelopes: true, ..RUN };
                worst = worst.max(run.worst(seed).outside);
            }
        }
    }
    println!("with envelopes: outside {worst:.1e} rad");
    assert!(worst < 2.0 * NOISE_MARGIN, "{worst:e}");
}

/// The same with drives up to twice as slow and twice as fast as stated.
#[test]
fn late_states_of_misstated_drives_lead_no_joint_further_than_the_drive_lets_it() {
    let fastest = built_in().iter().flat_map(|robot| robot.joints()).map(|joint| joint.limits.velocity);
    let fastest = fastest.fold(0.0, f64::max);
    let all = LimitKind::PositionVelocityAcceleration;
    let mut seed = 0;
    for (limits, free_joints) in [(all, false), (all, true), (LimitKind::PositionVelocity, false)] {
        for factor in [0.0, 0.5, 2.0] {
            let late = Lateness { percent: 10, most: 3, kills: true };
            for (lateness, name, share) in [(NEVER, "in time", 1.0), (late, "late", 2.0)] {
                let (mut worst, mut further) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
                for (period, stated) in
                    [0.001, 0.004, 0.01].into_iter().flat_map(|period| DRIVES.map(|drive| (period, drive)))
                {
                    seed += 1;
                    let drive = misstated(stated, factor);
                    let run = Run { period, drive, stated, lateness, limits, free_joints, ..RUN };
                    let outside = run.worst(seed).outside;
                    let slower = (drive.time_to_rest(period) - stated.time_to_rest(period)).max(0.0);
                    (worst, further) = (worst.max(outside), further.max(outside - share * fastest * slower));
                }
                println!(
                    "{limits:?}, free joints: {free_joints}, {factor} times as slow, {name}: {worst:.1e} rad outside"
                );
                assert!(further < 2.0 * NOISE_MARGIN, "{further:e}");
            }
        }
    }
}

/// Returns a drive that is slower by a factor.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small numbers")]
fn misstated(stated: Drive, factor: f64) -> Drive {
    let delay_periods = (stated.delay_periods as f64 * factor) as usize;
    Drive { lag_s: stated.lag_s * factor, delay_periods }
}

/// The change of a command is that of the acceleration limit, so the arm does not notice where the clock jumps. A time that
/// is wrong by more than half a period counts as a late state.
#[test]
fn a_clock_that_jumps_or_jitters_leads_no_joint_far_out_of_its_range() {
    let clocks = [(Clock::Jumps, TOLERANCE), (Clock::Jitters, OVERSHOOT)];
    for ((clock, tolerance), seed) in clocks.into_iter().flat_map(|clock| [(clock, 1), (clock, 2)]) {
        for period in [0.001, 0.01] {
            for drive in [Drive::IDEAL, Drive::CONSERVATIVE] {
                let run = Run {
                    period,
                    drive,
                    stated: Drive::CONSERVATIVE,
                    lateness: NEVER,
                    clock,
                    knows_times: true,
                    ..RUN
                };
                let Findings { outside, change, .. } = run.worst(seed);
                println!("T {period} s, {drive:?}, {clock:?}: {outside:.1e} rad outside");
                assert!(outside < tolerance && change < 1.0 + 1e-6, "{run:?}: {outside:e} rad, {change} A T");
            }
        }
    }
}

#[test]
fn late_states_of_a_faster_drive_than_stated_lead_no_joint_out_of_its_range() {
    let lateness = Lateness { percent: 10, most: 3, kills: true };
    for (drive, period) in DRIVES[..3].iter().flat_map(|&drive| [(drive, 0.001), (drive, 0.01)]) {
        let run =
            Run { period, drive, stated: Drive::CONSERVATIVE, lateness, clock: Clock::Exact, knows_times: true, ..RUN };
        let Findings { outside, .. } = run.worst(3);
        assert!(outside < TOLERANCE, "{run:?}: {outside:e} rad");
    }
}

/// Returns a controller of Sawyer with jerk limits that moves away, and its memory while it accelerates.
fn accelerating() -> (Controller, Memory, Vec<f64>, f64) {
    let robot = Arc::new(with_jerk(&sawyer(), 0.05));
    let config = ControllerConfig {
        limits: Limits::Robot(LimitKind::PositionVelocityAcceleration),
        ..config(&robot, vec![TaskConfig { rows: joint_rows(&[0.0; 7]), ..task(&[Axis::X], position(7, 5.0)) }])
    };
    let (controller, mut arm) = (controller(config), Loop::at_rest(&NOMINAL));
    (0..10).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let before = arm.memory.as_ref().unwrap().answered.clone().unwrap();
    (controller, arm.memory.unwrap(), arm.q, before.time_s)
}

/// Returns the memory of a state that comes n periods after the last one, and the command before.
fn after(periods: f64) -> (Memory, Memory) {
    let (controller, before, mut q, time_s) = accelerating();
    let held = (periods - 1.0).min(100.0) * PERIOD;
    q.iter_mut().zip(before.last_command.iter()).for_each(|(q, v)| *q += v * held);
    let mut memory = Some(before.clone());
    step(&controller, &mut memory, &Measurement { time_s: time_s + periods * PERIOD, ..measurement(&q) }).unwrap();
    (before, memory.unwrap())
}

#[test]
fn a_command_that_was_held_has_no_acceleration_and_one_that_ran_out_is_zero() {
    let robot = sawyer();
    for (periods, expects_zero) in [(3.0, false), (2000.0, true), (1e12, true)] {
        let (before, memory) = after(periods);
        let jerk = |memory: &Memory| memory.jerk.clone().unwrap().acceleration;
        assert!(jerk(&before).amax() > 10.0 * PERIOD, "it accelerates: {}", jerk(&before));
        let rested = if expects_zero { Vector::zeros(7) } else { before.last_command.clone() };
        for (joint, (command, rested)) in robot.joints().iter().zip(memory.last_command.iter().zip(rested.iter())) {
            // From the acceleration 0, the jerk limit lets the command change by J T².
            let reach = braking_deceleration(&joint.limits) / 0.05 * PERIOD * PERIOD;
            assert!((command - rested).abs() <= reach * (1.0 + 1e-9), "{periods}: {command} after {rested}");
        }
    }
}

#[test]
fn a_damaged_last_state_is_refused() {
    let (controller, memory, q, time_s) = accelerating();
    let answered = memory.answered.clone().unwrap();
    let longer = answered.joint_position.push(0.0);
    for damaged in [
        AnsweredState { time_s: f64::NAN, ..answered.clone() },
        AnsweredState { joint_position: longer.clone(), ..answered.clone() },
        AnsweredState { way: Some(longer), ..answered.clone() },
        AnsweredState { stop_time_s: Some(0.0), ..answered.clone() },
        AnsweredState { stop_time_s: Some(f64::NAN), ..answered.clone() },
        AnsweredState { joint_position: &answered.joint_position * f64::NAN, ..answered },
    ] {
        let mut memory = Some(Memory { answered: Some(damaged), ..memory.clone() });
        let refused = step(&controller, &mut memory, &Measurement { time_s, ..measurement(&q) });
        assert_eq!(refused.unwrap_err(), StepError::Memory(MemoryError::AnsweredState));
    }
}

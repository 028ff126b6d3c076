//! Streamed targets: interpolation, drop-outs, recovery, and their bounds.

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use revprio_core::controller::{
    Controller, ControllerConfig, Limits, Measurement, Memory, StepError, Stepper, TaskConfig,
};
use revprio_core::law::{Law, Profile};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::rows::{JointRows, JointTarget, TaskRows};
use revprio_core::streaming::{
    Ignored, StreamedTarget, StreamedValue, Streaming, TargetError, TargetReport, TargetState,
};
use revprio_robot::JointLimits;
use revprio_robot::kinematics::{Axis, Configuration};

use super::arms::{
    NOMINAL, PERIOD, config, constant, controller, force, gantry, hybrid, impedance, measurement, position, sawyer,
    task,
};
use super::drives::LaggingArm;

/// Default bounds of a linear row.
const MAX_VELOCITY: f64 = 1.0;
const MAX_ACCELERATION: f64 = 5.0;

/// The joint x of the gantry, whose limits would otherwise bound its targets.
fn posture(gain: f64) -> TaskConfig {
    let rows = TaskRows::Joints(JointRows { joints: vec![0], target: JointTarget::Position(constant(&[0.0])) });
    let streaming = Streaming {
        max_velocity: Some(vec![MAX_VELOCITY]),
        max_acceleration: Some(vec![MAX_ACCELERATION]),
        ..Streaming::default()
    };
    TaskConfig { name: "posture".to_owned(), rows, law: position(1, gain), scaled: false, streaming }
}

fn along_x(law: Law) -> TaskConfig {
    task(&[Axis::X], law)
}

/// Tasks that follow a position along x, each with another law.
fn position_tasks() -> Vec<TaskConfig> {
    let laws = [position(1, 5.0), impedance(&[Axis::X], 1000.0), hybrid(&[Axis::X], 1000.0, &[7.0], &[true])];
    laws.into_iter().map(along_x).chain([posture(5.0)]).collect()
}

/// Returns a target of a task at x = `value`.
fn target_at(task: &TaskConfig, time_s: f64, value: f64, velocity: Option<f64>) -> StreamedTarget {
    let value = match task.rows {
        TaskRows::Tool(_) => StreamedValue::Pose { position: Some(Vector3::new(value, 0.0, 0.0)), orientation: None },
        _ => StreamedValue::JointPosition(vec![value]),
    };
    StreamedTarget { task: 0, time_s, value, velocity: velocity.map(|velocity| vec![velocity]), ahead: Vec::new() }
}

/// One period of a run.
struct Sample {
    time_s: f64,
    x: f64,
    /// ẋ of the task.
    asked: f64,
    report: Option<TargetReport>,
}

/// An ideal gantry whose task gets targets.
struct Run {
    stepper: Stepper,
    memory: Option<Memory>,
    q: Vec<f64>,
    period_s: f64,
    samples: Vec<Sample>,
    /// F_d of the last period, N.
    force: f64,
}

impl Run {
    fn new(task: TaskConfig, period_s: f64) -> Self {
        let config = ControllerConfig { period_s, ..config(&gantry(JointLimits::NONE), vec![task]) };
        let stepper = Stepper::new(controller(config)).unwrap();
        Self { stepper, memory: None, q: vec![0.0; 3], period_s, samples: Vec::new(), force: 0.0 }
    }

    fn time(&self) -> f64 {
        self.samples.len() as f64 * self.period_s
    }

    fn step(&mut self, target: Option<StreamedTarget>) -> &Sample {
        let time_s = self.time();
        let measured = Measurement { time_s, targets: target.into_iter().collect(), ..measurement(&self.q) };
        let command = self.stepper.step(&mut self.memory, &measured).unwrap();
        self.force = command.targets[0].force.first().copied().flatten().unwrap_or(0.0);
        let (asked, report) = (command.targets[0].velocity[0], command.targets[0].streamed);
        self.samples.push(Sample { time_s, x: self.q[0], asked, report });
        let velocity = command.resolution.joint_velocity.as_slice();
        self.q.iter_mut().zip(velocity).for_each(|(q, qdot)| *q += self.period_s * qdot);
        self.samples.last().unwrap()
    }

    /// Steps until `end`. Targets of a path arrive every `interval` s, `late` s after their time.
    fn follow(
        &mut self,
        task: &TaskConfig,
        end: f64,
        interval: f64,
        late: f64,
        path: impl Fn(f64) -> (f64, Option<f64>),
    ) {
        let mut sent = (self.time() / interval).floor();
        while self.time() < end {
            let due = ((self.time() - late) / interval).floor();
            let target = (due > sent).then(|| {
                sent = due;
                let time_s = due * interval;
                let (value, velocity) = path(time_s);
                target_at(task, time_s, value, velocity)
            });
            self.step(target);
        }
    }

    /// Largest change of the asked velocity from period to period after `start`.
    fn largest_change(&self, start: f64) -> f64 {
        let after: Vec<&Sample> = self.samples.iter().filter(|sample| sample.time_s >= start).collect();
        after.windows(2).map(|pair| (pair[1].asked - pair[0].asked).abs()).fold(0.0, f64::max)
    }

    fn state(&self) -> TargetState {
        self.samples.last().unwrap().report.unwrap().state
    }
}

#[test]
fn a_uniform_motion_is_followed_exactly_between_targets() {
    for (velocity, delay_s) in [(None, 0.0), (Some(0.3), 0.0), (None, 0.05)] {
        for task in position_tasks() {
            let streaming = Streaming { delay_s, ..task.streaming.clone() };
            let task = TaskConfig { streaming, ..task };
            let context = format!("{:?}, velocity {velocity:?}, delay {delay_s}", task.law);
            let mut run = Run::new(task.clone(), PERIOD);
            run.follow(&task, 6.0, 1.0 / 45.0, 0.012, |t| (0.3 * t - 0.2, velocity));
            for sample in run.samples.iter().filter(|sample| sample.time_s > 4.0) {
                let error = sample.x - (0.3 * (sample.time_s - delay_s) - 0.2);
                assert!(error.abs() < 1e-9, "{context}: {error:e} m at {} s", sample.time_s);
                let state = sample.report.unwrap().state;
                assert!(matches!(state, TargetState::Following | TargetState::Extrapolating), "{context}: {state:?}");
            }
            let interpolates = run.samples.iter().filter(|sample| sample.time_s > 4.0);
            let follows = |sample: &Sample| sample.report.unwrap().state == TargetState::Following;
            assert_eq!(interpolates.into_iter().all(follows), delay_s > 0.0, "{context}");
        }
    }
}

#[test]
fn orientations_are_followed_exactly_at_a_uniform_turn() {
    let axes = [Axis::Rx, Axis::Ry, Axis::Rz];
    let robot = sawyer();
    let start = *Configuration::new(&robot, &NOMINAL).unwrap().tool_pose();
    let start = UnitQuaternion::from_rotation_matrix(&start.rotation);
    let turned = |t: f64| UnitQuaternion::from_scaled_axis(Vector3::new(0.05, -0.1, 0.2) * t) * start;
    let mut stepper = Stepper::new(controller(config(&robot, vec![task(&axes, position(3, 5.0))]))).unwrap();
    let (mut memory, mut q, mut error) = (None, NOMINAL.to_vec(), 0.0);
    for i in 0..3000 {
        let time_s = f64::from(i) * PERIOD;
        let value = StreamedValue::Pose { position: None, orientation: Some(turned(time_s)) };
        let target = StreamedTarget { task: 0, time_s, value, velocity: None, ahead: Vec::new() };
        let targets = if i % 22 == 0 { vec![target] } else { Vec::new() };
        let command = stepper
            .step(&mut memory, &Measurement { obstacles: Vec::new(), time_s, targets, ..measurement(&q) })
            .unwrap();
        q.iter_mut().zip(command.resolution.joint_velocity.iter()).for_each(|(q, qdot)| *q += PERIOD * qdot);
        let actual = Configuration::new(&robot, &q).unwrap().tool_pose().rotation;
        error = UnitQuaternion::from_rotation_matrix(&actual).angle_to(&turned(time_s + PERIOD));
    }
    // The law itself is a first-order integration on the rotations.
    assert!(error < 1e-5, "{error:e} rad");
}

#[test]
fn finer_periods_change_the_command_less() {
    let largest = |period: f64| {
        let task = along_x(position(1, 5.0));
        let mut run = Run::new(task.clone(), period);
        run.follow(&task, 4.0, 1.0 / 45.0, 0.0, |t| (0.05 * (4.0 * t).sin(), None));
        run.largest_change(1.0)
    };
    let (coarse, fine) = (largest(8e-3), largest(1e-3));
    assert!(coarse > 4.0 * fine, "{coarse} m/s with 8 ms, {fine} m/s with 1 ms");
}

#[test]
fn after_a_drop_out_a_motion_is_at_rest_within_the_stated_time() {
    let stated = |task: &TaskConfig| task.streaming.brake_after_s + MAX_VELOCITY / MAX_ACCELERATION + PERIOD;
    for task in position_tasks() {
        let mut run = Run::new(task.clone(), PERIOD);
        run.follow(&task, 2.0, 1.0 / 45.0, 0.0, |t| (0.6 * t, None));
        assert!((run.samples.last().unwrap().asked - 0.6).abs() < 1e-3);
        let last_target = run.time() - run.samples.last().unwrap().report.unwrap().age_s.unwrap();
        let mut states = Vec::new();
        while run.time() < 4.0 {
            let sample = run.step(None);
            let context = format!("{:?} at {} s: {} m/s", task.law, sample.time_s, sample.asked);
            assert!(sample.time_s < last_target + stated(&task) || sample.asked.abs() < 1e-9, "{context}");
            states.push(sample.report.unwrap().state);
        }
        assert!(states.is_sorted() && states.contains(&TargetState::Holding), "{:?}", task.law);
        assert_eq!(states.last(), Some(&TargetState::Braking));
        assert!(run.largest_change(0.0) <= MAX_ACCELERATION * PERIOD + 1e-9);
    }
}

#[test]
fn velocities_and_forces_are_held_and_then_brake() {
    let velocity = along_x(Law::Velocity(constant(&[0.0])));
    let push = along_x(force(&[Axis::X], &[0.0]));
    for (task, value) in [(velocity, StreamedValue::Velocity(vec![0.4])), (push, StreamedValue::Force(vec![60.0]))] {
        let mut run = Run::new(task.clone(), PERIOD);
        for i in 0..1000 {
            let target =
                StreamedTarget { task: 0, time_s: run.time(), value: value.clone(), velocity: None, ahead: Vec::new() };
            run.step((i % 20 == 0).then_some(target));
        }
        // B_d is 150 N·s/m, so 60 N move the tool at 0.4 m/s.
        assert!((run.samples.last().unwrap().asked - 0.4).abs() < 1e-3, "{:?}", task.law);
        while run.time() < 0.98 + 0.199 {
            let asked = run.step(None).asked;
            assert!((asked - 0.4).abs() < 1e-3, "{:?}: {asked}", task.law);
        }
        assert_eq!(run.state(), TargetState::Holding);
        while run.time() < 0.98 + 0.2 + 0.4 / MAX_ACCELERATION + 3.0 * PERIOD {
            run.step(None);
        }
        assert_eq!(run.state(), TargetState::Braking);
        (0..100).for_each(|_| assert!(run.step(None).asked.abs() < 1e-12));
        assert!(run.largest_change(0.9) <= MAX_ACCELERATION * PERIOD + 1e-12);
        // It follows again.
        for _ in 0..1000 {
            let target =
                StreamedTarget { task: 0, time_s: run.time(), value: value.clone(), velocity: None, ahead: Vec::new() };
            run.step(Some(target));
        }
        assert!((run.samples.last().unwrap().asked - 0.4).abs() < 1e-3, "{:?}", task.law);
    }
}

#[test]
fn forces_are_interpolated_and_never_extrapolated() {
    let task = along_x(force(&[Axis::X], &[0.0]));
    let mut run =
        Run::new(TaskConfig { streaming: Streaming { delay_s: 0.1, ..Streaming::default() }, ..task }, PERIOD);
    let push = |time_s: f64, force: f64| {
        Some(StreamedTarget {
            task: 0,
            time_s,
            value: StreamedValue::Force(vec![force]),
            velocity: None,
            ahead: Vec::new(),
        })
    };
    run.step(push(0.0, 10.0));
    let mut forces = Vec::new();
    while run.time() < 0.4 {
        let target = if run.samples.len() == 20 { push(0.02, 30.0) } else { None };
        run.step(target);
        forces.push(run.force);
    }
    // At 0.11 s the task is half-way between the targets of 0 s and 0.02 s.
    for (period, expected) in [(30, 10.0), (100, 10.0), (110, 20.0), (120, 30.0), (300, 30.0)] {
        assert!((forces[period - 1] - expected).abs() < 1e-9, "{period}: {} N", forces[period - 1]);
    }
    assert!(forces.iter().all(|force| (10.0..=30.0).contains(force)));
}

#[test]
fn a_position_task_that_is_held_back_stops_where_the_arm_is() {
    // The joint moves at 0.1 m/s at most, and its target is a metre ahead when the targets end.
    let slow = JointLimits { velocity: 0.1, ..JointLimits::NONE };
    let limits = Limits::Robot(LimitKind::Velocity);
    let task = along_x(position(1, 5.0));
    let controller = controller(ControllerConfig { limits, ..config(&gantry(slow), vec![task.clone()]) });
    let mut run = Run { stepper: Stepper::new(controller).unwrap(), ..Run::new(task.clone(), PERIOD) };
    run.follow(&task, 2.0, 1.0 / 45.0, 0.0, |t| (0.5 * t, None));
    let end = run.q[0];
    while run.time() < 6.0 {
        run.step(None);
    }
    let moved = run.q[0] - end;
    assert!(moved < 0.1 * 0.3, "{moved} m after the last target");
}

#[test]
fn the_task_recovers_after_a_drop_out_without_a_jump() {
    for task in position_tasks() {
        let mut run = Run::new(task.clone(), PERIOD);
        run.follow(&task, 2.0, 1.0 / 45.0, 0.0, |t| (0.2 * t, None));
        for _ in 0..1000 {
            run.step(None);
        }
        // Meanwhile the hand has moved by half a metre.
        run.follow(&task, 9.0, 1.0 / 45.0, 0.0, |t| (0.9 + 0.1 * (t - 3.0), None));
        let error = run.samples.last().unwrap().x - (0.9 + 0.1 * (run.samples.last().unwrap().time_s - 3.0));
        assert!(error.abs() < 1e-9, "{:?}: {error:e} m", task.law);
        assert!(run.largest_change(0.0) <= MAX_ACCELERATION * PERIOD + 1e-9, "{:?}", task.law);
        let fastest = run.samples.iter().map(|sample| sample.asked.abs()).fold(0.0, f64::max);
        assert!(fastest <= MAX_VELOCITY + 1e-9, "{:?}: {fastest} m/s", task.law);
    }
}

#[test]
fn targets_that_are_not_newer_are_ignored_and_reported() {
    let task = along_x(position(1, 5.0));
    let mut run = Run::new(task.clone(), PERIOD);
    run.step(Some(target_at(&task, 0.0, 0.1, None)));
    run.step(Some(target_at(&task, 0.02, 0.2, None)));
    let ignored = |run: &mut Run, time_s: f64, value: f64| {
        run.step(Some(target_at(&task, time_s, value, None))).report.unwrap().ignored
    };
    assert_eq!(ignored(&mut run, 0.02, 0.2), Some(Ignored::Repeated));
    assert_eq!(ignored(&mut run, 0.02, 0.3), Some(Ignored::Older { time_s: 0.02, newest_s: 0.02 }));
    assert_eq!(ignored(&mut run, 0.01, 0.2), Some(Ignored::Older { time_s: 0.01, newest_s: 0.02 }));
    let newest = run.memory.as_ref().unwrap().target_streams[0].newest.clone().unwrap();
    assert_eq!(newest.time_s, 0.02);
    // Nearer targets would have a velocity without meaning, or none that is finite.
    assert_eq!(ignored(&mut run, 0.02 + 1e-12, 0.3), Some(Ignored::Older { time_s: 0.02 + 1e-12, newest_s: 0.02 }));
    assert_eq!(ignored(&mut run, 0.021, 0.2), None);
    assert_eq!(run.step(None).report.unwrap().ignored, None);
}

#[test]
fn targets_that_do_not_fit_are_refused_and_change_nothing() {
    let task = along_x(position(1, 5.0));
    let mut run = Run::new(task.clone(), PERIOD);
    run.step(Some(target_at(&task, 0.0, 0.1, None)));
    let before = run.memory.clone();
    let good = target_at(&task, PERIOD, 0.1, None);
    let force = StreamedValue::Force(vec![1.0]);
    let cases = [
        (StreamedTarget { task: 1, ..good.clone() }, TargetError::Quantity),
        (StreamedTarget { value: force, ..good.clone() }, TargetError::Quantity),
        (StreamedTarget { velocity: Some(vec![0.0; 2]), ..good.clone() }, TargetError::Rows { expected: 1, given: 2 }),
        (target_at(&task, PERIOD, f64::NAN, None), TargetError::NotFinite),
        (target_at(&task, PERIOD, 0.1, Some(f64::INFINITY)), TargetError::NotFinite),
        (StreamedTarget { time_s: PERIOD + 1.5, ..good.clone() }, TargetError::Ahead { ahead_s: 1.5 }),
    ];
    for (target, expected) in cases {
        let measured = Measurement { time_s: PERIOD, targets: vec![good.clone(), target], ..measurement(&run.q) };
        let error = run.stepper.step(&mut run.memory, &measured).unwrap_err();
        assert_eq!(error, StepError::Target { index: 1, source: expected });
        assert_eq!(run.memory, before);
    }
    let bounds = along_x(Law::Bounds(revprio_core::law::VelocityBounds::new(vec![0.0], vec![1.0]).unwrap()));
    assert!(bounds.quantities().is_empty());
}

#[test]
fn a_clock_that_goes_back_ends_the_stream_until_the_next_target() {
    let task = along_x(position(1, 5.0));
    let mut run = Run::new(task.clone(), PERIOD);
    let mut at = |time_s: f64, target: Option<StreamedTarget>| {
        let measured = Measurement { time_s, targets: target.into_iter().collect(), ..measurement(&run.q) };
        run.stepper.step(&mut run.memory, &measured).unwrap().targets[0].streamed.unwrap()
    };
    at(100.0, Some(target_at(&task, 100.0, 0.1, None)));
    let report = at(0.0, None);
    assert_eq!((report.state, report.age_s), (TargetState::Braking, None));
    let report = at(PERIOD, Some(target_at(&task, PERIOD, 0.1, None)));
    assert_eq!((report.state, report.age_s, report.ignored), (TargetState::Following, Some(0.0), None));
}

/// Newer targets seem older then. An operator who lets go must not wait until the clock has caught up.
#[test]
fn a_streamed_velocity_ends_when_the_clock_goes_back() {
    let task = along_x(Law::Velocity(constant(&[0.0])));
    let mut run = Run::new(task, PERIOD);
    let mut at = |time_s: f64, velocity: f64| {
        let value = StreamedValue::Velocity(vec![velocity]);
        let target = StreamedTarget { task: 0, time_s, value, velocity: None, ahead: Vec::new() };
        let measured = Measurement { time_s, targets: vec![target], ..measurement(&run.q) };
        run.stepper.step(&mut run.memory, &measured).unwrap().targets[0].velocity[0]
    };
    for k in 0..500 {
        at(100.0 + f64::from(k) * PERIOD, 0.3);
    }
    let back = 100.0 + 500.0 * PERIOD - 0.9;
    let last = (0..300).map(|k| at(back + f64::from(k) * PERIOD, 0.0)).last().unwrap();
    assert!(last < 1e-3, "{last} m/s");
}

/// While states are missing, the arm goes on with its command, and so does what it follows.
#[test]
fn missing_states_do_not_disturb_a_uniform_motion() {
    for missing in [1, 10, 40] {
        let task = along_x(position(1, 8.0));
        let mut run = Run::new(task.clone(), PERIOD);
        run.follow(&task, 3.0, 1.0 / 50.0, 0.0, |t| (0.5 * t, None));
        let mut time = run.time();
        let mut step = |time: f64, q: &mut [f64]| {
            let target = target_at(&task, time, 0.5 * time, None);
            let measured = Measurement { time_s: time, targets: vec![target], ..measurement(q) };
            let velocity = run.stepper.step(&mut run.memory, &measured).unwrap().resolution.joint_velocity[0];
            q[0] += PERIOD * velocity;
            velocity
        };
        let mut q = run.q.clone();
        let before = step(time, &mut q);
        q[0] += f64::from(missing) * PERIOD * before;
        time += f64::from(missing) * PERIOD;
        for k in 1..=500 {
            let velocity = step(time + f64::from(k) * PERIOD, &mut q);
            assert!((velocity - 0.5).abs() < 1e-3, "{missing} missing, period {k}: {velocity} m/s");
        }
    }
}

/// The arm stands on the first target, far from the target of its law.
#[test]
fn a_stream_starts_where_the_arm_is() {
    let mut run = Run::new(posture(5.0), PERIOD);
    run.q[0] = 0.5;
    for k in 0..100 {
        let time_s = f64::from(k) * PERIOD;
        let target = target_at(&posture(5.0), time_s, 0.5, None);
        assert_eq!(run.step(Some(target)).asked, 0.0, "period {k}");
    }
}

/// The arm follows its own target behind a drive; then targets come that lie on its way, or where it is.
#[test]
fn a_stream_that_starts_on_the_way_neither_speeds_up_nor_dips() {
    const SPEED: f64 = 0.2;
    for (gain, lag_s, delay_periods, period_s) in [(4.0, 0.05, 3, 0.01), (8.0, 0.03, 2, 0.008), (20.0, 0.0, 0, 0.002)] {
        let drive = Drive { lag_s, delay_periods };
        let own = Profile::ramp(vec![0.0], vec![10.0 * SPEED], 0.0, 10.0).unwrap();
        let rows = TaskRows::Joints(JointRows { joints: vec![0], target: JointTarget::Position(own) });
        let task = TaskConfig { rows, ..posture(gain) };
        let config = ControllerConfig { period_s, drive, ..config(&gantry(JointLimits::NONE), vec![task.clone()]) };
        for stops in [false, true] {
            let mut stepper = Stepper::new(controller(config.clone())).unwrap();
            let (mut arm, mut memory) = (LaggingArm::at_rest(&[0.0; 3], drive, 0.0, 1), None);
            let (mut begins, mut stand) = (0.0, 0.0);
            for k in 0..800 {
                let time_s = period_s * f64::from(k);
                let mut measurement = arm.measure(time_s);
                if k == 500 {
                    (begins, stand) = (time_s, arm.q[0]);
                }
                if k >= 500 {
                    let value = if stops { stand } else { SPEED * time_s };
                    measurement.targets = vec![target_at(&task, time_s, value, Some(if stops { 0.0 } else { SPEED }))];
                }
                let command = stepper.step(&mut memory, &measurement).unwrap().resolution.joint_velocity.clone();
                let case = format!("gain {gain}, stops {stops}, {:.3} s after the first target", time_s - begins);
                if k > 490 && !stops {
                    assert!((command[0] - SPEED).abs() < 1e-3 * SPEED, "{case}: {}", command[0]);
                }
                assert!(k < 500 || command[0] < 1.001 * SPEED, "{case}: {}", command[0]);
                arm.follow(command.as_slice(), period_s);
            }
        }
    }
}

/// A stream of targets that jump, come late or not at all.
fn hostile_stream() -> impl Strategy<Value = Vec<(f64, f64, f64)>> {
    // Interval, lateness and value of each target.
    let interval = prop_oneof![4 => 1.0 / 90.0..1.0 / 30.0, 1 => 0.0..0.6];
    prop::collection::vec((interval, 0.0..0.03, -1.0..1.0), 1..60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_stream_breaks_the_bounds(
        stream in hostile_stream(),
        kind in 0_usize..4,
        period in 1e-3..8e-3,
        smoothing_s in prop_oneof![Just(0.0), 0.0..0.1],
        delay_s in prop_oneof![Just(0.0), 0.0..0.1],
    ) {
        let task = position_tasks().swap_remove(kind);
        let task = TaskConfig { streaming: Streaming { smoothing_s, delay_s, ..task.streaming.clone() }, ..task };
        let mut run = Run::new(task.clone(), period);
        let mut pending: Vec<(f64, StreamedTarget)> = Vec::new();
        let mut time_s = 0.0;
        for (interval, late, value) in stream {
            time_s += interval;
            pending.push((time_s + late, target_at(&task, time_s, value, None)));
        }
        let end = time_s + 2.0;
        while run.time() < end {
            let now = run.time();
            let due = pending.iter().position(|(arrival, _)| *arrival <= now);
            let target = due.map(|index| pending.remove(index).1);
            run.step(target);
        }
        let change = run.largest_change(0.0);
        prop_assert!(change <= MAX_ACCELERATION * period * (1.0 + 1e-9) + 1e-9, "{change} m/s in {period} s");
        let fastest = run.samples.iter().map(|sample| sample.asked.abs()).fold(0.0, f64::max);
        prop_assert!(fastest <= MAX_VELOCITY + 1e-9, "{fastest} m/s");
        prop_assert!(run.samples.last().unwrap().asked.abs() < 1e-9);
    }
}

/// A pseudo-random sequence in −1 … 1, the same in every run.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Streams jumping poses at 45 Hz with drop-outs to an arm with lag, delay and noise. Returns the largest excess over
/// velocity and acceleration limits of the commands.
fn largest_excess(controller: &Controller, lag_s: f64, delay: usize, noise: f64, seed: u64) -> [f64; 2] {
    let config = controller.config();
    let (robot, period) = (&config.robot, config.period_s);
    let start = *Configuration::new(robot, &NOMINAL).unwrap().tool_pose();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let (mut random, mut memory) = (Noise(seed), None);
    let (mut q, mut speed) = (NOMINAL.to_vec(), vec![0.0; 7]);
    let mut commands = vec![vec![0.0; 7]; delay + 1];
    let (mut excess, mut next, mut moved) = ([f64::NEG_INFINITY; 2], 0.0, 0);
    for i in 0..5000_u32 {
        let time_s = f64::from(i) * period;
        let mut targets = Vec::new();
        let dropped = time_s % 1.6 > 1.0;
        if time_s >= next {
            next = time_s + (1.0 + 0.4 * random.next()) / 45.0;
            let jump = Vector3::new(random.next(), random.next(), random.next()) * 0.3;
            let position = Some(start.translation.vector + jump);
            let value = StreamedValue::Pose { position, orientation: None };
            let target = StreamedTarget {
                task: 0,
                time_s: time_s - 0.01 * random.next().abs(),
                value,
                velocity: None,
                ahead: Vec::new(),
            };
            targets.extend((!dropped).then_some(target));
        }
        let measured: Vec<f64> = q.iter().map(|q| q + noise * random.next()).collect();
        let measured = Measurement { time_s, targets, ..measurement(&measured) };
        let command = stepper.step(&mut memory, &measured).unwrap();
        let command_velocity = command.resolution.joint_velocity.as_slice().to_vec();
        let last = commands.last().unwrap();
        for (joint, (velocity, before)) in command_velocity.iter().zip(last).enumerate() {
            let limits = &robot.joints()[joint].limits;
            excess[0] = excess[0].max(velocity.abs() - limits.velocity);
            if !command.limit_conflicts.contains(&joint) {
                excess[1] = excess[1].max((velocity - before).abs() - limits.acceleration * period);
            }
        }
        moved += usize::from(command_velocity.iter().any(|velocity| velocity.abs() > 1e-3));
        commands.push(command_velocity);
        let delayed = &commands[commands.len() - 1 - delay];
        let blend = if lag_s > 0.0 { 1.0 - (-period / lag_s).exp() } else { 1.0 };
        for joint in 0..7 {
            speed[joint] += blend * (delayed[joint] - speed[joint]);
            q[joint] += period * speed[joint];
        }
    }
    assert!(moved > 1000, "the arm moved in {moved} periods");
    excess
}

#[test]
fn jumping_targets_with_drop_outs_keep_the_limits_with_lag_delay_and_noise() {
    let axes = [Axis::X, Axis::Y, Axis::Z];
    for law in [position(3, 5.0), impedance(&axes, 500.0)] {
        let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
        let task = task(&axes, law);
        let fast = Streaming {
            max_velocity: Some(vec![10.0; 3]),
            max_acceleration: Some(vec![100.0; 3]),
            ..Streaming::default()
        };
        // Bounds of the targets far above what the joints can do: the joint limits alone protect the arm.
        for streaming in [Streaming::default(), fast] {
            let task = TaskConfig { streaming, ..task.clone() };
            let config = ControllerConfig { limits: limits.clone(), ..config(&sawyer(), vec![task]) };
            for (lag_s, delay, noise) in [(0.0, 0, 0.0), (0.02, 1, 1e-4), (0.03, 2, 1e-4)] {
                let [velocity, acceleration] = largest_excess(&controller(config.clone()), lag_s, delay, noise, 7);
                assert!(velocity <= 1e-12 && acceleration <= 1e-12, "{velocity:e} rad/s, {acceleration:e} rad/s");
            }
        }
    }
}

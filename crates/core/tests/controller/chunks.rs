//! Chunks of actions: followed by every law, refused where they do not fit, bounded by the limits.

mod policy;
mod random_streams;

use nalgebra::Vector3;
use revprio_core::channel::{ChannelConfig, ChannelInput, ChannelKind, ChannelTarget};
use revprio_core::controller::{Controller, ControllerConfig, Limits, Measurement, StepError, Stepper, TaskConfig};
use revprio_core::law::{Law, MotionPath, PositionLaw};
use revprio_core::limits::LimitKind;
use revprio_core::streaming::{
    Action, Align, ChannelChunk, ChunkError, MAX_ACTIONS, MAX_HORIZON, StreamedChunk, StreamedTarget, StreamedValue,
    Streaming, TargetState,
};
use revprio_robot::JointLimits;
use revprio_robot::kinematics::Axis;

use super::arms::{
    NOMINAL, PERIOD, config, controller, force, gantry, hybrid, impedance, joint_rows, measurement, position, sawyer,
    task,
};

/// Returns a chunk of `count` actions from `start` on, `interval` s apart.
fn chunk(start: f64, interval: f64, count: u32, value: impl Fn(f64) -> StreamedValue) -> StreamedChunk {
    let action = |k| {
        let time_s = start + f64::from(k) * interval;
        Action { time_s, value: value(time_s) }
    };
    StreamedChunk { channels: Vec::new(), task: 0, actions: (0..count).map(action).collect(), align: Align::Time }
}

fn along_x(x: f64) -> StreamedValue {
    StreamedValue::Pose { position: Some(Vector3::new(x, 0.0, 0.0)), orientation: None }
}

/// What a run on the gantry shows.
struct Run {
    stepper: Stepper,
    memory: Option<revprio_core::controller::Memory>,
    q: Vec<f64>,
    period: u32,
}

impl Run {
    fn new(controller: Controller, q: &[f64]) -> Self {
        Self { stepper: Stepper::new(controller).unwrap(), memory: None, q: q.to_vec(), period: 0 }
    }

    fn time(&self) -> f64 {
        f64::from(self.period) * PERIOD
    }

    fn step(&mut self, chunks: Vec<StreamedChunk>) -> Result<revprio_core::controller::Command, StepError> {
        let measured = Measurement { time_s: self.time(), chunks, ..measurement(&self.q) };
        let command = self.stepper.step(&mut self.memory, &measured)?.clone();
        self.q.iter_mut().zip(command.resolution.joint_velocity.iter()).for_each(|(q, v)| *q += PERIOD * v);
        self.period += 1;
        Ok(command)
    }
}

/// Fifty actions at 30 Hz, 1.67 s: what a policy gives.
#[test]
fn every_law_that_follows_positions_follows_a_chunk() {
    let joint = TaskConfig { rows: joint_rows(&[0.0; 3]), ..task(&[Axis::X, Axis::Y, Axis::Z], position(3, 5.0)) };
    let laws = [position(1, 5.0), impedance(&[Axis::X], 1000.0), hybrid(&[Axis::X], 1000.0, &[7.0], &[true])];
    let ahead = PositionLaw::new(vec![5.0]).unwrap().along(MotionPath::Joint);
    let fast = JointLimits { velocity: 1.0, acceleration: 5.0, lower: -1.0, upper: 1.0, ..JointLimits::NONE };
    let tasks = laws.into_iter().chain([Law::Position(ahead)]).map(|law| task(&[Axis::X], law)).chain([joint]);
    let path = |time: f64| 0.1 * (1.0 - (2.0 * time).cos());
    for task in tasks {
        let name = format!("{:?}", task.law);
        let is_joint = task.rows.joints().len() == 3;
        let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
        let config = ControllerConfig { limits, ..config(&gantry(fast), vec![task]) };
        let mut run = Run::new(controller(config), &[0.0; 3]);
        let value = |time: f64| {
            if is_joint { StreamedValue::JointPosition(vec![path(time), 0.0, 0.0]) } else { along_x(path(time)) }
        };
        let command = run.step(vec![chunk(0.0, 1.0 / 30.0, 50, value)]).unwrap();
        let report = command.targets[0].streamed.unwrap().chunk.unwrap();
        assert_eq!((report.actions_left, report.merged.unwrap().dropped), (49, 1), "{name}");
        while run.time() < 1.6 {
            let command = run.step(Vec::new()).unwrap();
            assert_eq!(command.targets[0].streamed.unwrap().state, TargetState::Following, "{name}");
            let error = run.q[0] - path(run.time());
            assert!(run.time() < 0.5 || error.abs() < 1e-3, "{name}: {error} m at {} s", run.time());
        }
        // After the last action the stream ends as every stream does.
        while run.time() < 2.5 {
            run.step(Vec::new()).unwrap();
        }
        let command = run.step(Vec::new()).unwrap();
        assert_eq!(command.targets[0].streamed.unwrap().state, TargetState::Braking, "{name}");
        assert!(command.resolution.joint_velocity.iter().all(|v| v.abs() < 2e-3), "{name}");
    }
}

#[test]
fn forces_are_followed_action_by_action() {
    let mut run = Run::new(
        controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], force(&[Axis::X], &[0.0]))])),
        &[0.0; 3],
    );
    run.step(vec![chunk(0.0, 0.1, 5, |time| StreamedValue::Force(vec![100.0 * time]))]).unwrap();
    let mut forces = Vec::new();
    while run.time() < 0.4 {
        forces.push(run.step(Vec::new()).unwrap().targets[0].force[0].unwrap());
    }
    for (period, expected) in [(49, 5.0), (99, 10.0), (249, 25.0)] {
        assert!((forces[period] - expected).abs() < 1e-9, "{period}: {} N", forces[period]);
    }
}

/// Until the first action is due, the law goes on with its own target.
#[test]
fn a_force_chunk_that_begins_later_begins_at_the_target_of_the_law() {
    let law = force(&[Axis::X], &[30.0]);
    let mut run = Run::new(controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], law)])), &[0.0; 3]);
    run.step(Vec::new()).unwrap();
    let now = run.time();
    let command = run.step(vec![chunk(now + 0.5, 0.1, 3, |_| StreamedValue::Force(vec![10.0]))]).unwrap();
    assert_eq!(command.targets[0].force, [Some(30.0)]);
    let half_way = loop {
        let command = run.step(Vec::new()).unwrap();
        if run.time() > now + 0.25 + PERIOD {
            break command.targets[0].force[0].unwrap();
        }
    };
    assert!((half_way - 20.0).abs() < 0.2, "{half_way} N");
}

/// A chunk that is ignored replaces nothing.
#[test]
fn a_first_chunk_whose_actions_are_past_leaves_the_task_its_own_target() {
    let own = |law: Law, value: fn(f64) -> StreamedValue| {
        let start = || {
            Run::new(
                controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], law.clone())])),
                &[0.2, 0.0, 0.0],
            )
        };
        let (mut with, mut without) = (start(), start());
        for period in 0..500 {
            let late = if period == 100 { vec![chunk(-1.0, 0.1, 5, value)] } else { Vec::new() };
            let (got, expected) = (with.step(late).unwrap(), without.step(Vec::new()).unwrap());
            assert_eq!(got.targets[0].unused.is_some(), period == 100);
            assert_eq!((got.targets[0].streamed, &got.targets[0].force), (None, &expected.targets[0].force));
            assert_eq!(got.resolution.joint_velocity, expected.resolution.joint_velocity, "{period}");
        }
        assert_eq!(with.memory, without.memory);
    };
    own(position(1, 2.0), along_x);
    own(force(&[Axis::X], &[30.0]), |_| StreamedValue::Force(vec![5.0]));
}

/// A state with a time far in the future, and a clock that goes back behind the actions that are left.
#[test]
fn a_chunk_is_forgotten_when_its_clock_is_another_one() {
    let arc = |time: f64| along_x(0.2 * (0.6 * time).sin());
    for (begins, later) in [(1.0, Some(100_000)), (5.5, None)] {
        let mut run = Run::new(
            controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], position(1, 5.0))])),
            &[0.0; 3],
        );
        run.step(vec![chunk(0.0, 0.1, 100, arc)]).unwrap();
        while run.time() < begins {
            run.step(Vec::new()).unwrap();
        }
        let next = run.period + 1;
        run.period += later.unwrap_or_default();
        run.step(Vec::new()).unwrap();
        run.period = later.map_or(0, |_| next);
        let command = run.step(Vec::new()).unwrap();
        assert_eq!(command.targets[0].streamed.unwrap().state, TargetState::Braking, "{begins}");
        assert!(run.memory.as_ref().unwrap().target_streams[0].chunk.actions.is_empty(), "{begins}");
    }
}

/// A gripper stays where it is when the clock forgets its chunk, and closes to a target of now.
#[test]
fn a_channel_stays_where_its_chunk_is_forgotten() {
    let channel = ChannelConfig {
        name: "gripper".to_owned(),
        kind: ChannelKind::Position,
        lower: 0.0,
        upper: 0.08,
        max_rate: 1.0,
        target: None,
    };
    let base = config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], position(1, 5.0))]);
    let mut run = Run::new(controller(ControllerConfig { channels: vec![channel], ..base }), &[0.0; 3]);
    let command = |run: &Run| run.memory.as_ref().unwrap().channels[0].command.unwrap();
    let targets = [(0.0, 0.02), (10.0, 0.08)].map(|(time_s, value)| ChannelTarget { time_s, value });
    let arc = |time: f64| along_x(0.2 * (0.6 * time).sin());
    let channels = vec![ChannelChunk { channel: 0, targets: targets.to_vec() }];
    run.step(vec![StreamedChunk { channels, ..chunk(0.0, 0.1, 101, arc) }]).unwrap();
    while run.time() < 5.0 {
        run.step(Vec::new()).unwrap();
    }
    let stays = command(&run);
    assert!((stays - 0.05).abs() < 1e-3, "{stays}");
    run.period = 0;
    for _ in 0..50 {
        run.step(Vec::new()).unwrap();
        assert_eq!(command(&run), stays, "{}", run.time());
    }
    run.period = 5000;
    let chunks = vec![chunk(run.time(), 0.1, 100, arc)];
    let closing = ChannelInput { channel: 0, measured: None, target: Some(0.0) };
    let measured = Measurement { time_s: run.time(), channels: vec![closing], chunks, ..measurement(&run.q) };
    run.stepper.step(&mut run.memory, &measured).unwrap();
    assert!(command(&run) > 0.03, "the gripper is not closed yet");
    run.period = 0;
    for _ in 0..50 {
        run.step(Vec::new()).unwrap();
    }
    assert_eq!(command(&run), 0.0);
}

#[test]
fn chunks_that_do_not_fit_are_refused_and_change_nothing() {
    let mut run =
        Run::new(controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], position(1, 5.0))])), &[0.0; 3]);
    let good = chunk(0.0, 0.1, 5, along_x);
    run.step(vec![good.clone()]).unwrap();
    let memory = run.memory.clone();
    let with = |index: usize, action: Action| {
        let mut changed = good.clone();
        changed.actions[index] = action;
        changed
    };
    let value = along_x(0.2);
    let nan = along_x(f64::NAN);
    let refused = [
        (StreamedChunk { actions: Vec::new(), ..good.clone() }, ChunkError::Empty),
        (chunk(0.0, 0.01, 257, along_x), ChunkError::TooMany { given: MAX_ACTIONS + 1 }),
        (with(0, Action { time_s: 0.0, value: StreamedValue::Force(vec![1.0]) }), ChunkError::Quantity { index: 0 }),
        (StreamedChunk { task: 1, ..good.clone() }, ChunkError::Quantity { index: 0 }),
        (with(3, Action { time_s: 0.3, value: StreamedValue::Force(vec![1.0]) }), ChunkError::Mixed { index: 3 }),
        (
            with(2, Action { time_s: 0.1, value: value.clone() }),
            ChunkError::Order { index: 2, time_s: 0.1, before_s: 0.1 },
        ),
        (with(2, Action { time_s: f64::NAN, value: value.clone() }), ChunkError::NotFinite { index: 2 }),
        (with(4, Action { time_s: 0.4, value: nan }), ChunkError::NotFinite { index: 4 }),
        (with(4, Action { time_s: 10.5, value }), ChunkError::Ahead { index: 4, ahead_s: 10.5 - PERIOD }),
    ];
    for (chunk, expected) in refused {
        let error = run.step(vec![chunk]).unwrap_err();
        assert_eq!(error, StepError::Chunk { index: 0, source: expected });
        assert_eq!(run.memory, memory);
    }
    const { assert!(MAX_ACTIONS >= 128 && MAX_HORIZON >= 3.0) };
}

#[test]
fn a_single_target_takes_over_from_a_chunk() {
    let mut run =
        Run::new(controller(config(&gantry(JointLimits::NONE), vec![task(&[Axis::X], position(1, 5.0))])), &[0.0; 3]);
    run.step(vec![chunk(0.0, 0.1, 30, |time| along_x(0.1 * time))]).unwrap();
    for _ in 0..500 {
        run.step(Vec::new()).unwrap();
    }
    let time_s = run.time();
    let target = StreamedTarget { task: 0, time_s, value: along_x(0.05), velocity: None, ahead: Vec::new() };
    let measured = Measurement { time_s, targets: vec![target], ..measurement(&run.q) };
    let report = run.stepper.step(&mut run.memory, &measured).unwrap().targets[0].streamed.unwrap();
    assert_eq!((report.ignored, report.chunk, report.age_s), (None, None, Some(0.0)));
}

/// A policy that outputs joints: its jumps are bounded by the limits of the joints.
#[test]
fn joint_chunks_keep_the_limits_of_the_joints() {
    let robot = sawyer();
    let rows = joint_rows(&NOMINAL);
    let posture = TaskConfig { rows, ..task(&[Axis::X; 1], position(7, 8.0)) };
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let mut run = Run::new(controller(ControllerConfig { limits, ..config(&robot, vec![posture]) }), &NOMINAL);
    let mut last = vec![0.0; 7];
    for period in 0..4000_u32 {
        let jump = if period / 500 % 2 == 0 { 0.4 } else { -0.4 };
        let target: Vec<f64> = NOMINAL.iter().map(|q| q + jump).collect();
        let chunks = if period % 500 == 0 && period < 3000 {
            vec![chunk(run.time() - 0.1, 0.02, 60, |_| StreamedValue::JointPosition(target.clone()))]
        } else {
            Vec::new()
        };
        let command = run.step(chunks).unwrap();
        for ((joint, v), before) in robot.joints().iter().zip(command.resolution.joint_velocity.iter()).zip(&last) {
            assert!(v.abs() <= joint.limits.velocity * (1.0 + 1e-9));
            assert!((v - before).abs() <= joint.limits.acceleration * PERIOD * (1.0 + 1e-6));
        }
        last = command.resolution.joint_velocity.as_slice().to_vec();
    }
    assert!((run.q[0] - NOMINAL[0] + 0.4).abs() < 1e-3, "{}", run.q[0] - NOMINAL[0]);
}

/// The memory is all that a controller knows: a new one in each period answers the same.
#[test]
fn a_new_stepper_in_each_period_answers_the_same() {
    let limits = Limits::Robot(LimitKind::PositionVelocityAcceleration);
    let hand = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 8.0));
    let streaming = Streaming { delay_s: 0.03, ..Streaming::default() };
    let config = ControllerConfig { limits, ..config(&sawyer(), vec![TaskConfig { streaming, ..hand }]) };
    let mut kept = Run::new(controller(config.clone()), &NOMINAL);
    let mut renewed = Run::new(controller(config.clone()), &NOMINAL);
    let start = revprio_robot::kinematics::Configuration::new(&config.robot, &NOMINAL).unwrap();
    let start = start.tool_pose().translation.vector;
    for period in 0..1500_u32 {
        let place = |time: f64| {
            let position = start + Vector3::new(0.1 * (2.0 * time).sin(), 0.0, 0.05 * time.sin());
            StreamedValue::Pose { position: Some(position), orientation: None }
        };
        let arrives = |run: &Run| match period % 200 {
            150 => {
                let align = if period % 400 == 150 { Align::Progress } else { Align::Time };
                vec![StreamedChunk { align, ..chunk(run.time() - 0.1, 0.033, 20, place) }]
            }
            _ => Vec::new(),
        };
        renewed.stepper = Stepper::new(controller(config.clone())).unwrap();
        let chunks = [arrives(&kept), arrives(&renewed)];
        let [a, b] = chunks;
        let (a, b) = (kept.step(a).unwrap(), renewed.step(b).unwrap());
        assert_eq!(a.resolution.joint_velocity, b.resolution.joint_velocity, "{period}");
        assert_eq!(kept.memory, renewed.memory, "{period}");
    }
}

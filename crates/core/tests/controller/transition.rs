//! Another controller for an arm that moves: no joint jumps.

use std::sync::Arc;

use revprio_core::channel::{ChannelConfig, ChannelKind, ChannelState, ChannelTarget};
use revprio_core::controller::{
    Controller, ControllerConfig, Limits, Measurement, Memory, MemoryError, Stepper, TaskConfig, TransitionError,
};
use revprio_core::law::Law;
use revprio_core::limits::{Drive, LimitKind, VelocityBox};
use revprio_core::resolution::{Method, Solver};
use revprio_core::streaming::{Action, Align, ChannelChunk, StreamedChunk, StreamedTarget, StreamedValue};
use revprio_robot::kinematics::Axis;
use revprio_robot::{RobotModel, built_in};

use super::arms::{Random, constant, force, position, task};
use super::drives::LaggingArm;

const PERIOD: f64 = 0.005;
const AXES: [Axis; 6] = [Axis::X, Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];

/// Periods between two changes.
const INTERVAL: u32 = 60;

fn robot(name: &str) -> Arc<RobotModel> {
    built_in().iter().find(|robot| robot.name() == name).cloned().unwrap()
}

/// A task on random axes: a velocity, a position to hold with a random gain, or a force.
fn random_task(name: &str, random: &mut Random) -> TaskConfig {
    let first = random.below(6);
    let axes = &AXES[first..(first + 1 + random.below(2)).min(6)];
    let rows = axes.len();
    let law = match random.below(3) {
        0 => Law::Velocity(constant(&vec![0.3 * random.signed(); rows])),
        1 => position(rows, 1.0 + 8.0 * random.signed().abs()),
        _ => force(axes, &vec![10.0 * random.signed(); rows]),
    };
    TaskConfig { name: name.to_owned(), ..task(axes, law) }
}

/// One to four tasks of five names.
fn random_tasks(random: &mut Random) -> Vec<TaskConfig> {
    let mut names = vec!["a", "b", "c", "d", "e"];
    let drawn: Vec<_> = (0..=random.below(4)).map(|_| names.remove(random.below(names.len()))).collect();
    drawn.into_iter().map(|name| random_task(name, random)).collect()
}

pub(super) fn random_config(robot: &Arc<RobotModel>, limits: &Limits, random: &mut Random) -> ControllerConfig {
    let methods = [Method::ReversePriority, Method::StrictReversePriority, Method::TaskPriority];
    let method = methods[random.below(3)];
    let drive = Drive { lag_s: 0.02, delay_periods: 1 };
    let tasks = random_tasks(random);
    ControllerConfig {
        method,
        limits: limits.clone(),
        drive,
        ..ControllerConfig::new(Arc::clone(robot), PERIOD, tasks)
    }
}

fn measurement(period: u32, q: &[f64], random: &mut Random) -> Measurement {
    let wrench = [0; 6].map(|_| 5.0 * random.signed());
    Measurement {
        channels: Vec::new(),
        chunks: Vec::new(),
        wrenches: Vec::new(),
        obstacles: Vec::new(),
        time_s: f64::from(period) * PERIOD,
        joint_position: q.to_vec(),
        joint_velocity: None,
        wrench,
        targets: Vec::new(),
    }
}

/// What a run with changes shows: changes of velocity relative to A T.
#[derive(Default)]
struct Run {
    /// Largest one in a transition, per period since the last command that arrived.
    largest: f64,
    /// Largest one of the first command after a change that does not continue as a transition.
    untreated: f64,
    /// Periods in transitions.
    periods: u32,
    /// Answers in transitions that are lost.
    lost: u32,
}

/// How the arm of a run differs from one that follows at once.
#[derive(Debug, Clone, Copy)]
struct Faults {
    drive: Drive,
    /// Largest error of a measured position, rad.
    noise: f64,
    /// Whether every third answer of a transition is lost: the arm keeps its last command.
    loses: bool,
}

fn run(robot: &Arc<RobotModel>, limits: &Limits, faults: Faults, seed: u64) -> Run {
    let random = &mut Random(seed);
    let joints = robot.joints();
    let mut q: Vec<f64> = joints.iter().map(|joint| 0.5 * (joint.limits.lower + joint.limits.upper)).collect();
    for q in &mut q {
        *q += 0.3 * random.signed();
    }
    let mut arm = LaggingArm::at_rest(&q, faults.drive, faults.noise, seed);
    let mut stepper = Stepper::new(Controller::new(random_config(robot, limits, random)).unwrap()).unwrap();
    let (mut memory, mut last, mut run) = (None::<Memory>, vec![0.0; joints.len()], Run::default());
    // Periods since the last command that arrived.
    let mut elapsed = 1.0;
    for period in 0..8 * INTERVAL {
        let Measurement { joint_position, .. } = arm.measure(0.0);
        let measured = measurement(period, &joint_position, random);
        if period % INTERVAL == 0
            && let Some(old) = &memory
        {
            let controller = Controller::new(random_config(robot, limits, random)).unwrap();
            let changed = controller.continue_from(stepper.controller(), old, &joint_position).unwrap();
            stepper = Stepper::new(controller).unwrap();
            let mut jumps = Some(Memory { in_transition: false, ..changed.clone() });
            let command = stepper.step(&mut jumps, &measured).unwrap();
            run.untreated =
                run.untreated.max(largest_change(robot, &last, command.resolution.joint_velocity.as_slice()));
            memory = Some(changed);
        }
        let before = memory.clone().filter(|memory| memory.in_transition);
        let is_transition = before.is_some();
        let command = stepper.step(&mut memory, &measured).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        let has_conflicts = !command.limit_conflicts.is_empty();
        if let (Some(before), Some(after)) = (before, &memory) {
            assert_ends_as_requested(&mut stepper, &before, &measured, after);
        }
        if faults.loses && is_transition && period % 3 == 1 {
            (elapsed, run.lost) = (elapsed + 1.0, run.lost + 1);
            arm.follow(&last, PERIOD);
            continue;
        }
        if is_transition && !has_conflicts {
            run.largest = run.largest.max(largest_change(robot, &last, &velocity) / elapsed);
            run.periods += 1;
        }
        arm.follow(&velocity, PERIOD);
        (last, elapsed) = (velocity, 1.0);
    }
    run
}

/// Asserts that a period ends a transition where the controller alone, without the limits of the transition, changes no joint by more
/// than A T, and that its command is then the answer. `after`: the memory after the period.
fn assert_ends_as_requested(stepper: &mut Stepper, before: &Memory, measured: &Measurement, after: &Memory) {
    let robot = Arc::clone(&stepper.controller().config().robot);
    let mut alone = Some(Memory { in_transition: false, ..before.clone() });
    let requested = stepper.step(&mut alone, measured).unwrap().resolution.joint_velocity.clone();
    let change = largest_change(&robot, before.last_command.as_slice(), requested.as_slice());
    assert_eq!(after.in_transition, change > 1.0, "{change}");
    let difference = (&after.last_command - &requested).amax();
    assert!(
        after.in_transition || difference < 1e-12,
        "the command differs by {difference} from that of the controller"
    );
}

/// Returns the largest change of a joint's velocity in a period, relative to A T.
fn largest_change(robot: &RobotModel, last: &[f64], velocity: &[f64]) -> f64 {
    let changes = last.iter().zip(velocity).zip(robot.joints());
    changes.map(|((last, now), joint)| (now - last).abs() / (joint.limits.acceleration * PERIOD)).fold(0.0, f64::max)
}

#[test]
fn no_joint_exceeds_its_acceleration_while_tasks_change() {
    let stated = Drive { lag_s: 0.02, delay_periods: 1 };
    let faults = [
        Faults { drive: Drive::IDEAL, noise: 0.0, loses: false },
        Faults { drive: stated, noise: 1e-4, loses: false },
        Faults { drive: Drive { lag_s: 0.005, delay_periods: 0 }, noise: 1e-4, loses: true },
        Faults { drive: Drive { lag_s: 0.03, delay_periods: 2 }, noise: 1e-4, loses: true },
    ];
    for (name, speed) in [("panda", 1.0), ("sawyer", 0.8), ("ur5e", 1.5)] {
        let robot = robot(name);
        let n = robot.joint_count();
        let fixed = VelocityBox::new(&vec![-speed; n], &vec![speed; n]).unwrap();
        for limits in [
            Limits::Robot(LimitKind::None),
            Limits::Robot(LimitKind::Velocity),
            Limits::Robot(LimitKind::PositionVelocity),
            Limits::Fixed(fixed),
        ] {
            for faults in faults {
                let (mut largest, mut untreated, mut periods, mut lost) = (0.0_f64, 0.0_f64, 0, 0);
                for seed in 1..=12 {
                    let run = run(&robot, &limits, faults, seed);
                    (largest, untreated) = (largest.max(run.largest), untreated.max(run.untreated));
                    (periods, lost) = (periods + run.periods, lost + run.lost);
                }
                let context = format!("{name} {limits:?} {faults:?}: {largest} {untreated} {periods} {lost}");
                assert!(largest <= 1.0 + 1e-9, "{context}");
                assert!(untreated > 2.0, "the tasks of this test do not jump: {context}");
                assert!(periods > 100 && (lost > 50) == faults.loses, "{context}");
            }
        }
    }
}

#[test]
fn a_transition_ends_and_the_arm_then_moves_as_with_the_new_controller_alone() {
    let robot = robot("panda");
    let config = |velocity: f64| {
        let tasks = vec![task(&[Axis::X], Law::Velocity(constant(&[velocity])))];
        let limits = Limits::Robot(LimitKind::Velocity);
        let config = ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks);
        // The measured arm does not move.
        Controller::new(ControllerConfig { limits, drive: Drive::IDEAL, ..config }).unwrap()
    };
    let random = &mut Random(5);
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let (old, new) = (config(0.3), config(-0.3));
    let (mut memory, measured) = (None, measurement(0, &q, random));
    Stepper::new(old.clone()).unwrap().step(&mut memory, &measured).unwrap();
    let mut memory = Some(new.continue_from(&old, memory.as_ref().unwrap(), &q).unwrap());
    let mut stepper = Stepper::new(new.clone()).unwrap();
    let mut periods = 0;
    while memory.as_ref().is_some_and(|memory| memory.in_transition) {
        stepper.step(&mut memory, &measured).unwrap();
        periods += 1;
        assert!(periods < 400, "the transition does not end");
    }
    assert!(periods > 2, "{periods} periods");
    let after = stepper.step(&mut memory, &measured).unwrap().resolution.joint_velocity.clone();
    let mut alone = Stepper::new(new).unwrap();
    let expected = &alone.step(&mut None, &measured).unwrap().resolution.joint_velocity;
    assert!((after - expected).amax() < 1e-12);
}

#[test]
fn laws_that_integrate_continue_from_the_achieved_velocity() {
    let robot = robot("panda");
    let config = |tasks| Controller::new(ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks)).unwrap();
    let push = || TaskConfig { name: "push".to_owned(), ..task(&[Axis::X], force(&[Axis::X], &[20.0])) };
    let hold = || TaskConfig { name: "hold".to_owned(), ..task(&[Axis::Z], position(1, 2.0)) };
    let (old, new) = (config(vec![push()]), config(vec![hold(), push()]));
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let mut stepper = Stepper::new(old).unwrap();
    let mut memory = None;
    for period in 0..20 {
        let measured = Measurement { wrench: [0.0; 6], ..measurement(period, &q, &mut Random(1)) };
        stepper.step(&mut memory, &measured).unwrap();
    }
    let memory = memory.unwrap();
    let continued = new.continue_from(stepper.controller(), &memory, &q).unwrap();
    assert!(memory.task_velocities[0][0] > 1e-3);
    // The controller without positions took the Jacobian at q, the new one takes it at the position of rest.
    let (continued_velocity, velocity) = (continued.task_velocities[1][0], memory.task_velocities[0][0]);
    assert!((continued_velocity / velocity - 1.0).abs() < 0.02, "{continued_velocity} {velocity}");
    assert_eq!(continued.last_command, memory.last_command);
    assert!(!continued.in_transition, "the default limits contain accelerations");
}

#[test]
fn what_belongs_to_the_arm_cannot_change() {
    let (panda, sawyer) = (robot("panda"), robot("sawyer"));
    let config = |robot: &Arc<RobotModel>| {
        ControllerConfig::new(Arc::clone(robot), PERIOD, vec![task(&[Axis::X], position(1, 2.0))])
    };
    let old = Controller::new(config(&panda)).unwrap();
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let mut memory = None;
    Stepper::new(old.clone()).unwrap().step(&mut memory, &measurement(0, &q, &mut Random(1))).unwrap();
    let memory = memory.unwrap();
    let refused = |config| Controller::new(config).unwrap().continue_from(&old, &memory, &q).unwrap_err();
    assert_eq!(refused(config(&sawyer)), TransitionError::Robot);
    let period = TransitionError::Period { old: PERIOD, new: 0.01 };
    assert_eq!(refused(ControllerConfig { period_s: 0.01, ..config(&panda) }), period);
    assert_eq!(refused(ControllerConfig { drive: Drive::IDEAL, ..config(&panda) }), TransitionError::Drive);
    let ignores = ControllerConfig { solver: Solver::ClosedForm, ..config(&panda) };
    assert_eq!(refused(ignores), TransitionError::IgnoresLimits);
    let damaged = Memory { last_command: memory.last_command.clone() * f64::NAN, ..memory.clone() };
    let error = old.continue_from(&old, &damaged, &q).unwrap_err();
    assert_eq!(error, TransitionError::Memory(MemoryError::LastCommand));
}

/// Another target of the controller takes the place of a streamed velocity or force.
#[test]
fn a_stream_ends_with_another_target_of_the_controller() {
    let config = |law| {
        let task = TaskConfig { name: "steer".to_owned(), ..task(&[Axis::X], law) };
        Controller::new(ControllerConfig::new(robot("panda"), PERIOD, vec![task])).unwrap()
    };
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let velocity = |value: f64| Law::Velocity(constant(&[value]));
    let force = |value: f64| force(&[Axis::X], &[value]);
    let cases: [(&dyn Fn(f64) -> Law, StreamedValue); 2] =
        [(&velocity, StreamedValue::Velocity(vec![0.02])), (&force, StreamedValue::Force(vec![3.0]))];
    for (law, value) in cases {
        let old = config(law(0.0));
        let target = StreamedTarget { task: 0, time_s: 0.0, value, velocity: None, ahead: Vec::new() };
        let mut memory = None;
        let measured = Measurement { targets: vec![target], wrench: [0.0; 6], ..measurement(0, &q, &mut Random(1)) };
        Stepper::new(old.clone()).unwrap().step(&mut memory, &measured).unwrap();
        let streams =
            |new: Law| config(new).continue_from(&old, memory.as_ref().unwrap(), &q).unwrap().target_streams.len();
        assert_eq!([streams(law(0.0)), streams(law(0.01))], [1, 0]);
    }
}

/// A number in newtons is no opening of a gripper.
#[test]
fn a_channel_of_another_kind_starts_anew() {
    let config = |kind, target: f64| {
        let channel = ChannelConfig {
            name: "gripper".to_owned(),
            kind,
            lower: 0.0,
            upper: 40.0,
            max_rate: 1e3,
            target: Some(constant(&[target])),
        };
        let tasks = vec![task(&[Axis::X], position(1, 2.0))];
        let config = ControllerConfig::new(robot("panda"), PERIOD, tasks);
        Controller::new(ControllerConfig { channels: vec![channel], ..config }).unwrap()
    };
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let old = config(ChannelKind::Force, 30.0);
    let mut memory = None;
    Stepper::new(old.clone()).unwrap().step(&mut memory, &measurement(0, &q, &mut Random(1))).unwrap();
    let kept = |new: &Controller| new.continue_from(&old, memory.as_ref().unwrap(), &q).unwrap().channels;
    assert_eq!(kept(&config(ChannelKind::Force, 20.0)), memory.as_ref().unwrap().channels);
    assert_eq!(kept(&config(ChannelKind::Position, 0.02)), [ChannelState::default()]);
    // A target that a state has brought ends with another target of the controller.
    let streamed = [ChannelTarget { time_s: 0.0, value: 10.0 }];
    memory.as_mut().unwrap().channels[0].targets = streamed.to_vec();
    let targets = |force: f64| {
        let new = config(ChannelKind::Force, force);
        new.continue_from(&old, memory.as_ref().unwrap(), &q).unwrap().channels[0].targets.clone()
    };
    assert_eq!((targets(30.0), targets(20.0)), (streamed.to_vec(), vec![]));
}

/// A gripper whose chunk ends with its task stays where it is, and goes on while another task follows a chunk.
#[test]
fn a_channel_stays_where_its_chunk_ends() {
    let config = |names: &[&str]| {
        let channel = ChannelConfig {
            name: "gripper".to_owned(),
            kind: ChannelKind::Position,
            lower: 0.0,
            upper: 0.08,
            max_rate: 1.0,
            target: None,
        };
        let named =
            |(name, axis): (&&str, &Axis)| TaskConfig { name: (*name).to_owned(), ..task(&[*axis], position(1, 2.0)) };
        let tasks = names.iter().zip(&[Axis::X, Axis::Y]).map(named).collect();
        let config = ControllerConfig::new(robot("panda"), PERIOD, tasks);
        Controller::new(ControllerConfig { channels: vec![channel], ..config }).unwrap()
    };
    let chunk = |task: usize| {
        let at = |time_s: f64| {
            let position = if task == 0 { [0.5, 0.0, 0.0] } else { [0.0, 0.1, 0.0] };
            Action { time_s, value: StreamedValue::Pose { position: Some(position.into()), orientation: None } }
        };
        let actions = vec![at(0.0), at(1.0)];
        StreamedChunk { task, actions, align: Align::Time, channels: Vec::new() }
    };
    let opening = [(0.0, 0.0), (1.0, 0.08)].map(|(time_s, value)| ChannelTarget { time_s, value });
    let q = [0.0, -0.5, 0.0, -2.0, 0.0, 1.5, 0.8];
    let old = config(&["reach", "side"]);
    let kept = |chunks: Vec<StreamedChunk>, new: &Controller| {
        let mut memory = None;
        let measured = Measurement { chunks, ..measurement(0, &q, &mut Random(1)) };
        Stepper::new(old.clone()).unwrap().step(&mut memory, &measured).unwrap();
        new.continue_from(&old, memory.as_ref().unwrap(), &q).unwrap().channels[0].clone()
    };
    let with_channel =
        StreamedChunk { channels: vec![ChannelChunk { channel: 0, targets: opening.to_vec() }], ..chunk(0) };
    let ended = kept(vec![with_channel.clone()], &config(&["other"]));
    assert_eq!((ended.command, ended.targets), (Some(0.0), vec![opening[0]]));
    let followed = kept(vec![with_channel.clone()], &config(&["reach"]));
    assert_eq!(followed.targets, opening);
    let followed = kept(vec![with_channel, chunk(1)], &config(&["other", "side"]));
    assert_eq!(followed.targets, opening);
}

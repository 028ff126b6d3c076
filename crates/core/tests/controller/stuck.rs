//! Tasks that make no progress, the motion that leaves such postures, and the posture that circles return to.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{
    Controller, ControllerConfig, Measurement, Memory, NullSpaceMotion, Obstacle, Stepper, TaskConfig,
};
use revprio_core::law::Profile;
use revprio_core::limits::Drive;
use revprio_core::linalg::Vector;
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::{StreamedTarget, StreamedValue};
use revprio_robot::kinematics::{Axis, Configuration, orientation_error};
use revprio_robot::{RobotModel, built_in};

use super::arms::{Random, force, position, task, tool_rows};

const LINEAR: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];
const ANGULAR: [Axis; 3] = [Axis::Rx, Axis::Ry, Axis::Rz];
const PERIOD: f64 = 0.02;

fn panda() -> Arc<RobotModel> {
    built_in().iter().find(|robot| robot.name() == "panda").cloned().unwrap()
}

fn random_posture(robot: &RobotModel, share: f64, random: &mut Random) -> Vec<f64> {
    let limits = robot.joints().iter().map(|joint| joint.limits);
    limits.map(|l| f64::midpoint(l.lower, l.upper) + 0.5 * share * (l.upper - l.lower) * random.signed()).collect()
}

fn towards(axes: &[Axis], pose: IsometryMatrix3<f64>) -> TaskConfig {
    let rows = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(pose), ..tool_rows(axes) });
    TaskConfig { rows, ..task(axes, position(axes.len(), 2.0)) }
}

/// Position above orientation.
fn split(robot: &Arc<RobotModel>, pose: IsometryMatrix3<f64>) -> ControllerConfig {
    let tasks = vec![towards(&LINEAR, pose), towards(&ANGULAR, pose)];
    ControllerConfig { drive: Drive::IDEAL, ..ControllerConfig::new(Arc::clone(robot), PERIOD, tasks) }
}

/// A run of an arm that follows its commands at once.
struct Run {
    q: Vec<f64>,
    /// Sets of obstacles that were named, in order.
    held_by: Vec<&'static [Obstacle]>,
    attempts: u32,
    is_stuck: bool,
}

fn run(config: ControllerConfig, start: &[f64], duration: f64) -> Run {
    let (joints, period) = (config.robot.joint_count(), config.period_s);
    let limits: Vec<_> = config.robot.joints().iter().map(|joint| joint.limits).collect();
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut memory = None;
    let mut run = Run { q: start.to_vec(), held_by: Vec::new(), attempts: 0, is_stuck: false };
    let mut last = Vector::zeros(joints);
    for i in (0..100_000_u32).take_while(|i| f64::from(*i) * period < duration) {
        let measured = Measurement {
            channels: Vec::new(),
            chunks: Vec::new(),
            wrenches: Vec::new(),
            obstacles: Vec::new(),
            time_s: f64::from(i) * period,
            joint_position: run.q.clone(),
            joint_velocity: None,
            wrench: [0.0; 6],
            targets: Vec::new(),
        };
        let command = stepper.step(&mut memory, &measured).unwrap();
        run.is_stuck = !command.stuck.is_empty();
        for stuck in &command.stuck {
            assert!(stuck.since_s <= measured.time_s);
            assert!(stuck.leaving || !stuck.held_by.is_empty());
            if run.held_by.last() != Some(&stuck.held_by) && !stuck.held_by.is_empty() {
                run.held_by.push(stuck.held_by);
            }
        }
        let velocity = &command.resolution.joint_velocity;
        for ((q, limit), (now, before)) in run.q.iter_mut().zip(&limits).zip(velocity.iter().zip(&last)) {
            assert!((now - before).abs() <= limit.acceleration * period * (1.0 + 1e-9) || i == 0);
            *q += period * now;
            assert!((limit.lower - 1e-9..=limit.upper + 1e-9).contains(q));
        }
        last.copy_from(velocity);
    }
    run.attempts = memory.unwrap().progress.iter().map(|progress| progress.attempts).sum();
    run
}

fn is_at(robot: &RobotModel, q: &[f64], pose: &IsometryMatrix3<f64>) -> bool {
    let tool = *Configuration::new(robot, q).unwrap().tool_pose();
    let distance = (tool.translation.vector - pose.translation.vector).norm();
    distance < 1e-2 && orientation_error(&pose.rotation, &tool.rotation).norm() < 1e-2
}

/// Another controller, or a target that streams, ends the motion that leaves a posture.
#[test]
fn a_motion_that_leaves_a_posture_ends_with_what_asked_for_it() {
    let robot = panda();
    let mut random = Random(1);
    let mut left = 0;
    for _ in 0..16 {
        let start = random_posture(&robot, 1.0, &mut random);
        let target = random_posture(&robot, 0.8, &mut random);
        let pose = *Configuration::new(&robot, &target).unwrap().tool_pose();
        let mut stepper = Stepper::new(Controller::new(split(&robot, pose)).unwrap()).unwrap();
        let (mut memory, mut q) = (None, start);
        for i in 0..1000_u32 {
            let mut state = super::arms::measurement(&q);
            state.time_s = f64::from(i) * PERIOD;
            let command = stepper.step(&mut memory, &state).unwrap();
            let leaves = command.stuck.iter().any(|stuck| stuck.leaving);
            let velocity = command.resolution.joint_velocity.clone();
            if leaves {
                left += 1;
                let known = memory.clone().unwrap();
                assert!(known.progress.iter().any(|progress| progress.leaving_since_s.is_some()));
                let next = Controller::new(split(&robot, pose)).unwrap();
                let kept = next.continue_from(stepper.controller(), &known, &q).unwrap();
                assert!(kept.progress.iter().all(|progress| progress.leaving_since_s.is_none()));
                // Nor does it begin again at once.
                let mut followed = Some(kept);
                let mut later = super::arms::measurement(&q);
                later.time_s = state.time_s + PERIOD;
                Stepper::new(next).unwrap().step(&mut followed, &later).unwrap();
                assert!(followed.unwrap().progress.iter().all(|progress| progress.leaving_since_s.is_none()));
                let task = leaving_task(&known);
                let value = StreamedValue::Pose { position: None, orientation: Some(pose.rotation.into()) };
                state.time_s += PERIOD;
                state.targets =
                    vec![StreamedTarget { task, time_s: state.time_s, value, velocity: None, ahead: Vec::new() }];
                let mut streamed = Some(known);
                stepper.step(&mut streamed, &state).unwrap();
                assert!(streamed.unwrap().progress[task].leaving_since_s.is_none());
                break;
            }
            q.iter_mut().zip(&velocity).for_each(|(q, speed)| *q += PERIOD * speed);
        }
    }
    assert!(left > 3, "{left} of 16");
}

/// Returns the task that leaves its posture.
fn leaving_task(memory: &Memory) -> usize {
    memory.progress.iter().position(|progress| progress.leaving_since_s.is_some()).unwrap()
}

#[test]
fn random_poses_are_reached_from_postures_in_which_limits_hold_the_orientation() {
    let robot = panda();
    let mut random = Random(1);
    let (mut reached, mut reached_without, mut said) = (0, 0, 0);
    for _ in 0..16 {
        let start = random_posture(&robot, 1.0, &mut random);
        let target = random_posture(&robot, 0.8, &mut random);
        let pose = *Configuration::new(&robot, &target).unwrap().tool_pose();
        let with = run(split(&robot, pose), &start, 60.0);
        let without = run(ControllerConfig { leave_local_minima: false, ..split(&robot, pose) }, &start, 60.0);
        reached += u32::from(is_at(&robot, &with.q, &pose));
        let is_reached = is_at(&robot, &without.q, &pose);
        reached_without += u32::from(is_reached);
        said += u32::from(!is_reached && without.is_stuck);
        assert_eq!(without.attempts, 0);
        assert!(is_reached || without.is_stuck, "not at the target, and nothing was said: {start:?}");
    }
    println!(
        "reached {reached} of 16 poses, {reached_without} without leaving; {said} of the others were said to be stuck"
    );
    assert!(said > 4 && reached >= reached_without + 5, "{reached} of 16, without leaving {reached_without}");
}

/// A posture of a Panda far from limits and singularities.
const READY: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

/// Returns how far the joints of a Panda are from their start after 100 circles of 10 cm in 5 s with a null-space motion
/// or without one, rad.
fn drift(drive: Drive, null_space: impl Fn(&ControllerConfig) -> Option<NullSpaceMotion>) -> f64 {
    let rate = std::f64::consts::TAU / 5.0;
    let circle = |axes: &[Axis], radius: f64, phase: f64| {
        let (mut offset, mut amplitude) = (vec![0.0; axes.len()], vec![0.0; axes.len()]);
        (offset[0], amplitude[0]) = (-radius * phase.sin(), radius);
        let target_displacement = Some(Profile::sine(offset, amplitude, rate, phase).unwrap());
        let rows = TaskRows::Tool(ToolRows { target_displacement, ..tool_rows(axes) });
        TaskConfig { rows, ..task(axes, position(axes.len(), 2.0)) }
    };
    let rest = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![circle(&[Axis::X], 0.1, 0.0), circle(&rest, 0.1, std::f64::consts::FRAC_PI_2)];
    let config = ControllerConfig { drive, ..ControllerConfig::new(panda(), PERIOD, tasks) };
    let end = run(ControllerConfig { null_space: null_space(&config), ..config }, &READY, 500.0).q;
    end.iter().zip(&READY).map(|(q, start)| (q - start).abs()).fold(0.0, f64::max)
}

#[test]
fn circles_do_not_drift_by_default() {
    for drive in [Drive::IDEAL, Drive::CONSERVATIVE] {
        let held = drift(drive, |config| config.null_space.clone());
        println!("100 circles drift by {held:.4} rad with {drive:?}");
        assert!(held < 0.01, "{held} rad with {drive:?}");
    }
    let free = drift(Drive::IDEAL, |_| None);
    println!("without a null-space motion by {free:.4} rad");
    assert!(free > 2.0, "without a null-space motion {free} rad");
}

#[test]
fn the_default_null_space_motion_needs_redundancy_and_tasks_that_follow_positions() {
    let default = |tasks: Vec<TaskConfig>| ControllerConfig::new(panda(), PERIOD, tasks).null_space;
    let here = IsometryMatrix3::identity();
    let fast = Some(NullSpaceMotion::InitialPosture { gain: 2.0 });
    assert_eq!(default(vec![towards(&LINEAR, here)]), fast);
    assert_eq!(default(vec![towards(&LINEAR, here), towards(&ANGULAR, here)]), fast);
    assert_eq!(default(vec![towards(&LINEAR, here), towards(&ANGULAR, here), towards(&LINEAR, here)]), None);
    assert_eq!(default(vec![towards(&LINEAR, here), task(&ANGULAR[..1], force(&ANGULAR[..1], &[1.0]))]), None);
    let tasks = [towards(&LINEAR, here)];
    let slow = NullSpaceMotion::default_for(&panda(), &tasks, Drive { lag_s: 0.5, delay_periods: 0 }, 0.1);
    assert_eq!(slow, Some(NullSpaceMotion::InitialPosture { gain: 1.0 / 3.0 / 0.6 }));
}

/// Runs a Panda from [`READY`] with these tasks.
fn ready(tasks: Vec<TaskConfig>) -> Run {
    run(ControllerConfig { drive: Drive::IDEAL, ..ControllerConfig::new(panda(), PERIOD, tasks) }, &READY, 12.0)
}

fn displaced(by: Vector3<f64>) -> IsometryMatrix3<f64> {
    let pose = *Configuration::new(&panda(), &READY).unwrap().tool_pose();
    IsometryMatrix3::from_parts((pose.translation.vector + by).into(), pose.rotation)
}

#[test]
fn a_task_against_a_higher_one_is_named() {
    let (here, there) = (displaced(Vector3::zeros()), displaced(Vector3::new(0.0, 0.1, 0.0)));
    let run = ready(vec![towards(&LINEAR, here), towards(&[Axis::Y], there)]);
    assert_eq!((run.held_by, run.attempts, run.is_stuck), (vec![&[Obstacle::HigherTasks][..]], 0, true));
}

#[test]
fn a_target_out_of_reach_is_named() {
    let run = ready(vec![towards(&LINEAR, displaced(Vector3::new(2.0, 0.0, 0.0)))]);
    assert!(run.is_stuck && run.attempts == 0, "{:?}", run.held_by);
}

#[test]
fn no_task_that_reaches_its_target_is_named() {
    let run = ready(vec![
        towards(&LINEAR, displaced(Vector3::new(0.0, 0.2, 0.1))),
        towards(&ANGULAR, displaced(Vector3::zeros())),
    ]);
    assert_eq!((run.held_by, run.is_stuck), (Vec::new(), false));
}

#[test]
fn an_arm_in_contact_does_not_leave_its_posture() {
    let (robot, mut random) = (panda(), Random(1));
    for _ in 0..16 {
        let start = random_posture(&robot, 1.0, &mut random);
        let pose = *Configuration::new(&robot, &random_posture(&robot, 0.8, &mut random)).unwrap().tool_pose();
        let push = task(&[Axis::X], force(&[Axis::X], &[0.0]));
        let tasks = vec![push, towards(&LINEAR[1..], pose), towards(&ANGULAR, pose)];
        let config =
            ControllerConfig { drive: Drive::IDEAL, ..ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks) };
        assert_eq!(run(config, &start, 15.0).attempts, 0);
    }
}

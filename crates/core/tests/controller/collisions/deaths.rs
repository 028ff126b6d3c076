//! Services that fall silent while the arm is near obstacles.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::collision::{CollisionAvoidance, Obstacle};
use revprio_core::constraint::Constraint;
use revprio_core::controller::{Controller, ControllerConfig, Measurement, Memory, Stepper};
use revprio_core::law::{Law, Profile};
use revprio_core::limits::{Drive, braking_deceleration};
use revprio_core::streaming::StreamedTarget;
use revprio_robot::collision::{LinkCapsule, Segment};
use revprio_robot::kinematics::Axis;
use revprio_robot::{Joint, JointLimits, RobotModel};

use super::super::arms::{Random, gantry, position, task};
use super::super::drives::LaggingArm;
use super::{HOME, NEAREST, Setup, config, nearest, obstacles, panda, panda_with_jerk, targets};

/// What the deaths of a service in one motion show.
#[derive(Debug)]
struct Deaths {
    count: u32,
    /// In periods whose command is valid for that period only.
    short: u32,
    /// Smallest distance less d_min, m, where the answers say that no stop comes too near.
    margin: f64,
    /// The same where answers say that one does.
    violated_margin: f64,
    /// In the 30 periods after a change of the tasks.
    after_change: u32,
    /// Largest change of a joint's velocity in a period, relative to A T.
    largest_change: f64,
}

impl Default for Deaths {
    fn default() -> Self {
        Self {
            count: 0,
            short: 0,
            margin: f64::INFINITY,
            violated_margin: f64::INFINITY,
            after_change: 0,
            largest_change: 0.0,
        }
    }
}

impl Deaths {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.short += other.short;
        self.margin = self.margin.min(other.margin);
        self.violated_margin = self.violated_margin.min(other.violated_margin);
        self.after_change += other.after_change;
        self.largest_change = self.largest_change.max(other.largest_change);
    }
}

/// Returns the smallest distance less d_min, m, of an arm whose watchdog holds a command (n) for a time (s), then brakes.
fn margin_of_a_death(
    robot: &RobotModel,
    obstacles: &[Obstacle],
    mut arm: LaggingArm,
    (command, valid_s, period): (&[f64], f64, f64),
    min_distance: f64,
) -> f64 {
    let distances = (0..600).map(|k| {
        let late = (f64::from(k + 1) * period - valid_s).max(0.0);
        let ramp =
            |(u, joint): (&f64, &Joint)| (u.abs() - braking_deceleration(&joint.limits) * late).max(0.0).copysign(*u);
        let sent: Vec<f64> = command.iter().zip(robot.joints()).map(ramp).collect();
        arm.follow(&sent, period);
        nearest(robot, obstacles, &arm.q) - min_distance
    });
    distances.fold(f64::INFINITY, f64::min)
}

/// Returns the stepper of a controller with tasks in another order and other gains, and what it remembers of the arm.
fn other_tasks(old: &Stepper, memory: &Memory, measured: &Measurement, random: &mut Random) -> (Stepper, Memory) {
    let old = old.controller();
    let mut config = old.config().clone();
    config.tasks.reverse();
    for task in &mut config.tasks {
        let rows = if task.name == "tool" { 3 } else { config.robot.joint_count() };
        task.law = position(rows, 3.0 + 15.0 * random.unit());
    }
    if random.below(3) == 0 {
        let tool = config.tasks.iter().position(|task| task.name == "tool").unwrap();
        config.tasks[tool].law = Law::Velocity(Profile::constant(vec![0.5 * random.signed(); 3]).unwrap());
    }
    let controller = Controller::new(config).unwrap();
    let memory = controller.continue_from(old, memory, &measured.joint_position).unwrap();
    (Stepper::new(controller).unwrap(), memory)
}

/// How often the tasks of a motion change.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Tasks {
    Stay,
    /// Every 0.15 s.
    Change,
}

/// The service falls silent at any time. The watchdog of the arm holds the last command while it is valid, then it brakes.
fn deaths(robot: &Arc<RobotModel>, (setup, tasks): (Setup, Tasks)) -> Deaths {
    let obstacles = obstacles(false);
    let mut stepper = Stepper::new(Controller::new(config(robot, Setup { seed: 1, ..setup })).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, setup.drive, setup.noise, 1);
    let (mut random, mut memory) = (Random(setup.seed), None);
    let (mut found, mut last) = (Deaths::default(), vec![0.0; robot.joint_count()]);
    for i in 0..4000_u32 {
        let time_s = f64::from(i) * setup.period;
        let mut measured = arm.measure(time_s);
        if let Some(old) = memory.as_ref().filter(|_| tasks == Tasks::Change && i % 150 == 100) {
            let (next, known) = other_tasks(&stepper, old, &measured, &mut random);
            (stepper, memory) = (next, Some(known));
        }
        if i % 400 == 0 {
            let known = &stepper.controller().config().tasks;
            let is_streamed = |target: &StreamedTarget| matches!(known[target.task].law, Law::Position(_));
            measured.targets = targets(robot, known, time_s, &mut random);
            measured.targets.retain(is_streamed);
        }
        let command = stepper.step(&mut memory, &measured).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        for ((now, last), joint) in velocity.iter().zip(&last).zip(robot.joints()) {
            let change = (now - last).abs() / (joint.limits.acceleration * setup.period);
            found.largest_change = found.largest_change.max(change);
        }
        let moves = velocity.iter().any(|u| u.abs() > 0.3);
        let is_violated = command.collisions.as_ref().unwrap().is_violated;
        let valid_s = command.hold.valid_for_ms(100) as f64 / 1e3;
        assert!(valid_s >= setup.period, "period {i}: valid for {valid_s} s");
        let is_short = valid_s == setup.period;
        if is_short || (i % 7 == 0 && moves) {
            found.count += 1;
            found.short += u32::from(is_short);
            found.after_change += u32::from(tasks == Tasks::Change && i >= 100 && (i - 100) % 150 < 30);
            let death = (velocity.as_slice(), valid_s, setup.period);
            let margin = margin_of_a_death(robot, &obstacles, arm.clone(), death, NEAREST);
            let least = if is_violated { &mut found.violated_margin } else { &mut found.margin };
            *least = least.min(margin);
        }
        arm.follow(&velocity, setup.period);
        last = velocity;
    }
    found
}

/// The same with one seed, without noise and with the same tasks.
fn deaths_in_one_motion(robot: &Arc<RobotModel>, seed: u64) -> Deaths {
    deaths(robot, (Setup { seed, ..Setup::default() }, Tasks::Stay))
}

#[test]
fn an_arm_whose_service_dies_keeps_clear() {
    for (with_jerk, seed) in [(false, 3), (true, 3), (true, 4)] {
        let found = deaths_in_one_motion(&panda(with_jerk), seed);
        let margin = found.margin.min(found.violated_margin);
        assert!(found.count > 100 && found.short > 5 && margin >= -1e-6, "jerk limits {with_jerk}: {found:?}");
    }
}

#[test]
fn an_arm_whose_service_dies_while_its_tasks_change_keeps_clear() {
    for (with_jerk, noise, seed) in [(false, 0.0, 5), (true, 0.0, 6), (false, 1e-4, 7)] {
        let found = deaths(&panda(with_jerk), (Setup { noise, seed, ..Setup::default() }, Tasks::Change));
        let margin = found.margin.min(found.violated_margin);
        let context = format!("jerk limits {with_jerk}, noise {noise} rad: {found:?}");
        assert!(found.count > 100 && found.after_change > 50, "{context}");
        assert!(margin >= -1e-6 - 5.0 * noise && found.largest_change <= 1.0 + 1e-9, "{context}");
    }
}

/// A watchdog brakes otherwise than joints with slow jerk limits, so there are states in which no command has a stop of a watchdog that keeps clear.
#[test]
fn an_answer_says_where_a_service_that_dies_brings_an_arm_too_near() {
    let mut all = Deaths::default();
    for seed in 2..=3 {
        all.add(&deaths_in_one_motion(&panda_with_jerk(|limits| limits.acceleration / 0.02), seed));
    }
    assert!(all.margin >= -1e-6, "{all:?}");
    assert!(all.violated_margin < -1e-6, "no such state was met; other seeds may find one: {all:?}");
}

/// Returns a gantry that brakes slowly along x, and fast along y and z; its tool is a ball.
fn uneven_gantry() -> Arc<RobotModel> {
    let limits = JointLimits { lower: -1.0, upper: 1.0, velocity: 1.0, acceleration: 20.0, ..JointLimits::NONE };
    let mut joints = gantry(limits).joints().to_vec();
    (joints[0].limits.upper, joints[0].limits.acceleration) = (0.3, 1.0);
    let robot = RobotModel::new("uneven_gantry", "", joints, IsometryMatrix3::identity()).unwrap();
    let link = robot.link(&robot.links().last().unwrap().name).unwrap();
    let ball = LinkCapsule { link, core: Segment { from: Vector3::zeros(), to: Vector3::zeros() }, radius: 0.01 };
    Arc::new(robot.with_capsules(vec![ball], &[]).unwrap())
}

#[test]
fn an_arm_keeps_clear_while_it_is_held_until_a_joint_must_brake_for_its_range() {
    // The stop after one period passes on one side of the post, and that after the longest hold on the other one.
    let (robot, period, drive) = (uneven_gantry(), 0.008, Drive { lag_s: 0.03, delay_periods: 2 });
    let post = [Obstacle::new("post", super::capsule([0.25, 0.0, -0.2], [0.25, 0.0, 0.2], 0.005), false).unwrap()];
    let (min_distance, mut shortened) = (0.005, 0);
    for run in 0..16 {
        let avoidance = CollisionAvoidance {
            min_distance_m: min_distance,
            obstacles: post.to_vec(),
            ..CollisionAvoidance::default()
        };
        let config = ControllerConfig {
            drive,
            constraints: vec![Constraint::Distances(avoidance)],
            ..ControllerConfig::new(Arc::clone(&robot), period, vec![task(&[Axis::X, Axis::Y], to_the_upper_right())])
        };
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let mut arm = LaggingArm::at_rest(&[-0.05, -0.95 + 0.03 * f64::from(run), 0.0], drive, 0.0, 1);
        let mut memory = None;
        for i in 0..150_u32 {
            let command = stepper.step(&mut memory, &arm.measure(f64::from(i) * period)).unwrap();
            let velocity = command.resolution.joint_velocity.as_slice().to_vec();
            let valid_s = command.hold.valid_for_ms(100) as f64 / 1e3;
            let death = (velocity.as_slice(), valid_s, period);
            let margin = margin_of_a_death(&robot, &post, arm.clone(), death, min_distance);
            assert!(margin >= -1e-6, "run {run}, period {i}: {margin} after {valid_s} s");
            shortened += u32::from(valid_s > period && valid_s < 0.1);
            arm.follow(&velocity, period);
        }
    }
    assert!(shortened > 50, "{shortened} commands were held until a joint must brake");
}

fn to_the_upper_right() -> Law {
    Law::Velocity(Profile::constant(vec![0.5, 1.0]).unwrap())
}

#[test]
#[ignore = "asserts nothing; 80 motions take minutes; prints what docs/collisions.md says about a service that dies"]
fn table_of_deaths() {
    let seeds = std::env::var("SEEDS").map_or(4, |text| text.parse().unwrap());
    for with_jerk in [false, true] {
        let mut all = Deaths::default();
        (1..=seeds).for_each(|seed| all.add(&deaths_in_one_motion(&panda(with_jerk), seed)));
        println!("jerk limits {with_jerk}: {all:?}");
    }
}

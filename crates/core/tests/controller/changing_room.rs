//! Obstacles that are added and removed while the arm moves.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::collision::{CollisionAvoidance, Obstacle, ObstacleShape, ObstacleState};
use revprio_core::constraint::Constraint;
use revprio_core::controller::{Controller, ControllerConfig, Stepper, TaskConfig};
use revprio_core::law::Profile;
use revprio_core::limits::Drive;
use revprio_core::linalg::Damping;
use revprio_core::rows::TaskRows;
use revprio_robot::collision::{OrientedBox, PlacedBody, Segment};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{RobotModel, built_in};

use super::arms::{joint_rows, position, task};
use super::drives::LaggingArm;

const PERIOD: f64 = 4e-3;
const NEAREST: f64 = 0.02;
const DRIVE: Drive = Drive { lag_s: 0.02, delay_periods: 2 };
const HOME: [f64; 7] = [0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8];

fn panda() -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == "panda").unwrap())
}

fn hand(q: &[f64]) -> Vector3<f64> {
    Configuration::new(&panda(), q).unwrap().tool_pose().translation.vector
}

/// Returns a wall across y.
fn wall(y: f64) -> Obstacle {
    let pose = IsometryMatrix3::translation(0.0, y, 0.0);
    let shape = ObstacleShape::Box(OrientedBox { pose, half: Vector3::new(2.0, 0.02, 2.0) });
    Obstacle::new("wall", shape, false).unwrap()
}

/// Returns a controller that moves the hand by 0.5 m along y in a room.
fn controller(obstacles: Vec<Obstacle>) -> Controller {
    let mut reach = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 3.0));
    let TaskRows::Tool(rows) = &mut reach.rows else { unreachable!() };
    rows.target_displacement = Some(Profile::constant(vec![0.0, 0.5, 0.0]).unwrap());
    let avoidance = CollisionAvoidance { min_distance_m: NEAREST, obstacles, ..CollisionAvoidance::default() };
    let posture =
        TaskConfig { name: "posture".to_owned(), rows: joint_rows(&HOME), ..task(&[Axis::X], position(7, 1.0)) };
    let tasks = vec![reach, posture];
    let config = ControllerConfig::new(panda(), PERIOD, tasks);
    let constraints = vec![Constraint::Distances(avoidance)];
    let damping = Some(Damping::ARM);
    Controller::new(ControllerConfig { drive: DRIVE, damping, constraints, ..config }).unwrap()
}

/// Returns the distance of the arm from a wall, m.
fn distance(q: &[f64], wall: &Obstacle) -> f64 {
    let robot = panda();
    let model = robot.collision().unwrap();
    let body = PlacedBody::new(model, &Configuration::new(&robot, q).unwrap());
    let ObstacleShape::Box(wall) = wall.shape else { unreachable!() };
    let capsules = model.capsules().iter().enumerate();
    capsules.map(|(k, own)| body.core(k).to_box(&wall).distance - own.radius).fold(f64::INFINITY, f64::min)
}

/// A wall appears before the hand while it moves, where the arm can still stop; later it is taken away. The arm stays clear of it within
/// its acceleration limits, stays before it, and then goes on to its target.
#[test]
fn an_arm_stops_before_an_obstacle_that_is_added_and_goes_on_when_it_is_removed() {
    let start = hand(&HOME);
    let wall = wall(start.y + 0.4);
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1);
    let (mut memory, mut last, mut before) = (None, vec![0.0; 7], HOME.to_vec());
    let mut stepper = Stepper::new(controller(Vec::new())).unwrap();
    for i in 0..1500_u32 {
        let state = arm.measure(f64::from(i) * PERIOD);
        if let Some(obstacles) = match i {
            60 => Some(vec![wall.clone()]),
            700 => Some(Vec::new()),
            _ => None,
        } {
            let next = controller(obstacles);
            memory = memory.map(|memory| next.continue_from(stepper.controller(), &memory, &before).unwrap());
            stepper = Stepper::new(next).unwrap();
        }
        let command = stepper.step(&mut memory, &state).unwrap().resolution.joint_velocity.clone();
        for ((joint, now), earlier) in panda().joints().iter().zip(&command).zip(&last) {
            let rate = (now - earlier).abs() / PERIOD;
            assert!(rate <= joint.limits.acceleration * (1.0 + 1e-9), "period {i}, {}: {rate}", joint.name);
        }
        last = command.as_slice().to_vec();
        before.clone_from(&state.joint_position);
        arm.follow(&last, PERIOD);
        if (60..700).contains(&i) {
            assert!(distance(&arm.q, &wall) > NEAREST - 1e-6, "period {i}: {}", distance(&arm.q, &wall));
        }
        if i == 60 {
            assert!(last.iter().any(|speed| speed.abs() > 0.2), "the arm moves when the wall appears: {last:?}");
        }
        if i == 699 {
            assert!((0.3..0.38).contains(&(hand(&arm.q) - start).y), "the hand is before the wall");
        }
    }
    let left = (hand(&arm.q) - start - Vector3::new(0.0, 0.5, 0.0)).norm();
    assert!(left < 1e-3, "{left} m");
}

/// The ball of the scenario `passing_ball` passes again and again: each time the arm goes out of its way, and returns.
#[test]
fn an_arm_makes_way_for_a_ball_that_passes_often() {
    let shape = ObstacleShape::Capsule { core: Segment { from: Vector3::zeros(), to: Vector3::zeros() }, radius: 0.08 };
    let ball = Obstacle::new("ball", shape, true).unwrap();
    let mut hold = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 3.0));
    hold.name = "hold".to_owned();
    let posture =
        TaskConfig { name: "posture".to_owned(), rows: joint_rows(&HOME), ..task(&[Axis::X], position(7, 1.0)) };
    let avoidance =
        CollisionAvoidance { min_distance_m: NEAREST, obstacles: vec![ball], ..CollisionAvoidance::default() };
    let config = ControllerConfig::new(panda(), PERIOD, vec![hold, posture]);
    let config = ControllerConfig { drive: DRIVE, constraints: vec![Constraint::Distances(avoidance)], ..config };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let start = hand(&HOME);
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1);
    let (mut memory, mut passes) = (None, Vec::new());
    for pass in 0..8 {
        let (mut pushed, mut left) = (0.0_f64, 0.0);
        for i in 0..5000_u32 {
            // 1 m across at 0.2 m/s, 5 cm behind the hand, then 15 s without motion.
            let way = (0.2 * f64::from(i) * PERIOD).min(1.0);
            let speed = if way < 1.0 { 0.2 } else { 0.0 };
            let mut state = arm.measure(f64::from(pass * 5000 + i) * PERIOD);
            state.obstacles = vec![ObstacleState {
                name: "ball".into(),
                position: start + Vector3::new(0.05, way - 0.5, 0.0),
                velocity: Vector3::new(0.0, speed, 0.0),
            }];
            let command = stepper.step(&mut memory, &state).unwrap().resolution.joint_velocity.clone();
            arm.follow(command.as_slice(), PERIOD);
            left = (hand(&arm.q) - start).norm();
            pushed = pushed.max(left);
        }
        passes.push((pushed, left));
    }
    assert!(passes.iter().all(|(pushed, left)| *pushed > 0.03 && *left < 5e-3), "{passes:?}");
}

/// How an arm comes to rest: the time of the last command above 0.1 rad/s, s, and the largest command and the largest change of a command
/// in the last two seconds, rad/s.
#[derive(Debug)]
struct Rest {
    moves_until: f64,
    fastest: f64,
    change: f64,
}

/// Pulls the hand by `way`, m, at a target behind a wall for 10 s.
fn pull(tasks: usize, noise: f64, (wall, way): (&Obstacle, [f64; 3])) -> Rest {
    let mut config = ControllerConfig::clone(controller(vec![wall.clone()]).config());
    config.tasks.truncate(tasks);
    let TaskRows::Tool(rows) = &mut config.tasks[0].rows else { unreachable!() };
    rows.target_displacement = Some(Profile::constant(way.to_vec()).unwrap());
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, noise, 1);
    let (mut memory, mut last) = (None, vec![0.0; 7]);
    let mut rest = Rest { moves_until: 0.0, fastest: 0.0, change: 0.0 };
    for i in 0..2500 {
        let time_s = f64::from(i) * PERIOD;
        let command = stepper.step(&mut memory, &arm.measure(time_s)).unwrap().resolution.joint_velocity.clone();
        let fastest = command.amax();
        if fastest > 0.1 {
            rest.moves_until = time_s;
        }
        if time_s >= 8.0 {
            rest.fastest = rest.fastest.max(fastest);
            let change = command.iter().zip(&last).map(|(now, before)| (now - before).abs()).fold(0.0, f64::max);
            rest.change = rest.change.max(change);
        }
        last = command.as_slice().to_vec();
        arm.follow(&last, PERIOD);
        assert!(distance(&arm.q, wall) > NEAREST - 1e-6 - 5.0 * noise, "{time_s} s: {}", distance(&arm.q, wall));
    }
    rest
}

/// With a posture as the second task the arm rests soon. Without one it first tries what else brings its hand nearer.
#[test]
fn an_arm_that_pulls_at_a_target_behind_a_wall_comes_to_rest() {
    let start = hand(&HOME);
    let walls = [
        (0.4, [0.0, 0.5, 0.0]),
        (0.3, [0.1, 0.6, 0.1]),
        (0.35, [-0.2, 0.5, -0.2]),
        (-0.35, [0.1, -0.5, 0.2]),
        (0.25, [0.2, 0.4, 0.0]),
    ];
    for (tasks, latest) in [(1, 4.0), (2, 2.0)] {
        for noise in [0.0, 1e-4] {
            for (before, way) in walls {
                let rest = pull(tasks, noise, (&wall(start.y + before), way));
                println!("{tasks} tasks, noise {noise}, wall at {before} m: {rest:?}");
                assert!(rest.moves_until < latest && rest.fastest < 0.02 && rest.change < 0.02, "{rest:?}");
            }
        }
    }
}

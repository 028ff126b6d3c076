//! A camera that looks at a point: of the tool, of a link, and of one hand that watches the other.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_core::controller::{
    ConfigError, Controller, ControllerConfig, Limits, Stepper, TaskConfig, TaskConfigError,
};
use revprio_core::law::{Braking, Law, PositionLaw, Profile};
use revprio_core::limits::{Drive, LimitKind};
use revprio_core::rows::{GazeRows, RowsError, TaskRows};
use revprio_core::streaming::Streaming;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Axis, BodyFrame, Configuration, TaskBody};

use super::arms::{Random, force, position, task};
use super::drives::LaggingArm;
use super::two_arms::two_pandas;

const PERIOD: f64 = 4e-3;

const DRIVE: Drive = Drive { lag_s: 0.02, delay_periods: 2 };

const PANDA: [f64; 7] = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

fn panda() -> Arc<RobotModel> {
    Arc::clone(revprio_robot::built_in().iter().find(|robot| robot.name() == "panda").unwrap())
}

fn constant(point: Vector3<f64>) -> Profile {
    Profile::constant(point.as_slice().to_vec()).unwrap()
}

fn look(body: Option<TaskBody>, target: Profile, law: Law) -> TaskConfig {
    let rows = GazeRows::new(body, Vector3::new(0.0, 0.02, 0.05), Vector3::z(), target).unwrap();
    let name = "look".to_owned();
    TaskConfig { name, rows: TaskRows::Gaze(rows), law, scaled: false, streaming: Streaming::default() }
}

fn gain(gain: f64) -> Law {
    Law::Position(PositionLaw::new(vec![gain; 2]).unwrap())
}

/// Returns the angle between the z axis of a frame and the way from its point (0, 0.02, 0.05) to a target, rad.
fn angle(robot: &RobotModel, q: &[f64], frame: BodyFrame, target: impl Fn(&Configuration) -> Vector3<f64>) -> f64 {
    let at = Configuration::new(robot, q).unwrap();
    let pose = at.link_pose(frame.link) * frame.offset;
    let eye = pose.translation.vector + pose.rotation * Vector3::new(0.0, 0.02, 0.05);
    (pose.rotation * Vector3::z()).angle(&(target(&at) - eye))
}

fn follow(config: ControllerConfig, start: &[f64], periods: u32) -> (Vec<f64>, f64) {
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(start, DRIVE, 0.0, 1);
    let (mut memory, mut speed) = (None, 0.0);
    for i in 0..periods {
        let state = arm.measure(f64::from(i) * PERIOD);
        let command = stepper.step(&mut memory, &state).unwrap();
        speed = command.resolution.joint_velocity.amax();
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
    }
    (arm.q, speed)
}

fn tool(robot: &RobotModel) -> BodyFrame {
    BodyFrame::from(&robot.tips()[0])
}

/// The joints turn with the point, for minutes; turning has a price only where the target rests.
#[test]
fn a_camera_follows_a_point_that_goes_back_and_forth() {
    let robot = panda();
    let eye = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 4.0));
    let sine = Profile::sine(vec![0.6, 0.0, 0.1], vec![0.0, 0.3, 0.0], 1.57, 0.0).unwrap();
    let config = ControllerConfig {
        drive: DRIVE,
        ..ControllerConfig::new(Arc::clone(&robot), PERIOD, vec![eye, look(None, sine.clone(), gain(4.0))])
    };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&PANDA, DRIVE, 0.0, 1);
    let (mut memory, mut worst) = (None, 0.0_f64);
    for i in 0..20_000 {
        let time = f64::from(i) * PERIOD;
        let command = stepper.step(&mut memory, &arm.measure(time)).unwrap();
        assert_eq!(command.request_share, 1.0, "{time} s");
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
        if time > 10.0 {
            let point = Vector3::from_column_slice(&sine.at(time).value);
            worst = worst.max(angle(&robot, &arm.q, tool(&robot), |_| point));
        }
    }
    assert!(worst < 0.05, "{worst} rad");
}

#[test]
fn the_rows_are_the_rate_of_the_angle_at_any_angle() {
    let robot = panda();
    let mut random = Random(5);
    for _ in 0..200 {
        let q: Vec<f64> = PANDA.iter().map(|q| q + 0.5 * random.signed()).collect();
        let target = Vector3::new(random.signed(), random.signed(), random.signed()) * 2.0;
        let config = ControllerConfig {
            drive: DRIVE,
            limits: Limits::Robot(LimitKind::None),
            ..ControllerConfig::new(
                panda(),
                PERIOD,
                vec![look(
                    None,
                    constant(target),
                    Law::Position(PositionLaw::with_braking(vec![1.0; 2], Braking::None).unwrap()),
                )],
            )
        };
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let state = super::arms::measurement(&q);
        let command = stepper.step(&mut None, &state).unwrap();
        let h = 1e-6;
        let after: Vec<f64> = q.iter().zip(&command.resolution.joint_velocity).map(|(q, v)| q + h * v).collect();
        let of = |q: &[f64]| angle(&robot, q, tool(&robot), |_| target);
        let (before, rate) = (of(&q), (of(&after) - of(&q)) / h);
        // θ̇ = −k θ, with k = 1/s.
        assert!((rate + before).abs() < 1e-3 * (1.0 + before), "angle {before}, rate {rate}");
    }
}

#[test]
fn a_tool_turns_to_a_point_while_the_task_above_moves_it() {
    let robot = panda();
    let target = Vector3::new(0.7, 0.2, 0.1);
    let start = Configuration::new(&robot, &PANDA).unwrap().tool_pose().translation.vector;
    let sine = Profile::sine(vec![0.0; 3], vec![0.05, 0.08, 0.05], 1.0, 0.0).unwrap();
    let mut reach = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 5.0));
    let TaskRows::Tool(rows) = &mut reach.rows else { unreachable!() };
    rows.target_displacement = Some(sine);
    let tasks = vec![reach, look(None, constant(target), gain(5.0))];
    let config = ControllerConfig { drive: DRIVE, ..ControllerConfig::new(panda(), PERIOD, tasks) };
    let (q, _) = follow(config, &PANDA, 2000);
    let moved = Configuration::new(&robot, &q).unwrap().tool_pose().translation.vector - start;
    assert!(moved.norm() > 0.02, "{moved}");
    let left = angle(&robot, &q, tool(&robot), |_| target);
    let before = angle(&robot, &PANDA, tool(&robot), |_| target);
    assert!(before > 0.3 && left < 0.01, "{before} → {left}");
}

#[test]
fn an_arm_that_looks_comes_to_rest() {
    let target = Vector3::new(0.4, -0.3, 0.9);
    let config = ControllerConfig {
        drive: DRIVE,
        ..ControllerConfig::new(panda(), PERIOD, vec![look(None, constant(target), gain(3.0))])
    };
    let (q, speed) = follow(config, &PANDA, 3000);
    assert!(angle(&panda(), &q, tool(&panda()), |_| target) < 1e-5 && speed < 1e-5, "{speed}");
}

#[test]
fn one_hand_watches_the_other_that_moves() {
    let robot = two_pandas();
    let of = |name: &str| BodyFrame::from(robot.tip(name).unwrap());
    // The right hand looks at the origin of the left hand: a point at rest in the frame of the latter.
    let body = TaskBody { body: of("right"), relative_to: Some(of("left")) };
    let mut lead = task(&[Axis::X, Axis::Y, Axis::Z], position(3, 5.0));
    let TaskRows::Tool(rows) = &mut lead.rows else { unreachable!() };
    rows.target_displacement = Some(Profile::sine(vec![0.0; 3], vec![0.1, 0.0, 0.15], 1.0, 0.0).unwrap());
    let tasks = vec![lead, look(Some(body), constant(Vector3::zeros()), gain(6.0))];
    let config = ControllerConfig { drive: DRIVE, ..ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks) };
    let start = [PANDA, PANDA].concat();
    let (q, _) = follow(config, &start, 2000);
    let left_hand = |at: &Configuration| at.tip_pose(robot.tip("left").unwrap()).translation.vector;
    let (before, after) = (angle(&robot, &start, of("right"), left_hand), angle(&robot, &q, of("right"), left_hand));
    assert!(before > 0.5 && after < 0.02, "{before} → {after}");
}

#[test]
fn laws_of_wrenches_and_directions_without_length_are_refused() {
    let none = GazeRows::new(None, Vector3::zeros(), Vector3::zeros(), constant(Vector3::x()));
    assert_eq!(none.err(), Some(RowsError::Direction));
    let two = GazeRows::new(None, Vector3::zeros(), Vector3::z(), Profile::constant(vec![0.0; 2]).unwrap());
    assert_eq!(two.err(), Some(RowsError::Rows { expected: 3, given: 2 }));
    let tasks = vec![look(None, constant(Vector3::x()), force(&[Axis::X, Axis::Y], &[1.0, 0.0]))];
    let refused = Controller::new(ControllerConfig::new(panda(), PERIOD, tasks)).err();
    assert_eq!(refused, Some(ConfigError::Task { task: 0, source: TaskConfigError::Rows(RowsError::GazeLaw) }));
}

/// A target at the eye itself, and behind the back, has finite rows.
#[test]
fn a_target_at_the_eye_or_behind_gives_finite_commands() {
    let robot = panda();
    let pose = *Configuration::new(&robot, &PANDA).unwrap().tool_pose();
    let eye = pose.translation.vector + pose.rotation * Vector3::new(0.0, 0.02, 0.05);
    for target in [eye, eye + pose.rotation * Vector3::z() * 1e-9, eye - pose.rotation * Vector3::z()] {
        let config = ControllerConfig::new(panda(), PERIOD, vec![look(None, constant(target), gain(3.0))]);
        let (_, speed) = follow(config, &PANDA, 200);
        assert!(speed.is_finite(), "{target}");
    }
}

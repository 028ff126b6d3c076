//! Two Pandas on one base: tasks of both hands, and of one hand seen from the other.

use std::sync::Arc;
use std::time::Instant;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::constraint::{Constraint, PlanePoint, VirtualPlane};
use revprio_core::controller::{
    ConfigError, Controller, ControllerConfig, Measurement, NullSpaceMotion, StepError, Stepper, TaskConfig,
    TaskConfigError, TipWrench, WrenchConvention, WrenchFrame,
};
use revprio_core::law::{Law, MotionPath, PositionLaw, Profile};
use revprio_core::limits::Drive;
use revprio_core::rows::{RowsError, TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{
    Axis, AxisSelection, BodyFrame, Configuration, Frame, TaskBody, TaskFrame, orientation_error,
};
use revprio_robot::{RobotModel, UrdfTip, UrdfTreeOptions};

use super::arms::{force, impedance, joint_rows, position};
use super::drives::LaggingArm;

/// T, s.
const PERIOD: f64 = 4e-3;

const DRIVE: Drive = Drive { lag_s: 0.02, delay_periods: 2 };

pub(super) const HOME: [f64; 14] =
    [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785, 0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785];

/// Returns two Pandas, 0.6 m apart, that look in the same direction. Their hands are the tips, the left one first.
pub(super) fn two_pandas() -> Arc<RobotModel> {
    two_pandas_with(["left", "right"])
}

/// The same on a waist whose axis is not quite vertical.
pub(super) fn two_pandas_on_a_waist() -> Arc<RobotModel> {
    let waist = r#"<link name="floor"/><joint name="waist" type="revolute"><parent link="floor"/><child link="table"/>
        <origin rpy="0.01 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>"#;
    two_pandas_on(waist, ["left", "right"])
}

/// The same with their tips in the order that is given.
fn two_pandas_with(tips: [&'static str; 2]) -> Arc<RobotModel> {
    two_pandas_on("", tips)
}

fn two_pandas_on(floor: &str, tips: [&'static str; 2]) -> Arc<RobotModel> {
    let one = include_str!("../../../robot/robots/panda.urdf");
    let links = one.split("<robot").nth(1).and_then(|text| text.split_once('>')).unwrap().1.replace("</robot>", "");
    let of = |side: &str| links.replace("panda_", &format!("{side}_"));
    let mount = |side: &str, y: f64| {
        format!(
            r#"<joint name="{side}_mount" type="fixed"><parent link="table"/><child link="{side}_link0"/><origin xyz="0 {y} 0"/></joint>"#
        )
    };
    let text = format!(
        r#"<robot name="two_pandas">{floor}<link name="table"/>{}{}{}{}</robot>"#,
        mount("left", 0.3),
        mount("right", -0.3),
        of("left"),
        of("right")
    );
    let links = tips.map(|name| format!("{name}_link8"));
    let hand =
        |k: usize| UrdfTip { name: tips[k], link: &links[k], offset: IsometryMatrix3::translation(0.0, 0.0, 0.1) };
    let tips = [hand(0), hand(1)];
    Arc::new(RobotModel::from_urdf_tree(&text, &UrdfTreeOptions { tips: &tips, ..UrdfTreeOptions::default() }).unwrap())
}

fn hand(robot: &RobotModel, name: &str) -> BodyFrame {
    BodyFrame::from(robot.tip(name).unwrap())
}

/// Returns a task of all axes of a hand with a position law of gain 8/s.
fn task(name: &str, body: TaskBody, law: Law) -> TaskConfig {
    let frame = TaskFrame { body: Some(body), ..TaskFrame::default() };
    let rows = ToolRows { frame, ..ToolRows::new(AxisSelection::new(&Axis::ALL).unwrap()) };
    TaskConfig {
        name: name.to_owned(),
        rows: TaskRows::Tool(rows),
        law,
        scaled: false,
        streaming: Streaming::default(),
    }
}

/// The left hand moves on a circle; the right one, seen from it, stands still; then the posture.
fn carrying(robot: &Arc<RobotModel>, path: Option<MotionPath>) -> ControllerConfig {
    let (left, right) = (hand(robot, "left"), hand(robot, "right"));
    let law = |rows: usize| {
        let law = PositionLaw::new(vec![8.0; rows]).unwrap();
        Law::Position(path.map_or(law.clone(), |path| law.along(path)))
    };
    let hold = task("hold", TaskBody { body: right, relative_to: Some(left) }, law(6));
    let mut lead = task("lead", TaskBody { body: left, relative_to: None }, law(6));
    let TaskRows::Tool(rows) = &mut lead.rows else { unreachable!() };
    let sine = |amplitude: f64| Profile::sine(vec![0.0; 6], vec![0.0, amplitude, amplitude, 0.2, 0.0, 0.0], 2.0, 0.0);
    rows.target_displacement = Some(sine(0.1).unwrap());
    let posture = TaskConfig {
        name: "posture".to_owned(),
        rows: joint_rows(&HOME),
        law: law(14),
        scaled: false,
        streaming: Streaming::default(),
    };
    let tasks = vec![hold, lead, posture];
    ControllerConfig { drive: DRIVE, ..ControllerConfig::new(Arc::clone(robot), PERIOD, tasks) }
}

/// Returns the pose of the right hand seen from the left one.
fn relative(robot: &RobotModel, q: &[f64]) -> IsometryMatrix3<f64> {
    let at = Configuration::new(robot, q).unwrap();
    at.tip_pose(&robot.tips()[0]).inv_mul(&at.tip_pose(&robot.tips()[1]))
}

/// Two hands carry a part along a path behind a drive with lag and dead time: their relative pose stays within 10⁻⁴ m and rad. Joints that
/// follow a virtual arm each in their own way do not keep it while they catch up with the path.
#[test]
fn two_hands_carry_a_part_along_a_path() {
    let robot = two_pandas();
    assert_eq!(robot.joint_count(), 14);
    let start = relative(&robot, &HOME);
    let tool = |q: &[f64]| Configuration::new(&robot, q).unwrap().tool_pose().translation.vector;
    for (path, allowed) in [(None, 1e-4), (Some(MotionPath::Joint), 0.03)] {
        let mut stepper = Stepper::new(Controller::new(carrying(&robot, path)).unwrap()).unwrap();
        let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1);
        let (mut memory, mut largest, mut moved) = (None, 0.0_f64, 0.0_f64);
        for i in 0..2000 {
            let measured = arm.measure(f64::from(i) * PERIOD);
            let command = stepper.step(&mut memory, &measured).unwrap().clone();
            arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
            let seen = relative(&robot, &arm.q);
            let error = (seen.translation.vector - start.translation.vector).norm();
            largest = largest.max(error).max(orientation_error(&seen.rotation, &start.rotation).norm());
            moved = moved.max((tool(&arm.q) - tool(&HOME)).norm());
        }
        assert!(moved > 0.12, "{path:?}: the hands moved by {moved} m");
        assert!(largest < allowed, "{path:?}: {largest}");
    }
}

/// A gain so small that the time constant of its motion exceeds every number.
#[test]
fn a_tiny_gain_in_the_null_space_leaves_the_virtual_arm_finite() {
    let robot = two_pandas();
    let null_space = Some(NullSpaceMotion::Posture { joint_position: vec![0.0; 14], gain: 1e-309 });
    let config = ControllerConfig { null_space, ..carrying(&robot, Some(MotionPath::Joint)) };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let (mut arm, mut memory) = (LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1), None);
    for i in 0..20 {
        let command = stepper.step(&mut memory, &arm.measure(f64::from(i) * PERIOD)).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
    }
    assert!(arm.q.iter().all(|q| q.is_finite()));
}

#[test]
#[ignore = "asserts nothing; prints how long a period of two arms takes, for docs/performance.md"]
fn table_of_times() {
    let robot = two_pandas();
    let hold =
        |name: &str, tip: &str| task(name, TaskBody { body: hand(&robot, tip), relative_to: None }, position(6, 8.0));
    let with = |tasks: Vec<TaskConfig>| ControllerConfig { tasks, ..carrying(&robot, None) };
    let [relative, lead, posture] = carrying(&robot, None).tasks.try_into().unwrap();
    let stacks = [
        ("hold a part, lead", with(vec![relative.clone(), lead.clone()])),
        ("hold a part, lead, posture", with(vec![relative.clone(), lead.clone(), posture])),
        ("hold a part, lead, hold the right hand", with(vec![relative, lead, hold("right", "right")])),
    ];
    for (name, config) in stacks {
        let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
        let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1);
        let (mut memory, mut times) = (None, Vec::new());
        for i in 0..20_000 {
            let measured = arm.measure(f64::from(i) * PERIOD);
            let start = Instant::now();
            let command = stepper.step(&mut memory, &measured).unwrap();
            times.push(start.elapsed().as_secs_f64() * 1e6);
            arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
        }
        times.sort_by(f64::total_cmp);
        let [median, high] = [50, 99].map(|percent| times[times.len() * percent / 100]);
        println!("{name}: median {median:.1} µs, 99th percentile {high:.1} µs");
    }
}

/// The pose at the first step is the target, also for a stepper that starts in the middle, with the memory alone.
#[test]
fn a_new_stepper_in_each_period_holds_the_first_pose() {
    let robot = two_pandas();
    let controller = Controller::new(carrying(&robot, None)).unwrap();
    let mut stepper = Stepper::new(controller.clone()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 1e-4, 1);
    let (mut memory, mut other) = (None, None);
    for i in 0..100 {
        let measured = arm.measure(f64::from(i) * PERIOD);
        let command = stepper.step(&mut memory, &measured).unwrap().clone();
        let again = Stepper::new(controller.clone()).unwrap().step(&mut other, &measured).unwrap().clone();
        assert_eq!((&command, &memory), (&again, &other), "period {i}");
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
    }
}

/// A target pose of a hand seen from the other one is reached, wherever the pair moves.
#[test]
fn a_relative_target_pose_is_reached() {
    let robot = two_pandas();
    let mut config = carrying(&robot, None);
    let mut target = relative(&robot, &HOME);
    target.translation.vector += Vector3::new(0.05, 0.1, -0.05);
    let TaskRows::Tool(rows) = &mut config.tasks[0].rows else { unreachable!() };
    rows.target_pose = TargetPose::Fixed(target);
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 0.0, 1);
    let mut memory = None;
    for i in 0..1500 {
        let measured = arm.measure(f64::from(i) * PERIOD);
        let command = stepper.step(&mut memory, &measured).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
    }
    let left = (relative(&robot, &arm.q).translation.vector - target.translation.vector).norm();
    assert!(left < 1e-4, "{left}");
}

/// The tasks of one arm need no joint of the other.
#[test]
fn a_task_of_one_hand_leaves_the_other_arm_at_rest() {
    let robot = two_pandas();
    let body = TaskBody { body: hand(&robot, "right"), relative_to: None };
    let mut reach = task("reach", body, position(6, 8.0));
    let TaskRows::Tool(rows) = &mut reach.rows else { unreachable!() };
    rows.target_displacement = Some(Profile::constant(vec![0.1, 0.05, 0.0, 0.0, 0.0, 0.0]).unwrap());
    let config =
        ControllerConfig { null_space: None, ..ControllerConfig::new(Arc::clone(&robot), PERIOD, vec![reach]) };
    let controller = Controller::new(config).unwrap();
    let at_rest = Measurement {
        channels: Vec::new(),
        chunks: Vec::new(),
        wrenches: Vec::new(),
        obstacles: Vec::new(),
        time_s: 0.0,
        joint_position: HOME.to_vec(),
        joint_velocity: None,
        wrench: [0.0; 6],
        targets: Vec::new(),
    };
    let mut memory = None;
    let command = Stepper::new(controller).unwrap().step(&mut memory, &at_rest).unwrap().clone();
    let velocity = command.resolution.joint_velocity.as_slice();
    assert!(velocity[..7].iter().all(|entry| entry.abs() < 1e-12), "{velocity:?}");
    assert!(velocity[7..].iter().any(|entry| entry.abs() > 1e-3), "{velocity:?}");
}

/// A law that reads the wrench of the second tip gives the velocities that it gives where that tip is the tool.
#[test]
fn the_wrench_of_a_tip_moves_it_as_that_of_the_tool_moves_the_tool() {
    let laws = [force(&Axis::ALL, &[20.0, 0.0, -5.0, 1.0, 0.0, 0.0]), impedance(&Axis::ALL, 300.0)];
    let terms = [
        (WrenchConvention::OnEnvironment, WrenchFrame::Base, Frame::Base),
        (WrenchConvention::OnTool, WrenchFrame::Tool, Frame::Tool),
    ];
    for (law, (convention, wrench_frame, frame)) in laws.iter().flat_map(|law| terms.map(|terms| (law, terms))) {
        let stepper = |robot: &Arc<RobotModel>| {
            let mut push = task("push", TaskBody { body: hand(robot, "right"), relative_to: None }, law.clone());
            let TaskRows::Tool(rows) = &mut push.rows else { unreachable!() };
            rows.frame.frame = frame;
            if robot.tips()[0].name == "right" {
                rows.frame.body = None;
            }
            let config = ControllerConfig::new(Arc::clone(robot), PERIOD, vec![push]);
            let config = ControllerConfig { wrench_convention: convention, wrench_frame, ..config };
            Stepper::new(Controller::new(config).unwrap()).unwrap()
        };
        let mut steppers = vec![stepper(&two_pandas()), stepper(&two_pandas_with(["right", "left"]))];
        let mut memories = [None, None];
        let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 1e-3, 3);
        for i in 0..200_u32 {
            let wrench = std::array::from_fn(|row| (f64::from(i) * 7.0 + row as f64 * 5.0) % 11.0 - 5.0);
            let state = arm.measure(f64::from(i) * PERIOD);
            let of_tip = Measurement { wrenches: vec![TipWrench { tip: 1, wrench }], ..state.clone() };
            let commands = [of_tip, Measurement { wrench, ..state }]
                .iter()
                .zip(&mut steppers)
                .zip(&mut memories)
                .map(|((state, stepper), memory)| stepper.step(memory, state).unwrap().clone())
                .collect::<Vec<_>>();
            let [a, b] = [0, 1].map(|k| commands[k].targets[0].velocity.as_slice().to_vec());
            let error = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-12 && a.iter().any(|v| v.abs() > 1e-4), "period {i}: {a:?}, {b:?}");
            arm.follow(commands[0].resolution.joint_velocity.as_slice(), PERIOD);
        }
    }
}

/// A wrench must be finite, and that of a tip other than the tool, once.
#[test]
fn wrenches_of_no_tip_and_of_the_tool_are_refused() {
    let robot = two_pandas();
    let lead = task("lead", TaskBody { body: hand(&robot, "left"), relative_to: None }, position(6, 2.0));
    let mut stepper = Stepper::new(Controller::new(ControllerConfig::new(robot, PERIOD, vec![lead])).unwrap()).unwrap();
    let mut refused = |wrenches: Vec<TipWrench>| {
        let state = Measurement { wrenches, ..super::arms::measurement(&HOME) };
        stepper.step(&mut None, &state).err()
    };
    let of = |tip: usize| TipWrench { tip, wrench: [1.0; 6] };
    assert_eq!(refused(vec![of(1)]), None);
    assert_eq!(refused(vec![of(0)]), Some(StepError::WrenchTip { tip: 0, tips: 2 }));
    assert_eq!(refused(vec![of(2)]), Some(StepError::WrenchTip { tip: 2, tips: 2 }));
    assert_eq!(refused(vec![of(1), of(1)]), Some(StepError::WrenchTip { tip: 1, tips: 2 }));
    assert_eq!(refused(vec![TipWrench { wrench: [f64::NAN; 6], ..of(1) }]), Some(StepError::NotFinite));
}

/// Wrenches are measured at tips: no law of another link, or of one that is seen from a link, can read one. A link of another robot is
/// refused too.
#[test]
fn laws_that_read_the_wrench_are_refused_on_other_links() {
    let robot = two_pandas();
    let seen = TaskBody { body: hand(&robot, "right"), relative_to: Some(hand(&robot, "left")) };
    let elbow = TaskBody { body: BodyFrame::from(robot.link("right_link4").unwrap()), relative_to: None };
    let refused = |body: TaskBody, law: Law| {
        let tasks = vec![task("hand", body, law)];
        Controller::new(ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks)).err()
    };
    let misfit = |source| Some(ConfigError::Task { task: 0, source: TaskConfigError::Rows(source) });
    for body in [seen, elbow] {
        assert_eq!(refused(body, force(&Axis::ALL, &[0.0; 6])), misfit(RowsError::LinkLaw));
        assert_eq!(refused(body, impedance(&Axis::ALL, 100.0)), misfit(RowsError::LinkLaw));
        assert_eq!(refused(body, position(6, 2.0)), None);
    }
    let one_arm = revprio_robot::built_in().iter().find(|robot| robot.name() == "panda").unwrap();
    let tasks = vec![task("hand", elbow, position(6, 2.0))];
    let unknown = Controller::new(ControllerConfig::new(Arc::clone(one_arm), PERIOD, tasks)).err();
    assert_eq!(unknown, misfit(RowsError::Link));
}

/// A plane before the second hand, with lag, dead time and noise: the hand moves fast towards a target behind it, and stops before it.
#[test]
fn a_plane_holds_back_the_hand_of_the_second_arm() {
    let robot = two_pandas();
    let right = hand(&robot, "right");
    let mut reach = task("reach", TaskBody { body: right, relative_to: None }, position(6, 8.0));
    let TaskRows::Tool(rows) = &mut reach.rows else { unreachable!() };
    rows.target_displacement = Some(Profile::constant(vec![0.3, 0.0, 0.0, 0.0, 0.0, 0.0]).unwrap());
    let point = PlanePoint::Link(right.origin());
    let at = |q: &[f64]| point.position(&Configuration::new(&robot, q).unwrap()).x;
    let offset = at(&HOME) + 0.1;
    let plane = VirtualPlane::new("wall", [1.0, 0.0, 0.0], offset, point, 10.0).unwrap();
    let tasks = vec![reach];
    let config = ControllerConfig {
        drive: DRIVE,
        constraints: vec![Constraint::Plane(plane)],
        ..ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks)
    };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&HOME, DRIVE, 1e-4, 1);
    let (mut memory, mut farthest) = (None, f64::NEG_INFINITY);
    for i in 0..1500 {
        let measured = arm.measure(f64::from(i) * PERIOD);
        let command = stepper.step(&mut memory, &measured).unwrap();
        arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
        farthest = farthest.max(at(&arm.q));
    }
    // docs/limits.md states 0.9 mm with this noise.
    assert!(
        farthest < offset + 9e-4 && at(&arm.q) > offset - 5e-3,
        "{} and {}",
        farthest - offset,
        at(&arm.q) - offset
    );
}

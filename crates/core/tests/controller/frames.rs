//! Tasks in other frames and at other reference points: the same physics in other coordinates.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use revprio_core::controller::{Command, Controller, ControllerConfig, Measurement, TaskConfig, WrenchFrame};
use revprio_core::law::{Law, Profile};
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Axis, Frame, TaskFrame};

use super::arms::{
    Loop, NOMINAL, PERIOD, Random, config, constant, controller, force, hybrid, impedance, measurement, position,
    sawyer, step, task, tool_rows,
};

fn fixed_frame() -> IsometryMatrix3<f64> {
    IsometryMatrix3::new(Vector3::new(0.5, 0.1, 0.2), Vector3::new(0.3, -1.0, 0.6))
}

fn in_frame(frame: Frame) -> ToolRows {
    ToolRows { frame: TaskFrame { frame, ..TaskFrame::default() }, ..tool_rows(&Axis::ALL) }
}

fn at_point(point: Vector3<f64>) -> ToolRows {
    ToolRows { frame: TaskFrame { reference_point: point, ..TaskFrame::default() }, ..tool_rows(&Axis::ALL) }
}

fn all_rows(rows: ToolRows, law: Law) -> TaskConfig {
    TaskConfig {
        name: "all".to_owned(),
        rows: TaskRows::Tool(rows),
        law,
        scaled: false,
        streaming: Streaming::default(),
    }
}

fn one_task(rows: ToolRows, law: Law) -> Controller {
    controller(config(&sawyer(), vec![all_rows(rows, law)]))
}

/// Converts six numbers from the axes of the fixed frame to the axes of the base.
fn in_base([a, b, c, d, e, f]: [f64; 6]) -> [f64; 6] {
    let (linear, angular) =
        (fixed_frame().rotation * Vector3::new(a, b, c), fixed_frame().rotation * Vector3::new(d, e, f));
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// Asserts that both controllers command the same, each with its own arm, under the same random wrenches.
/// `seen_by_other` converts a wrench to the form that `other` measures.
fn assert_same_commands(one: &Controller, other: &Controller, seen_by_other: impl Fn(&Loop, [f64; 6]) -> [f64; 6]) {
    let (mut first, mut second, mut random) = (Loop::at_rest(&NOMINAL), Loop::at_rest(&NOMINAL), Random(7));
    for i in 0..300 {
        let wrench = [0.0; 6].map(|_: f64| 20.0 * random.signed());
        let seen = seen_by_other(&second, wrench);
        let command = first.step(one, wrench).resolution.joint_velocity;
        let difference = (second.step(other, seen).resolution.joint_velocity - &command).amax();
        assert!(difference < 1e-11, "period {i}: {difference:e} of {}", command.amax());
    }
    assert!(first.q.iter().zip(NOMINAL).any(|(q, start)| (q - start).abs() > 1e-4), "the arm must move");
}

const TARGET: [f64; 6] = [30.0, 5.0, -3.0, 1.0, 2.0, -1.0];

#[test]
fn a_rotated_frame_gives_the_same_command_as_the_rotated_request() {
    // The gains are the same along all axes, so they are the same in every frame.
    let swing = |amplitude: [f64; 6]| {
        Some(Profile::sine(vec![0.0; 6], amplitude.map(|value| 0.01 * value).to_vec(), 3.0, 0.4).unwrap())
    };
    let laws: [&dyn Fn([f64; 6]) -> Law; 4] = [
        &|target| Law::Velocity(constant(&target.map(|value| 0.01 * value))),
        &|target| force(&Axis::ALL, &target),
        &|_| impedance(&Axis::ALL, 700.0),
        &|_| position(6, 3.0),
    ];
    for law in laws {
        // A rotation vector in other axes is the rotated rotation vector.
        let along = ToolRows { target_displacement: swing(TARGET), ..in_frame(Frame::Fixed(fixed_frame())) };
        let rotated = ToolRows { target_displacement: swing(in_base(TARGET)), ..in_frame(Frame::Base) };
        assert_same_commands(&one_task(along, law(TARGET)), &one_task(rotated, law(in_base(TARGET))), |_, wrench| {
            wrench
        });
    }
}

#[test]
fn a_frame_turned_by_a_right_angle_swaps_the_axes() {
    // x of the frame is y of the base, y of the frame is −x.
    let quarter = IsometryMatrix3::rotation(Vector3::z() * std::f64::consts::FRAC_PI_2);
    let frame = TaskFrame { frame: Frame::Fixed(quarter), ..TaskFrame::default() };
    let selected = |axis, rows: ToolRows| TaskConfig {
        rows: TaskRows::Tool(rows),
        ..task(&[axis], hybrid(&[axis], 700.0, &[12.0], &[false]))
    };
    let one = controller(config(&sawyer(), vec![selected(Axis::X, ToolRows { frame, ..tool_rows(&[Axis::X]) })]));
    let other = controller(config(&sawyer(), vec![selected(Axis::Y, tool_rows(&[Axis::Y]))]));
    assert_same_commands(&one, &other, |_, wrench| wrench);
}

#[test]
fn a_target_pose_is_given_in_the_fixed_frame() {
    let goal =
        IsometryMatrix3::translation(0.02, -0.03, 0.01) * *Loop::at_rest(&NOMINAL).configuration(&sawyer()).tool_pose();
    let in_base = ToolRows { target_pose: TargetPose::Fixed(goal), ..in_frame(Frame::Base) };
    let target_pose = TargetPose::Fixed(fixed_frame().inverse() * goal);
    let in_fixed = ToolRows { target_pose, ..in_frame(Frame::Fixed(fixed_frame())) };
    let law = || position(6, 3.0);
    assert_same_commands(&one_task(in_base, law()), &one_task(in_fixed, law()), |_, wrench| wrench);
}

/// Returns the first command, after a measured motion, under a wrench.
fn first_command(controller: &Controller) -> Command {
    let measured = Measurement {
        joint_velocity: Some(vec![0.1, -0.2, 0.05, 0.3, -0.1, 0.2, 0.4]),
        wrench: [5.0, -2.0, 1.0, 0.1, 0.3, -0.2],
        ..measurement(&NOMINAL)
    };
    step(controller, &mut None, &measured).unwrap()
}

#[test]
fn the_tool_frame_equals_a_fixed_frame_with_the_orientation_of_the_tool() {
    let tool_pose = *Loop::at_rest(&NOMINAL).configuration(&sawyer()).tool_pose();
    let frame = IsometryMatrix3::from_parts(Vector3::new(0.3, 0.0, -0.2).into(), tool_pose.rotation);
    let goal = IsometryMatrix3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.2, 0.1, -0.3)) * tool_pose;
    // The gains differ along the axes, and the rows are out of order.
    let axes = [Axis::Rz, Axis::X, Axis::Y];
    let with = |frame: Frame, target_pose| {
        let frame = TaskFrame { frame, ..TaskFrame::default() };
        let target_pose = TargetPose::Fixed(target_pose);
        let rows = ToolRows { frame, target_pose, ..tool_rows(&axes) };
        let law = hybrid(&axes, 700.0, &[1.0, 2.0, 3.0], &[true, false, true]);
        first_command(&controller(config(
            &sawyer(),
            vec![TaskConfig { rows: TaskRows::Tool(rows), ..task(&axes, law) }],
        )))
    };
    let (tool, fixed) = (with(Frame::Tool, goal), with(Frame::Fixed(frame), frame.inverse() * goal));
    assert!((&tool.targets[0].velocity - &fixed.targets[0].velocity).amax() < 1e-13);
    assert!((&tool.resolution.joint_velocity - &fixed.resolution.joint_velocity).amax() < 1e-12);
}

#[test]
fn the_integrator_in_the_tool_frame_turns_with_the_tool() {
    let rows = ToolRows { axes: tool_rows(&[Axis::X]).axes, ..in_frame(Frame::Tool) };
    let push = TaskConfig { rows: TaskRows::Tool(rows), ..task(&[Axis::X], force(&[Axis::X], &[30.0])) };
    let controller = controller(config(&sawyer(), vec![push]));
    let mut arm = Loop::at_rest(&NOMINAL);
    (0..100).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let integrator = arm.memory.as_ref().unwrap().task_velocities[0][0];
    // The last joint turns the tool about its z axis. The arm then stands still, so the law has no damping term.
    arm.q[6] += std::f64::consts::FRAC_PI_2;
    let standing = Measurement { joint_velocity: Some(vec![0.0; 7]), ..arm.measurement(PERIOD, [0.0; 6]) };
    let command = step(&controller, &mut arm.memory, &standing).unwrap();
    assert!((command.targets[0].velocity[0] - integrator - PERIOD * 30.0 / 15.0).abs() < 1e-15);
    let tool_x = arm.configuration(&sawyer()).tool_pose().rotation * Vector3::x();
    let [x, y, z, ..] = arm.twist(&sawyer());
    assert!((Vector3::new(x, y, z).dot(&tool_x) - command.targets[0].velocity[0]).abs() < 1e-12);
}

#[test]
fn an_impedance_in_the_tool_frame_has_its_stiffness_along_the_tool_axes() {
    let robot = sawyer();
    let gains = revprio_core::law::Gains::new(3, &[15.0; 3], &[150.0; 3], &[500.0, 1000.0, 2000.0]).unwrap();
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let law = Law::Impedance(revprio_core::law::ImpedanceLaw::new(gains));
    let frame = TaskFrame { frame: Frame::Tool, ..TaskFrame::default() };
    let yielding = TaskConfig { rows: TaskRows::Tool(ToolRows { frame, ..tool_rows(&axes) }), ..task(&axes, law) };
    let rotate = [Axis::Rx, Axis::Ry, Axis::Rz];
    let still = task(&rotate, position(3, 10.0));
    let controller = controller(config(&robot, vec![yielding, still]));
    let mut arm = Loop::at_rest(&NOMINAL);
    let start = *arm.configuration(&robot).tool_pose();
    let push = start.rotation * Vector3::new(10.0, 10.0, 10.0);
    (0..8000).for_each(|_| drop(arm.step(&controller, [push.x, push.y, push.z, 0.0, 0.0, 0.0])));
    let moved = arm.configuration(&robot).tool_pose().translation.vector - start.translation.vector;
    let along_tool = start.rotation.inverse() * moved;
    assert!((along_tool - Vector3::new(-10.0 / 500.0, -10.0 / 1000.0, -10.0 / 2000.0)).amax() < 1e-6, "{along_tool}");
}

#[test]
fn a_displacement_in_the_tool_frame_is_along_the_axes_of_the_target_pose() {
    let robot = sawyer();
    let along = Profile::waypoints(
        &[(0.0, 0.0), (1.0, 0.05)]
            .map(|(time_s, z)| revprio_core::law::Point { time_s, value: vec![0.0, 0.0, z, 0.0, 0.0, 0.0] }),
    );
    let rows = ToolRows { target_displacement: Some(along.unwrap()), ..in_frame(Frame::Tool) };
    let controller = one_task(rows, position(6, 10.0));
    let mut arm = Loop::at_rest(&NOMINAL);
    let start = *arm.configuration(&robot).tool_pose();
    (0..4000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let goal = start * IsometryMatrix3::translation(0.0, 0.0, 0.05);
    let reached = *arm.configuration(&robot).tool_pose();
    assert!((reached.to_homogeneous() - goal.to_homogeneous()).amax() < 1e-8, "{reached}");
}

#[test]
fn a_wrench_in_the_tool_frame_gives_the_same_command() {
    let law = || hybrid(&Axis::ALL, 700.0, &TARGET, &[false, true, true, true, false, true]);
    let given = config(&sawyer(), vec![task(&Axis::ALL, law())]);
    let wrist = controller(ControllerConfig { wrench_frame: WrenchFrame::Tool, ..given.clone() });
    assert_same_commands(&controller(given), &wrist, |arm, [fx, fy, fz, tx, ty, tz]| {
        let back = arm.configuration(&sawyer()).tool_pose().rotation.inverse();
        let (force, torque) = (back * Vector3::new(fx, fy, fz), back * Vector3::new(tx, ty, tz));
        [force.x, force.y, force.z, torque.x, torque.y, torque.z]
    });
}

const POINT: [f64; 3] = [0.05, -0.1, 0.3];

#[test]
fn a_force_at_the_reference_point_has_no_torque_there() {
    let controller = one_task(at_point(POINT.into()), force(&Axis::ALL, &[0.0; 6]));
    let arm = Loop::at_rest(&NOMINAL);
    let lever = arm.configuration(&sawyer()).tool_pose().rotation * Vector3::from(POINT);
    let push = Vector3::new(3.0, -8.0, 5.0);
    let torque = lever.cross(&push);
    let wrench = [push.x, push.y, push.z, torque.x, torque.y, torque.z];
    let velocity = arm.clone().step(&controller, wrench).targets[0].velocity.clone();
    assert!(velocity.rows(3, 3).amax() < 1e-15 && velocity.rows(0, 3).amax() > 1e-4, "{velocity}");
}

fn longer_sawyer() -> Arc<RobotModel> {
    let offset = IsometryMatrix3::new(POINT.into(), Vector3::new(0.4, 0.0, -0.2));
    Arc::new(sawyer().with_tool_offset(&offset).unwrap())
}

#[test]
fn a_reference_point_is_equivalent_to_a_tool_offset() {
    let swing = Profile::sine(vec![0.0; 6], vec![0.02; 6], 2.0, 0.0).unwrap();
    for law in [hybrid(&Axis::ALL, 700.0, &TARGET, &[true; 6]), position(6, 3.0), force(&Axis::ALL, &TARGET)] {
        let rows = ToolRows { target_displacement: Some(swing.clone()), ..at_point(POINT.into()) };
        let moved = ToolRows { target_displacement: Some(swing.clone()), ..tool_rows(&Axis::ALL) };
        let offset = controller(config(&longer_sawyer(), vec![all_rows(moved, law.clone())]));
        // The same wrench at the tip of the longer tool.
        assert_same_commands(&one_task(rows, law), &offset, |arm, [fx, fy, fz, tx, ty, tz]| {
            let lever = arm.configuration(&sawyer()).tool_pose().rotation * Vector3::from(POINT);
            let torque = Vector3::new(tx, ty, tz) - lever.cross(&Vector3::new(fx, fy, fz));
            [fx, fy, fz, torque.x, torque.y, torque.z]
        });
    }
}

#[test]
fn the_initial_pose_is_the_pose_of_the_reference_point() {
    let turned = Rotation3::new(Vector3::new(0.0, 0.2, 0.0));
    let rows = ToolRows {
        frame: TaskFrame {
            frame: Frame::Fixed(IsometryMatrix3::from_parts(Vector3::zeros().into(), turned)),
            reference_point: POINT.into(),
            ..TaskFrame::default()
        },
        ..tool_rows(&Axis::ALL)
    };
    let mut arm = Loop::at_rest(&NOMINAL);
    let controller = one_task(rows, impedance(&Axis::ALL, 700.0));
    for _ in 0..10 {
        assert!(arm.step(&controller, [0.0; 6]).resolution.joint_velocity.amax() < 1e-15);
    }
}

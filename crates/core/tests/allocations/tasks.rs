//! Rows, laws, profiles and null-space motions.

use std::f64::consts::TAU;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{
    AntiWindup, ControllerConfig, Limits, NullSpaceMotion, TaskConfig, WrenchConvention, WrenchFrame,
};
use revprio_core::law::{Braking, Gains, HybridLaw, ImpedanceLaw, Law, MotionPath, Point, PositionLaw, Profile};
use revprio_core::limits::LimitKind;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::rows::{JointRows, JointTarget, RawRows, TargetPose, TaskRows, ToolRows};
use revprio_core::wrench::{Load, WrenchSensor};
use revprio_robot::kinematics::{Axis, Frame, TaskFrame};

use crate::arm::{
    LINEAR, NOMINAL, assert_allocates_nothing, config, constant_force, force, position, push_and_hold, task, tool,
    tool_rows,
};

fn all_limits() -> Limits {
    Limits::Robot(LimitKind::PositionVelocityAcceleration)
}

fn moves(what: &str, config: ControllerConfig) {
    assert_allocates_nothing(what, config, 1000, |command| command.resolution.joint_velocity.amax() > 1e-6);
}

fn with(limits: Limits, first: TaskConfig) -> ControllerConfig {
    let others = task("turn", tool(&[Axis::Rx, Axis::Ry]), position(2));
    config(limits, vec![first, others])
}

/// Returns a sine of all rows with a period of 1 s: the warm-up has two.
fn sine(rows: usize, amplitude: f64) -> Profile {
    Profile::sine(vec![0.0; rows], vec![amplitude; rows], TAU, 0.3).unwrap()
}

#[test]
fn rows_of_every_kind_allocate_nothing() {
    let moving = |rows: TaskRows| task("move", rows, Law::Velocity(sine(3, 0.05)));
    let frame = |frame| TaskFrame { frame, reference_point: Vector3::new(0.0, 0.02, 0.1), ..TaskFrame::default() };
    let framed = |place| TaskRows::Tool(ToolRows { frame: frame(place), ..tool_rows(&LINEAR) });
    let fixed = IsometryMatrix3::new(Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.4, 0.5, 0.6));
    let raw = Matrix::from_fn(3, 7, |row, joint| if joint == 2 * row { 1.0 } else { 0.1 });
    let joints = JointRows { joints: vec![1, 4, 5], target: JointTarget::MidRange };
    for (what, rows) in [
        ("base", tool(&LINEAR)),
        ("tool", framed(Frame::Tool)),
        ("fixed", framed(Frame::Fixed(fixed))),
        ("raw", TaskRows::Raw(RawRows { jacobian: raw })),
        ("joints", TaskRows::Joints(joints)),
    ] {
        moves(what, with(all_limits(), moving(rows)));
    }
}

#[test]
fn every_law_allocates_nothing() {
    let gains = || Gains::new(3, &[15.0; 3], &[150.0; 3], &[300.0; 3]).unwrap();
    let hybrid = HybridLaw::new(gains(), sine(3, 20.0), vec![true, false, true]).unwrap();
    let braked = |braking| Law::Position(PositionLaw::with_braking(vec![2.0; 3], braking).unwrap());
    for (what, law) in [
        ("velocity", Law::Velocity(sine(3, 0.05))),
        ("position, braked by joints", braked(Braking::Joints)),
        ("position, braked by rows", braked(Braking::AtMost(Vector::from_element(3, 0.5)))),
        ("position, not braked", braked(Braking::None)),
        ("impedance", Law::Impedance(ImpedanceLaw::new(gains()))),
        ("hybrid", Law::Hybrid(hybrid)),
    ] {
        let target = ToolRows { target_displacement: Some(sine(3, 0.1)), ..tool_rows(&LINEAR) };
        moves(what, with(all_limits(), task("move", TaskRows::Tool(target), law)));
    }
    moves("force", with(all_limits(), task("push", tool(&[Axis::X]), force(sine(1, 20.0)))));
}

/// Only the start of a line allocates.
#[test]
fn laws_that_look_ahead_allocate_nothing() {
    for path in [MotionPath::Joint, MotionPath::Straight] {
        let law = |rows: usize| Law::Position(PositionLaw::new(vec![2.0; rows]).unwrap().along(path));
        let target = ToolRows { target_displacement: Some(sine(3, 0.1)), ..tool_rows(&LINEAR) };
        let others = task("turn", tool(&[Axis::Rx, Axis::Ry]), law(2));
        moves("ahead", config(all_limits(), vec![task("move", TaskRows::Tool(target), law(3)), others]));
    }
}

#[test]
fn every_profile_allocates_nothing() {
    let point = |time_s, value| Point { time_s, value: vec![value] };
    // The largest changes are part of the warm-up.
    let points = [(0.0, 0.0), (0.5, 20.0), (1.0, -20.0), (1.5, 10.0), (3.0, 5.0), (5.0, 4.0)];
    let points = points.map(|(time_s, value)| point(time_s, value));
    for (what, profile) in [
        ("sine", sine(1, 20.0)),
        ("ramp", Profile::ramp(vec![0.0], vec![20.0], 1.0, 2.0).unwrap()),
        ("steps", Profile::steps(points.to_vec()).unwrap()),
        ("waypoints", Profile::waypoints(&points).unwrap()),
    ] {
        moves(what, with(all_limits(), task("push", tool(&[Axis::X]), force(profile))));
    }
}

#[test]
fn targets_of_joints_and_of_the_tool_allocate_nothing() {
    let joints = |target| TaskRows::Joints(JointRows { joints: vec![1, 4], target });
    let pose = IsometryMatrix3::new(Vector3::new(0.6, 0.1, 0.4), Vector3::zeros());
    let target = TargetPose::Fixed(pose);
    let tool = TaskRows::Tool(ToolRows { target_pose: target, ..tool_rows(&LINEAR) });
    for (what, rows, law) in [
        ("positions", joints(JointTarget::Position(sine(2, 0.5))), position(2)),
        ("middle of the ranges", joints(JointTarget::MidRange), position(2)),
        ("pose", tool, Law::Position(PositionLaw::new(vec![0.5; 3]).unwrap())),
    ] {
        moves(what, with(all_limits(), task("move", rows, law)));
    }
}

#[test]
fn every_null_space_motion_allocates_nothing() {
    for motion in [
        NullSpaceMotion::Constant(Vector::from_element(7, 0.01)),
        NullSpaceMotion::JointLimits { gain: 0.5 },
        NullSpaceMotion::Posture { joint_position: NOMINAL.to_vec(), gain: 1.0 },
        NullSpaceMotion::InitialPosture { gain: 1.0 },
    ] {
        let what = format!("{motion:?}");
        moves(&what, ControllerConfig { null_space: Some(motion), ..config(all_limits(), push_and_hold()) });
    }
}

#[test]
fn every_meaning_of_a_wrench_and_of_integrators_allocates_nothing() {
    for wrench_frame in [WrenchFrame::Base, WrenchFrame::Tool] {
        for wrench_convention in [WrenchConvention::OnEnvironment, WrenchConvention::OnTool] {
            for anti_windup in [AntiWindup::Always, AntiWindup::ExceptDamping] {
                let config = config(all_limits(), push_and_hold());
                let config = ControllerConfig { wrench_frame, wrench_convention, anti_windup, ..config };
                moves(&format!("{wrench_frame:?} {wrench_convention:?} {anti_windup:?}"), config);
            }
        }
    }
}

#[test]
fn a_wrench_sensor_with_all_its_corrections_allocates_nothing() {
    let sensor = WrenchSensor {
        load: Load { mass: 0.5, center_of_mass: Vector3::new(0.0, 0.0, 0.05) },
        compensates_inertia: true,
        filter_time: 0.005,
        deadband: [0.2, 0.02],
        ..WrenchSensor::at_tip(0)
    };
    let config = ControllerConfig { wrench_sensors: vec![sensor], ..config(all_limits(), push_and_hold()) };
    assert_allocates_nothing("sensor", config, 1000, |command| command.wrenches[0] != [0.0; 6]);
}

#[test]
fn a_scaled_task_that_no_limit_slows_down_allocates_nothing() {
    let scaled = TaskConfig { scaled: true, ..task("push", tool(&[Axis::X]), constant_force(10.0)) };
    assert_allocates_nothing("scaled", with(all_limits(), scaled), 1000, |command| {
        command.resolution.tasks[0].scale == Some(1.0)
    });
}

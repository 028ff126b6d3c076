//! Tasks with rows that no joint moves, which are zero only up to rounding.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Translation3};
use revprio_core::controller::{Controller, ControllerConfig, Stepper, TaskConfig};
use revprio_core::limits::Drive;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_robot::kinematics::{Axis, Frame, TaskFrame};
use revprio_robot::{Joint, JointKind, JointLimits, RobotModel};

use super::arms::{constant, position, task, tool_rows};
use super::drives::LaggingArm;

const PERIOD: f64 = 0.01;

/// Returns a planar arm of five joints on a mount that is tilted by an angle about y. The axis z of its tool is the normal of the plane.
fn planar_arm(tilt: f64) -> Arc<RobotModel> {
    let limits = JointLimits { lower: -2.8, upper: 2.8, velocity: 2.0, acceleration: 8.0, ..JointLimits::NONE };
    let mount =
        IsometryMatrix3::from_parts(Translation3::new(0.0, 0.0, 0.5), Rotation3::from_euler_angles(0.0, tilt, 0.0));
    let joint = |index: usize| Joint {
        name: format!("joint{index}"),
        kind: JointKind::Revolute,
        placement: if index == 0 { mount } else { IsometryMatrix3::translation(0.3, 0.0, 0.0) },
        limits,
        published_range: None,
        denavit_hartenberg: None,
    };
    let tool = IsometryMatrix3::translation(0.2, 0.0, 0.0);
    Arc::new(RobotModel::new("planar", "", (0..5).map(joint).collect(), tool).unwrap())
}

/// What the controller does besides its tasks.
#[derive(Clone, Copy)]
struct Besides {
    moves_null_space: bool,
    damps: bool,
}

/// Holds the height of the tool over the plane and moves the tool to a target in it. Returns the largest change
/// of a joint's command from 3 s on, rad/s, and the last posture.
fn run(tilt: f64, Besides { moves_null_space, damps }: Besides) -> (f64, Vec<f64>) {
    let robot = planar_arm(tilt);
    let start = [0.3, 0.5, -0.4, 0.6, 0.2];
    let height = TaskRows::Tool(ToolRows {
        frame: TaskFrame { frame: Frame::Tool, ..TaskFrame::default() },
        ..tool_rows(&[Axis::Z])
    });
    let moved = TaskRows::Tool(ToolRows {
        target_displacement: Some(constant(&[-0.6, -0.6])),
        ..tool_rows(&[Axis::X, Axis::Y])
    });
    let tasks = vec![
        TaskConfig { rows: height, ..task(&[Axis::Z], position(1, 5.0)) },
        TaskConfig { rows: moved, ..task(&[Axis::X, Axis::Y], position(2, 5.0)) },
    ];
    let drive = Drive { lag_s: 0.03, delay_periods: 2 };
    let mut config = ControllerConfig { drive, ..ControllerConfig::new(Arc::clone(&robot), PERIOD, tasks) };
    assert!(config.null_space.is_some(), "by default the arm returns to its first posture");
    config.null_space = config.null_space.filter(|_| moves_null_space);
    config.damping = config.damping.filter(|_| damps);
    let mut arm = LaggingArm::at_rest(&start, drive, 0.0, 1);
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let (mut memory, mut last, mut largest) = (None, None, 0.0_f64);
    for number in 0..1500_u32 {
        let measured = arm.measure(f64::from(number) * PERIOD);
        let command = stepper.step(&mut memory, &measured).unwrap().resolution.joint_velocity.clone();
        arm.follow(command.as_slice(), PERIOD);
        if let Some(last) = last.replace(command.clone()).filter(|_| number > 300) {
            largest = largest.max((command - last).amax());
        }
    }
    (largest, arm.measure(0.0).joint_position)
}

/// The height of the tool over the plane has a row of 10⁻¹⁷ in some periods and of zero in others. The null-space motion once ran at full speed in
/// the latter ones alone.
#[test]
fn rows_that_no_joint_moves_leave_the_null_space_motion_alone() {
    for tilt in [0.0, 0.7, 1.1] {
        for damps in [true, false] {
            let [(change, posture), (_, drifted)] =
                [true, false].map(|moves_null_space| run(tilt, Besides { moves_null_space, damps }));
            assert!(change < 0.01, "tilt {tilt}, damping {damps}: {change} rad/s in a period");
            let apart = posture.iter().zip(&drifted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart > 0.1, "tilt {tilt}: the null-space motion changes the posture by {apart} rad");
        }
    }
}

/// Without damping, a row of 10⁻¹⁷ with any request is exact, and was a kick at the full acceleration.
#[test]
fn rows_that_no_joint_moves_do_not_kick_without_damping() {
    for tilt in [0.0, 0.7, 1.1] {
        let (change, _) = run(tilt, Besides { moves_null_space: false, damps: false });
        assert!(change < 0.01, "tilt {tilt}: {change} rad/s in a period");
    }
}

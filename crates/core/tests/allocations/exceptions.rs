//! What allocates nevertheless, with a bound that does not grow; and rare periods that allocate nothing.

use std::f64::consts::TAU;
use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::constraint::PlanePoint;
use revprio_core::controller::{ControllerConfig, Limits, TaskConfig};
use revprio_core::law::{Law, Profile};
use revprio_core::limits::{Drive, LimitKind, VelocityBox};
use revprio_core::resolution::{Method, Solver};
use revprio_core::rows::{JointRows, JointTarget, TargetPose, TaskRows, ToolRows};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, RobotModel};

use crate::arm::{
    Arm, Counts, LINEAR, NOMINAL, config, constant_force, position, push_and_hold, push_upwards, sawyer, slow_upwards,
    task, tool, tool_rows, with_jerk,
};
use crate::bounds::ceiling;

/// Asserts that no period allocates more than `most` times after the warm-up.
fn assert_allocates_at_most(what: &str, most: u64, counts: Counts) {
    println!("{what}: {counts:?}");
    assert!(counts.seen > 0, "{what}: never seen: {counts:?}");
    assert!(counts.allocations > 0, "{what}: allocates nothing, so it is no exception");
    assert!(counts.most <= most, "{what}: {counts:?}");
}

/// Which demands contradict each other is found with vectors on the heap. Where tasks are one level, their bounds are broken often.
#[test]
fn a_task_whose_bounds_are_broken_allocates_at_most_30_times() {
    for method in [Method::DampedLeastSquares, Method::Pseudoinverse] {
        let mut arm = Arm::new(ControllerConfig { method, ..slow_upwards() });
        arm.warm_up();
        let counts = arm.run(2000, |command| command.resolution.active_rows(0).next().is_some());
        assert_allocates_at_most(&format!("{method:?}"), 30, counts);
    }
}

/// `qp` allocates its programs in each period. After 8000 periods, which meet all sizes of programs, nothing more is
/// kept, and no period allocates more than one of these.
#[test]
fn what_clarabel_allocates_does_not_grow() {
    let limits = Limits::Fixed(VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap());
    let mut arm = Arm::new(ControllerConfig { solver: Solver::Qp, ..config(limits, push_and_hold()) });
    let first = arm.run(8000, |_| true);
    let later = arm.run(4000, |command| command.resolution.active_limits().next().is_some());
    println!("{first:?}, then {later:?}");
    assert!(later.seen > 1000 && later.qp == 4000, "{later:?}");
    assert_eq!(later.kept_bytes, 0, "{later:?}");
    assert!(later.most <= first.most, "{later:?}, before {first:?}");
}

/// The box of jerk limits may contradict a plane. Then the period is solved a third time.
#[test]
fn jerk_limits_before_a_plane_allocate_nothing() {
    let config = ControllerConfig {
        robot: with_jerk(),
        constraints: vec![ceiling(PlanePoint::Tool, 0.05)],
        ..push_upwards(Limits::Robot(LimitKind::PositionVelocityAcceleration))
    };
    let mut arm = Arm::new(config);
    arm.warm_up();
    let counts = arm.run(2000, |command| command.resolution.active_constraints().next().is_some());
    assert!(counts.seen > 100, "{counts:?}");
    assert_eq!(counts.allocations, 0, "{counts:?}");
}

#[test]
fn a_scaled_task_that_limits_slow_down_allocates_at_most_28_times() {
    let slow = || Limits::Fixed(VelocityBox::new(&[-0.1; 7], &[0.1; 7]).unwrap());
    for method in crate::methods::METHODS {
        let fast = Profile::sine(vec![0.0; 3], vec![0.5; 3], TAU, 0.3).unwrap();
        let scaled = TaskConfig { scaled: true, ..task("move", tool(&LINEAR), Law::Velocity(fast)) };
        let config = config(slow(), vec![scaled, task("turn", tool(&[Axis::Rx, Axis::Ry]), position(2))]);
        let mut arm = Arm::new(ControllerConfig { method, ..config });
        arm.warm_up();
        let counts = arm.run(2000, |command| command.resolution.tasks[0].scale != Some(1.0));
        assert_allocates_at_most(&format!("{method:?}"), 28, counts);
    }
}

#[test]
fn a_state_that_comes_late_allocates_at_most_22_times() {
    let mut arm = Arm::new(config(Limits::Robot(LimitKind::PositionVelocityAcceleration), push_and_hold()));
    arm.warm_up();
    let mut late = Counts::default();
    for _ in 0..100 {
        let speeds = arm.memory.as_ref().unwrap().last_command.clone();
        for (q, speed) in arm.measured.joint_position.iter_mut().zip(speeds.iter()) {
            *q += 0.005 * speed;
        }
        arm.measured.time_s += 0.005;
        let counts = arm.run(1, |_| true);
        late = Counts { most: late.most.max(counts.most), seen: 1, ..late };
        late.allocations += counts.allocations;
        arm.run(100, |_| true);
    }
    assert_allocates_at_most("late", 22, late);
}

/// Vectors of a task have places for 12 entries; longer ones are on the heap.
#[test]
fn a_posture_of_14_joints_allocates_at_most_19_times() {
    let sawyer = sawyer();
    let joints = sawyer.joints().iter().chain(sawyer.joints()).enumerate();
    let joints = joints.map(|(i, joint)| Joint { name: i.to_string(), ..joint.clone() }).collect();
    let robot = Arc::new(RobotModel::new("long", "", joints, *sawyer.tool()).unwrap());
    let target = JointTarget::Position(Profile::sine(vec![0.0; 14], vec![0.5; 14], TAU, 0.3).unwrap());
    let all = TaskRows::Joints(JointRows { joints: (0..14).collect(), target });
    let limits = Limits::Robot(LimitKind::PositionVelocity);
    let config = ControllerConfig { robot, ..config(limits, vec![task("posture", all, position(14))]) };
    let mut arm = Arm::at(config, &[NOMINAL, NOMINAL].concat());
    arm.warm_up();
    assert_allocates_at_most("14 joints", 19, arm.run(2000, |_| true));
}

#[test]
fn a_stuck_task_and_the_motion_that_leaves_its_posture_allocate_nothing() {
    let target = |by: Vector3<f64>| {
        let pose = *Configuration::new(&sawyer(), &NOMINAL).unwrap().tool_pose();
        TargetPose::Fixed(IsometryMatrix3::from_parts((pose.translation.vector + by).into(), pose.rotation))
    };
    let towards = |name: &str, axes: &[Axis], by| {
        let rows = TaskRows::Tool(ToolRows { target_pose: target(by), ..tool_rows(axes) });
        task(name, rows, position(axes.len()))
    };
    let tasks: Vec<TaskConfig> =
        vec![towards("stay", &LINEAR, Vector3::zeros()), towards("move", &[Axis::Y], Vector3::new(0.0, 0.1, 0.0))];
    let mut arm = Arm::new(config(Limits::Robot(LimitKind::PositionVelocityAcceleration), tasks));
    arm.warm_up();
    let counts = arm.run(2000, |command| !command.stuck.is_empty());
    assert!(counts.seen > 1000, "{counts:?}");
    assert_eq!(counts.allocations, 0, "{counts:?}");
}

#[test]
fn joints_that_a_brake_holds_allocate_nothing() {
    let up = task("push", tool(&[Axis::Z]), constant_force(100.0));
    let config = config(Limits::Robot(LimitKind::PositionVelocity), vec![up]);
    let mut arm = Arm::new(ControllerConfig { drive: Drive::IDEAL, ..config });
    arm.warm_up();
    let held = arm.measured.joint_position.clone();
    let mut run = |periods: u32| {
        let mut counts = Counts::default();
        for _ in 0..periods {
            arm.measured.joint_position.copy_from_slice(&held);
            let period = arm.run(1, |command| !command.stalled.is_empty());
            counts.allocations += period.allocations;
            counts.seen += period.seen;
        }
        counts
    };
    run(1500);
    let counts = run(1500);
    assert!(counts.seen > 500, "{counts:?}");
    assert_eq!(counts.allocations, 0, "{counts:?}");
}

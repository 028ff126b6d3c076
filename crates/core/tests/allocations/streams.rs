//! Streamed targets of every quantity.

use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{ControllerConfig, Limits};
use revprio_core::law::{Law, Profile};
use revprio_core::limits::LimitKind;
use revprio_core::rows::{JointRows, JointTarget, TaskRows};
use revprio_core::streaming::{Action, Align, StreamedChunk, StreamedTarget, StreamedValue};
use revprio_robot::kinematics::Axis;

use crate::arm::{Arm, LINEAR, config, constant_force, position, push_and_hold, task, tool};

/// Asserts that a period allocates nothing where a target arrives, and nothing in the 300 periods until the next one, in which
/// the task follows, holds and brakes. `k`: index of the task; `velocity`: that of the targets, m entries.
fn assert_stream_allocates_nothing(
    config: ControllerConfig,
    k: usize,
    value: &StreamedValue,
    velocity: Option<&[f64]>,
) {
    let mut arm = Arm::new(config);
    let mut run = |targets: u32| {
        let mut allocations = 0;
        for _ in 0..targets {
            let time_s = arm.measured.time_s;
            arm.measured.targets = vec![StreamedTarget {
                task: k,
                time_s,
                value: value.clone(),
                velocity: velocity.map(<[f64]>::to_vec),
                ahead: Vec::new(),
            }];
            let arrived = arm.run(1, |command| command.targets[k].streamed.is_some());
            assert_eq!(arrived.seen, 1, "{value:?}");
            arm.measured.targets.clear();
            allocations += arrived.allocations + arm.run(300, |_| true).allocations;
        }
        allocations
    };
    run(4);
    assert_eq!(run(4), 0, "{value:?}");
}

#[test]
fn streamed_targets_of_every_quantity_allocate_nothing() {
    let limits = || Limits::Robot(LimitKind::Velocity);
    let pose = StreamedValue::Pose {
        position: Some(Vector3::new(0.6, 0.1, 0.4)),
        orientation: Some(UnitQuaternion::identity()),
    };
    let target = JointTarget::Position(Profile::constant(vec![0.0; 2]).unwrap());
    let joints = TaskRows::Joints(JointRows { joints: vec![1, 4], target });
    let resting = Law::Velocity(Profile::constant(vec![0.0; 3]).unwrap());
    let alone = |rows, law| config(limits(), vec![task("streamed", rows, law)]);
    assert_stream_allocates_nothing(config(limits(), push_and_hold()), 1, &pose, None);
    for velocity in [None, Some(&[0.1, -0.1][..])] {
        let value = StreamedValue::JointPosition(vec![0.2, 0.3]);
        assert_stream_allocates_nothing(alone(joints.clone(), position(2)), 0, &value, velocity);
    }
    let value = StreamedValue::Velocity(vec![0.05, 0.0, -0.05]);
    assert_stream_allocates_nothing(alone(tool(&LINEAR), resting), 0, &value, None);
    let value = StreamedValue::Force(vec![10.0]);
    assert_stream_allocates_nothing(alone(tool(&[Axis::X]), constant_force(5.0)), 0, &value, None);
}

/// A chunk of 50 actions every 100 periods: nothing is allocated where it arrives, and nothing where it is followed.
#[test]
fn chunks_of_actions_allocate_nothing() {
    let limits = Limits::Robot(LimitKind::Velocity);
    let mut arm = Arm::new(config(limits, push_and_hold()));
    let mut run = |chunks: u32| {
        let mut allocations = 0;
        for k in 0..chunks {
            let start = arm.measured.time_s - 0.05;
            let action = |k: u32| Action {
                time_s: start + 0.02 * f64::from(k),
                value: StreamedValue::Pose {
                    position: Some(Vector3::new(0.6, 0.002 * f64::from(k), 0.4)),
                    orientation: Some(UnitQuaternion::identity()),
                },
            };
            let align = if k % 2 == 0 { Align::Time } else { Align::Progress };
            arm.measured.chunks =
                vec![StreamedChunk { channels: Vec::new(), task: 1, actions: (0..50).map(action).collect(), align }];
            let merges = |command: &revprio_core::controller::Command| {
                command.targets[1].streamed.and_then(|report| report.chunk).is_some_and(|chunk| chunk.merged.is_some())
            };
            let arrived = arm.run(1, merges);
            assert_eq!(arrived.seen, 1);
            arm.measured.chunks.clear();
            allocations += arrived.allocations + arm.run(100, |_| true).allocations;
        }
        allocations
    };
    run(12);
    assert_eq!(run(4), 0);
}

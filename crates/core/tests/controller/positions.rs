//! Position laws and null-space motions towards poses and postures.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use revprio_core::controller::{
    ConfigError, Controller, ControllerConfig, NullSpaceError, NullSpaceMotion, TaskConfig, TaskConfigError,
};
use revprio_core::law::Law;
use revprio_core::linalg::{Matrix, Svd, Vector};
use revprio_core::rows::{JointRows, JointTarget, RowsError, TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, joint_limit_gradient, joint_limit_index, orientation_error};
use revprio_robot::{JointLimits, RobotModel};

use super::arms::{
    Loop, NOMINAL, PERIOD, config, constant, controller, force, gantry, position, sawyer, task, tool_rows,
};

fn joints(joints: &[usize], target: JointTarget, law: Law) -> TaskConfig {
    let rows = TaskRows::Joints(JointRows { joints: joints.to_vec(), target });
    TaskConfig { name: "posture".to_owned(), rows, law, scaled: false, streaming: Streaming::default() }
}

fn to_pose(goal: nalgebra::IsometryMatrix3<f64>, axes: &[Axis], gain: f64) -> TaskConfig {
    let rows = ToolRows { target_pose: TargetPose::Fixed(goal), ..tool_rows(axes) };
    TaskConfig { rows: TaskRows::Tool(rows), ..task(axes, position(axes.len(), gain)) }
}

/// Returns a pose 7 cm and 0.3 rad away from the nominal pose.
fn nearby_goal() -> nalgebra::IsometryMatrix3<f64> {
    let mut goal = *Loop::at_rest(&NOMINAL).configuration(&sawyer()).tool_pose();
    goal.translation.vector += Vector3::new(0.03, -0.05, 0.04);
    goal.rotation = Rotation3::new(Vector3::new(0.2, -0.1, 0.2)) * goal.rotation;
    goal
}

#[test]
fn on_a_gantry_the_distance_to_a_pose_decays_as_powers_of_one_minus_gain_times_period() {
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let goal = nalgebra::IsometryMatrix3::translation(0.4, -0.1, 0.2);
    let controller = controller(config(&gantry(JointLimits::NONE), vec![to_pose(goal, &axes, 20.0)]));
    let mut arm = Loop::at_rest(&[0.0; 3]);
    for i in 1..=500 {
        arm.step(&controller, [0.0; 6]);
        let left = (1.0 - 20.0 * PERIOD).powi(i);
        for (q, goal) in arm.q.iter().zip([0.4, -0.1, 0.2]) {
            assert!((q - goal * (1.0 - left)).abs() < 1e-14, "period {i}: {q}");
        }
    }
}

#[test]
fn on_sawyer_the_distance_to_a_pose_decays_exponentially_with_the_gain() {
    let (robot, goal) = (sawyer(), nearby_goal());
    let controller = controller(config(&robot, vec![to_pose(goal, &Axis::ALL, 4.0)]));
    let mut arm = Loop::at_rest(&NOMINAL);
    let distance = |arm: &Loop| {
        let pose = *arm.configuration(&robot).tool_pose();
        let turn = orientation_error(&pose.rotation, &goal.rotation).norm();
        ((pose.translation.vector - goal.translation.vector).norm(), turn)
    };
    let (initial_distance, initial_angle) = distance(&arm);
    for second in 1..=5 {
        (0..1000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
        let left = (-4.0 * f64::from(second)).exp();
        let now = distance(&arm);
        // Steps of 1 ms along straight joint paths: a few percent of error over e^-20.
        assert!((now.0 / (initial_distance * left) - 1.0).abs() < 0.06, "{second} s: {} m", now.0);
        assert!((now.1 / (initial_angle * left) - 1.0).abs() < 0.06, "{second} s: {} rad", now.1);
    }
}

#[test]
fn a_posture_of_some_joints_moves_them_exponentially_and_leaves_the_others_at_rest() {
    let target = [-0.2, 1.0];
    let posture = joints(&[1, 4], JointTarget::Position(constant(&target)), position(2, 3.0));
    let controller = controller(config(&sawyer(), vec![posture]));
    let mut arm = Loop::at_rest(&NOMINAL);
    for i in 1..=1000 {
        arm.step(&controller, [0.0; 6]);
        let left = (1.0 - 3.0 * PERIOD).powi(i);
        for (joint, q) in arm.q.iter().enumerate() {
            let goal = [1, 4].iter().position(|chosen| *chosen == joint).map_or(NOMINAL[joint], |row| target[row]);
            assert!((q - goal - (NOMINAL[joint] - goal) * left).abs() < 1e-13, "period {i}, joint {joint}: {q}");
        }
    }
}

#[test]
fn a_moving_posture_is_followed_without_lag() {
    let ramp = revprio_core::law::Profile::ramp(vec![NOMINAL[3]], vec![NOMINAL[3] + 0.5], 0.0, 1.0).unwrap();
    let controller = controller(config(&sawyer(), vec![joints(&[3], JointTarget::Position(ramp), position(1, 5.0))]));
    let mut arm = Loop::at_rest(&NOMINAL);
    for i in 1..=1000 {
        arm.step(&controller, [0.0; 6]);
        assert!((arm.q[3] - NOMINAL[3] - 0.5e-3 * f64::from(i)).abs() < 1e-12, "period {i}");
    }
}

#[test]
fn a_posture_towards_mid_range_decreases_the_joint_limit_index() {
    let robot = sawyer();
    let all: Vec<usize> = (0..7).collect();
    let controller = controller(config(&robot, vec![joints(&all, JointTarget::MidRange, position(7, 2.0))]));
    let mut arm = Loop::at_rest(&NOMINAL);
    let command = arm.step(&controller, [0.0; 6]);
    let expected = joint_limit_gradient(&robot, &NOMINAL) * -2.0;
    assert!((&command.resolution.joint_velocity - expected).amax() < 1e-15);
    let mut before = joint_limit_index(&robot, &NOMINAL);
    assert_eq!(command.joint_limit_index, before);
    for _ in 0..1000 {
        arm.step(&controller, [0.0; 6]);
        let now = joint_limit_index(&robot, &arm.q);
        assert!(now < before);
        before = now;
    }
}

/// Returns the arm after it held its pose for 8 s with this motion in the null space.
fn hold_pose_with(motion: NullSpaceMotion) -> Loop {
    let robot = sawyer();
    let start = *Loop::at_rest(&NOMINAL).configuration(&robot).tool_pose();
    let hold = to_pose(start, &Axis::ALL, 10.0);
    let controller = controller(ControllerConfig { null_space: Some(motion), ..config(&robot, vec![hold]) });
    let mut arm = Loop::at_rest(&NOMINAL);
    for _ in 0..8000 {
        arm.step(&controller, [0.0; 6]);
        let now = *arm.configuration(&robot).tool_pose();
        assert!((now.to_homogeneous() - start.to_homogeneous()).amax() < 1e-4, "the tool must stand still: {now}");
    }
    arm
}

/// Returns the unit vector of the null space of the tool Jacobian.
fn null_space_direction(robot: &RobotModel, q: &[f64]) -> Vector {
    let configuration = revprio_robot::kinematics::Configuration::new(robot, q).unwrap();
    let jacobian = Matrix::from_fn(6, 7, |i, j| configuration.jacobian()[(i, j)]);
    let projector = Matrix::identity(7, 7) - Svd::new(&jacobian).inverse(6, 0.0) * &jacobian;
    let (largest, _) = projector.diagonal().argmax();
    projector.column(largest).normalize()
}

#[test]
fn joint_limit_motion_in_the_null_space_minimises_the_index_without_moving_the_tool() {
    let robot = sawyer();
    let arm = hold_pose_with(NullSpaceMotion::JointLimits { gain: 100.0 });
    assert!(joint_limit_index(&robot, &arm.q) < joint_limit_index(&robot, &NOMINAL) - 1e-3);
    let slope = |q: &[f64]| joint_limit_gradient(&robot, q).dot(&null_space_direction(&robot, q)).abs();
    assert!(slope(&arm.q) < 1e-3 * slope(&NOMINAL), "{} {}", slope(&arm.q), slope(&NOMINAL));
}

#[test]
fn a_posture_in_the_null_space_is_approached_without_moving_the_tool() {
    let robot = sawyer();
    let mut target = NOMINAL.to_vec();
    target[0] -= 0.4;
    let arm = hold_pose_with(NullSpaceMotion::Posture { joint_position: target.clone(), gain: 5.0 });
    let left = Vector::from_vec(target) - Vector::from_row_slice(&arm.q);
    assert!(left.norm() < 0.399);
    assert!(left.dot(&null_space_direction(&robot, &arm.q)).abs() < 1e-4);
}

#[test]
fn a_constant_null_space_velocity_moves_the_joints_but_not_the_tool() {
    let free = null_space_direction(&sawyer(), &NOMINAL);
    let hold = task(&Axis::ALL, Law::Velocity(constant(&[0.0; 6])));
    let null_space = Some(NullSpaceMotion::Constant(&free * 0.3));
    let controller = controller(ControllerConfig { null_space, ..config(&sawyer(), vec![hold]) });
    let command = Loop::at_rest(&NOMINAL).step(&controller, [0.0; 6]);
    assert!((command.resolution.joint_velocity - free * 0.3).amax() < 1e-12);
}

fn refusal(config: ControllerConfig) -> ConfigError {
    Controller::new(config).unwrap_err()
}

fn task_refusal(robot: &Arc<RobotModel>, task: TaskConfig) -> TaskConfigError {
    match refusal(config(robot, vec![task])) {
        ConfigError::Task { task: 0, source } => source,
        other => panic!("{other}"),
    }
}

#[test]
fn unstable_gains_are_refused_and_gains_just_below_the_bound_converge() {
    let (robot, axes) = (gantry(JointLimits::NONE), [Axis::X]);
    let goal = nalgebra::IsometryMatrix3::translation(1.0, 0.0, 0.0);
    let refused = task_refusal(&robot, to_pose(goal, &axes, 2000.0));
    assert_eq!(refused, TaskConfigError::Unstable { row: 0, gain: 2000.0, bound: 2000.0 });
    let controller = controller(config(&robot, vec![to_pose(goal, &axes, 1990.0)]));
    let mut arm = Loop::at_rest(&[0.0; 3]);
    (0..3000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    assert!((arm.q[0] - 1.0).abs() < 1e-9, "{}", arm.q[0]);
    let with =
        |motion| ControllerConfig { null_space: Some(motion), ..config(&robot, vec![to_pose(goal, &axes, 1.0)]) };
    let unstable = NullSpaceMotion::Posture { joint_position: vec![0.0; 3], gain: 2000.0 };
    assert!(matches!(refusal(with(unstable)), ConfigError::NullSpace(NullSpaceError::Unstable { .. })));
}

#[test]
fn the_gain_bound_towards_mid_range_depends_on_the_range() {
    // 1/(n half²) = 1/(3 · 0.01), so the smallest unstable gain is 2 · 0.03 / T.
    let limits = JointLimits { lower: -0.1, upper: 0.1, ..JointLimits::NONE };
    let robot = gantry(limits);
    let with = |gain: f64| joints(&[0], JointTarget::MidRange, position(1, gain));
    assert!(matches!(task_refusal(&robot, with(60.001)), TaskConfigError::Unstable { .. }));
    let controller = controller(config(&robot, vec![with(59.9)]));
    let mut arm = Loop::at_rest(&[0.05, 0.0, 0.0]);
    (0..10_000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    assert!(arm.q[0].abs() < 1e-9, "{}", arm.q[0]);
    let null_space = |gain| ControllerConfig {
        null_space: Some(NullSpaceMotion::JointLimits { gain }),
        ..config(&robot, vec![with(1.0)])
    };
    assert!(matches!(refusal(null_space(60.001)), ConfigError::NullSpace(NullSpaceError::Unstable { .. })));
    assert!(Controller::new(null_space(59.9)).is_ok());
}

#[test]
fn invalid_joint_rows_are_refused() {
    let robot = gantry(JointLimits::NONE);
    for chosen in [vec![], vec![3], vec![1, 1]] {
        let target = JointTarget::Position(constant(&vec![0.0; chosen.len()]));
        let law = position(chosen.len(), 1.0);
        assert_eq!(
            task_refusal(&robot, joints(&chosen, target, law)),
            TaskConfigError::Rows(RowsError::Joints),
            "{chosen:?}"
        );
    }
    let rangeless = joints(&[0], JointTarget::MidRange, position(1, 1.0));
    assert_eq!(task_refusal(&robot, rangeless), TaskConfigError::Rows(RowsError::Joints));
    let pushed = joints(&[0], JointTarget::Position(constant(&[0.0])), force(&[Axis::X], &[1.0]));
    assert_eq!(task_refusal(&robot, pushed), TaskConfigError::Rows(RowsError::JointLaw));
    let short = joints(&[0, 1], JointTarget::Position(constant(&[0.0])), position(2, 1.0));
    assert_eq!(task_refusal(&robot, short), TaskConfigError::Rows(RowsError::Rows { expected: 2, given: 1 }));
    let wide = joints(&[0, 1], JointTarget::Position(constant(&[0.0; 2])), position(3, 1.0));
    assert_eq!(task_refusal(&robot, wide), TaskConfigError::Rows(RowsError::Rows { expected: 2, given: 3 }));
}

//! Tasks with bounds in the place of a law, and tasks of constant rows.

use revprio_core::controller::{ConfigError, Controller, ControllerConfig, TaskConfig, TaskConfigError};
use revprio_core::law::{Law, VelocityBounds};
use revprio_core::linalg::Matrix;
use revprio_core::resolution::{Method, Side};
use revprio_core::rows::{RawRows, RowsError, TaskRows};
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::Axis;

use crate::arms::{
    Loop, NOMINAL, PERIOD, config, constant, controller, force, measurement, position, sawyer, step, task,
};

fn between(lower: &[f64], upper: &[f64]) -> Law {
    Law::Bounds(VelocityBounds::new(lower.to_vec(), upper.to_vec()).unwrap())
}

fn raw(rows: &[[f64; 7]], law: Law) -> TaskConfig {
    let jacobian = Matrix::from_fn(rows.len(), 7, |i, j| rows[i][j]);
    TaskConfig {
        name: "raw".to_owned(),
        rows: TaskRows::Raw(RawRows { jacobian }),
        law,
        scaled: false,
        streaming: Streaming::default(),
    }
}

fn strict(tasks: Vec<TaskConfig>) -> ControllerConfig {
    ControllerConfig { method: Method::StrictReversePriority, damping: None, ..config(&sawyer(), tasks) }
}

const SUM: [[f64; 7]; 2] = [[1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0, -2.0, 0.0]];

#[test]
fn constant_rows_follow_a_velocity() {
    let rows = raw(&SUM, Law::Velocity(constant(&[0.3, -0.1])));
    let controller = controller(strict(vec![rows, task(&[Axis::X], Law::Velocity(constant(&[0.02])))]));
    let command = Loop::at_rest(&NOMINAL).step(&controller, [0.0; 6]);
    let qdot = &command.resolution.joint_velocity;
    assert!((qdot[0] + qdot[1] - 0.3).abs() < 1e-12 && (qdot[3] - 2.0 * qdot[5] + 0.1).abs() < 1e-12, "{qdot}");
    assert!((command.resolution.tasks[1].achieved[0] - 0.02).abs() < 1e-12);
    assert_eq!(command.targets[0].velocity.as_slice(), [0.3, -0.1]);
    assert_eq!(command.targets[0].force, [None, None]);
}

#[test]
fn a_lower_task_is_free_inside_bounds_and_held_back_at_them() {
    for (velocity, kept, target) in [(0.01, 0.01, 0.01), (0.5, 0.02, 0.02), (-0.5, -0.03, -0.03)] {
        let bounds = task(&[Axis::Z], between(&[-0.03], &[0.02]));
        let lift = TaskConfig { name: "lift".to_owned(), ..task(&[Axis::Z], Law::Velocity(constant(&[velocity]))) };
        let command = step(&controller(strict(vec![bounds, lift])), &mut None, &measurement(&NOMINAL)).unwrap();
        let [bounds, lift] = &command.resolution.tasks[..] else { panic!("{command:?}") };
        assert!((lift.achieved[0] - kept).abs() < 1e-12 && bounds.residual_norm < 1e-12, "{command:?}");
        assert!((command.targets[0].velocity[0] - target).abs() < 1e-12);
        let sides: Vec<Side> = command.resolution.active_rows(0).map(|(_, active)| active.bound.side).collect();
        let expected: &[Side] = match velocity {
            0.5 => &[Side::Upper],
            -0.5 => &[Side::Lower],
            _ => &[],
        };
        assert_eq!(sides, expected);
    }
}

#[test]
fn bounds_that_another_bound_excludes_are_violated_least() {
    let slow = task(&[Axis::Z], between(&[f64::NEG_INFINITY], &[0.02]));
    let fast = TaskConfig { name: "fast".to_owned(), ..task(&[Axis::Z], between(&[0.1], &[f64::INFINITY])) };
    let command = step(&controller(strict(vec![slow, fast])), &mut None, &measurement(&NOMINAL)).unwrap();
    let fast = &command.resolution.tasks[1];
    assert!((fast.achieved[0] - 0.02).abs() < 1e-9 && (fast.residual_norm - 0.08).abs() < 1e-9, "{command:?}");
    assert_eq!(command.targets[1].velocity.as_slice(), [0.1]);
    assert_eq!(command.resolution.contradictions[0].task, Some(1));
}

#[test]
fn an_integrator_that_bounds_hold_back_does_not_wind_up() {
    let slow = TaskConfig { name: "slow".to_owned(), ..task(&[Axis::X], between(&[-0.01], &[0.01])) };
    let controller = controller(strict(vec![slow, task(&[Axis::X], force(&[Axis::X], &[30.0]))]));
    let mut arm = Loop::at_rest(&NOMINAL);
    for _ in 0..100 {
        arm.step(&controller, [0.0; 6]);
    }
    // Without the bound, the force law would reach 0.13 m/s by now.
    let integrator = arm.memory.as_ref().unwrap().task_velocities[1][0];
    assert!((integrator - 0.01).abs() < 1e-9, "{integrator}");
    let pushed_back = arm.step(&controller, [60.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(pushed_back.resolution.tasks[1].achieved[0] < 0.01 - PERIOD, "{pushed_back:?}");
}

#[test]
fn constant_rows_and_bounds_that_do_not_fit_are_refused() {
    let refused = |task: TaskConfig| match Controller::new(config(&sawyer(), vec![task])).unwrap_err() {
        ConfigError::Task { task: 0, source } => source,
        other => panic!("{other}"),
    };
    let velocity = || Law::Velocity(constant(&[0.0, 0.0]));
    let with = |jacobian: Matrix| TaskConfig { rows: TaskRows::Raw(RawRows { jacobian }), ..raw(&SUM, velocity()) };
    assert_eq!(refused(with(Matrix::zeros(2, 6))), TaskConfigError::Rows(RowsError::Jacobian { expected: 7 }));
    assert_eq!(
        refused(with(Matrix::from_element(2, 7, f64::NAN))),
        TaskConfigError::Rows(RowsError::Jacobian { expected: 7 })
    );
    assert_eq!(refused(with(Matrix::zeros(1, 7))), TaskConfigError::Rows(RowsError::Rows { expected: 1, given: 2 }));
    let no_rows = TaskConfig { law: between(&[], &[]), ..with(Matrix::zeros(0, 7)) };
    assert_eq!(refused(no_rows), TaskConfigError::Rows(RowsError::Jacobian { expected: 7 }));
    assert_eq!(refused(raw(&SUM, position(2, 1.0))), TaskConfigError::Rows(RowsError::RawLaw));
    assert_eq!(refused(raw(&SUM, force(&[Axis::X, Axis::Y], &[1.0, 1.0]))), TaskConfigError::Rows(RowsError::RawLaw));
    let scaled = TaskConfig { scaled: true, ..task(&[Axis::X], between(&[0.0], &[1.0])) };
    assert_eq!(refused(scaled), TaskConfigError::Scaled);
    assert_eq!(
        refused(task(&[Axis::X], between(&[0.0, 0.0], &[1.0, 1.0]))),
        TaskConfigError::Rows(RowsError::Rows { expected: 1, given: 2 })
    );
}

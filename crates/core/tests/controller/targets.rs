//! Moving targets.

use nalgebra::{Rotation3, Vector3};
use revprio_core::controller::TaskConfig;
use revprio_core::law::{Law, Point, Profile};
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_robot::JointLimits;
use revprio_robot::kinematics::{Axis, orientation_error};

use super::arms::{
    Loop, NOMINAL, PERIOD, config, constant, controller, gantry, hybrid, impedance, position, sawyer, task, tool_rows,
};

fn displaced(axes: &[Axis], law: Law, displacement: Profile) -> TaskConfig {
    let rows = ToolRows { target_displacement: Some(displacement), ..tool_rows(axes) };
    TaskConfig { rows: TaskRows::Tool(rows), ..task(axes, law) }
}

#[test]
fn a_uniformly_moving_target_is_followed_without_steady_error() {
    let axes = [Axis::X];
    let ramp = || Profile::ramp(vec![0.0], vec![1.0], 0.5, 10.0).unwrap();
    let laws = [impedance(&axes, 1000.0), hybrid(&axes, 1000.0, &[7.0], &[true]), position(1, 5.0)];
    for law in laws {
        let context = format!("{law:?}");
        let controller = controller(config(&gantry(JointLimits::NONE), vec![displaced(&axes, law, ramp())]));
        let mut arm = Loop::at_rest(&[0.3, 0.0, 0.0]);
        (0..6000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
        let lag = arm.q[0] - 0.3 - ramp().at(6000.0 * PERIOD).value[0];
        assert!(lag.abs() < 1e-11, "{context}: {lag:e} m");
    }
}

#[test]
fn an_oscillating_target_is_followed_with_an_error_proportional_to_the_period() {
    let axes = [Axis::X];
    let oscillation = || Profile::sine(vec![0.0], vec![0.1], 4.0, 0.0).unwrap();
    let largest_lag = |period: f64| {
        let moving = displaced(&axes, impedance(&axes, 1000.0), oscillation());
        let given = config(&gantry(JointLimits::NONE), vec![moving]);
        let controller = controller(revprio_core::controller::ControllerConfig { period_s: period, ..given });
        let mut arm = Loop::at_rest(&[0.0; 3]);
        let mut largest = 0.0_f64;
        let mut t = 0.0;
        while t < 6.0 {
            if t > 3.0 {
                largest = largest.max((arm.q[0] - oscillation().at(t).value[0]).abs());
            }
            arm.step(&controller, [0.0; 6]);
            t += period;
        }
        largest
    };
    let (coarse, fine) = (largest_lag(2e-3), largest_lag(1e-3));
    assert!(coarse < 1e-3 && (coarse / fine - 2.0).abs() < 0.1, "{coarse} m, {fine} m");
}

#[test]
fn a_target_pose_that_translates_and_rotates_is_followed() {
    let robot = sawyer();
    let point = |time_s: f64, value: [f64; 6]| Point { time_s, value: value.to_vec() };
    let last = [0.05, -0.04, 0.03, 0.2, 0.3, -0.1];
    let path = [point(0.0, [0.0; 6]), point(1.0, [0.02, 0.03, -0.02, 0.3, -0.1, 0.2]), point(2.0, last)];
    for law in [impedance(&Axis::ALL, 1000.0), position(6, 5.0)] {
        let profile = Profile::waypoints(&path).unwrap();
        let controller = controller(config(&robot, vec![displaced(&Axis::ALL, law, profile.clone())]));
        let mut arm = Loop::at_rest(&NOMINAL);
        let start = *arm.configuration(&robot).tool_pose();
        for i in 0..2500 {
            let pose = *arm.configuration(&robot).tool_pose();
            let now = profile.at(f64::from(i) * PERIOD).value;
            let vector = |from: usize| Vector3::new(now[from], now[from + 1], now[from + 2]);
            let lag = pose.translation.vector - start.translation.vector - vector(0);
            let turn = orientation_error(&pose.rotation, &(Rotation3::new(vector(3)) * start.rotation));
            assert!(lag.norm() < 2e-4 && turn.norm() < 2e-3, "period {i}: {} m, {} rad", lag.norm(), turn.norm());
            arm.step(&controller, [0.0; 6]);
        }
    }
}

#[test]
fn a_constant_zero_displacement_changes_nothing() {
    let plain = controller(config(&sawyer(), vec![task(&Axis::ALL, impedance(&Axis::ALL, 700.0))]));
    let zero = displaced(&Axis::ALL, impedance(&Axis::ALL, 700.0), constant(&[0.0; 6]));
    let displaced = controller(config(&sawyer(), vec![zero]));
    let (mut one, mut other) = (Loop::at_rest(&NOMINAL), Loop::at_rest(&NOMINAL));
    for _ in 0..200 {
        let push = [10.0, -3.0, 2.0, 0.5, 0.2, -0.1];
        let difference =
            one.step(&plain, push).resolution.joint_velocity - other.step(&displaced, push).resolution.joint_velocity;
        assert!(difference.amax() < 1e-13);
    }
}

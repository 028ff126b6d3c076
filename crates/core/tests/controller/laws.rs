//! The laws with a free arm, under a push, and compared with each other.

use nalgebra::{Rotation3, Translation3, Vector3};
use revprio_core::controller::{TaskConfig, WrenchConvention};
use revprio_core::law::Law;
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_robot::JointLimits;
use revprio_robot::kinematics::{Axis, Configuration};

use super::arms::{
    Loop, NOMINAL, PERIOD, Random, config, controller, force, gains, gantry, hybrid, impedance, measurement, sawyer,
    step, task, tool_rows,
};

#[test]
fn a_free_gantry_approaches_f_over_b_exactly_as_the_recursion() {
    let robot = gantry(JointLimits::NONE);
    let controller = controller(config(&robot, vec![task(&[Axis::X], force(&[Axis::X], &[30.0]))]));
    let mut arm = Loop::at_rest(&[0.0; 3]);
    // ẋ_i = F_d/B_d (1 − (1 − T B_d/M_d)^i): Euler steps towards 0.2 m/s.
    for i in 1..=3000 {
        let command = arm.step(&controller, [0.0; 6]);
        let expected = 0.2 * (1.0 - (1.0 - PERIOD * 150.0 / 15.0_f64).powi(i));
        let error = (command.resolution.joint_velocity[0] - expected).abs();
        assert!(error < 1e-13, "period {i}: off by {error:e}");
    }
    assert!((arm.twist(&robot)[0] - 0.2).abs() < 1e-12);
}

#[test]
fn a_free_sawyer_follows_the_recursion_with_its_measured_velocity() {
    let robot = sawyer();
    let rest = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task(&[Axis::X], force(&[Axis::X], &[30.0])), task(&rest, force(&rest, &[0.0; 5]))];
    let controller = controller(config(&robot, tasks));
    let mut arm = Loop::at_rest(&NOMINAL);
    let mut velocity = 0.0;
    for i in 0..1000 {
        velocity += PERIOD / 15.0 * (30.0 - 150.0 * arm.twist(&robot)[0]);
        let command = arm.step(&controller, [0.0; 6]);
        let error = (command.resolution.tasks[0].achieved[0] - velocity).abs();
        assert!(error < 1e-12, "period {i}: off by {error:e}");
    }
    assert!((velocity - 0.2).abs() < 1e-3, "{velocity} m/s");
}

#[test]
fn an_impedance_on_a_gantry_follows_the_recursion_of_mass_damper_and_spring() {
    let robot = gantry(JointLimits::NONE);
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let controller = controller(config(&robot, vec![task(&axes, impedance(&axes, 1000.0))]));
    let mut arm = Loop::at_rest(&[0.5, -0.2, 0.1]);
    let (mut x, mut v) = (0.0, 0.0);
    for i in 0..2000 {
        let push = if i < 1000 { 20.0 } else { 0.0 };
        arm.step(&controller, [push, 0.0, 0.0, 0.0, 0.0, 0.0]);
        v += PERIOD / 15.0 * (-150.0 * v - 1000.0 * x - push);
        x += PERIOD * v;
        assert!((arm.q[0] - 0.5 - x).abs() < 1e-13, "period {i}");
        assert!((arm.q[1] + 0.2).abs().max((arm.q[2] - 0.1).abs()) < 1e-13, "period {i}");
    }
}

/// Returns the displacement (m) and the rotation angle (rad) from the pose at `start`.
fn displacement(start: &Configuration, now: &Configuration) -> (Vector3<f64>, f64) {
    let (start, now) = (start.tool_pose(), now.tool_pose());
    (now.translation.vector - start.translation.vector, (now.rotation * start.rotation.inverse()).angle())
}

#[test]
fn an_impedance_yields_to_a_push_by_f_over_k_and_returns_to_the_initial_pose() {
    let robot = sawyer();
    let controller = controller(config(&robot, vec![task(&Axis::ALL, impedance(&Axis::ALL, 500.0))]));
    let mut arm = Loop::at_rest(&NOMINAL);
    let start = arm.configuration(&robot);
    (0..10_000).for_each(|_| drop(arm.step(&controller, [20.0, 0.0, -10.0, 0.0, 5.0, 0.0])));
    let (moved, turned) = displacement(&start, &arm.configuration(&robot));
    assert!((moved - Vector3::new(-20.0, 0.0, 10.0) / 500.0).amax() < 1e-6, "{moved}");
    assert!((turned - 5.0 / 500.0).abs() < 1e-6, "{turned}");
    (0..10_000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let (moved, turned) = displacement(&start, &arm.configuration(&robot));
    assert!(moved.amax() < 1e-6 && turned < 1e-6, "{moved}, {turned}");
}

#[test]
fn an_impedance_about_a_fixed_pose_reaches_that_pose() {
    let robot = sawyer();
    let mut goal = *Loop::at_rest(&NOMINAL).configuration(&robot).tool_pose();
    goal.append_translation_mut(&Translation3::new(0.03, -0.02, 0.04));
    goal.rotation = Rotation3::new(Vector3::new(0.1, -0.05, 0.02)) * goal.rotation;
    let rows = ToolRows { target_pose: TargetPose::Fixed(goal), ..tool_rows(&Axis::ALL) };
    let fixed = TaskConfig { rows: TaskRows::Tool(rows), ..task(&Axis::ALL, impedance(&Axis::ALL, 500.0)) };
    let controller = controller(config(&robot, vec![fixed]));
    let mut arm = Loop::at_rest(&NOMINAL);
    (0..15_000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let reached = *arm.configuration(&robot).tool_pose();
    assert!((reached.to_homogeneous() - goal.to_homogeneous()).amax() < 1e-6, "{reached}");
}

/// Returns the task velocities of a law on all axes under random states and wrenches.
fn velocities_over_time(law: Law) -> Vec<Vec<f64>> {
    let robot = sawyer();
    let controller = controller(config(&robot, vec![task(&Axis::ALL, law)]));
    let mut random = Random(1);
    let (mut memory, mut velocities) = (None, Vec::new());
    for _ in 0..200 {
        let mut measured = measurement(&NOMINAL.map(|q| q + 0.1 * random.signed()));
        measured.joint_velocity = Some((0..7).map(|_| random.signed()).collect());
        measured.wrench = [0.0; 6].map(|_: f64| 20.0 * random.signed());
        let command = step(&controller, &mut memory, &measured).unwrap();
        velocities.push(command.targets[0].velocity.as_slice().to_vec());
    }
    velocities
}

#[test]
fn hybrid_is_the_force_law_on_force_axes_and_the_impedance_law_on_position_axes() {
    let target = [30.0, 5.0, -3.0, 1.0, 2.0, -1.0];
    let force = velocities_over_time(force(&Axis::ALL, &target));
    let impedance = velocities_over_time(impedance(&Axis::ALL, 700.0));
    for selection in 0..64_u32 {
        let position: [bool; 6] = std::array::from_fn(|row| selection >> row & 1 == 1);
        let hybrid = velocities_over_time(hybrid(&Axis::ALL, 700.0, &target, &position));
        for (i, velocity) in hybrid.iter().enumerate() {
            for row in 0..6 {
                let expected = if position[row] { impedance[i][row] } else { force[i][row] };
                let error = (velocity[row] - expected).abs();
                assert!(error < 1e-13, "S = {position:?}, period {i}, row {row}: off by {error:e}");
            }
        }
    }
}

#[test]
fn a_wrench_on_the_tool_is_the_negative_of_the_wrench_on_the_environment() {
    let robot = sawyer();
    let axes = [Axis::Z, Axis::Rx];
    let given = config(&robot, vec![task(&axes, force(&axes, &[10.0, 0.0]))]);
    let on_tool = controller(revprio_core::controller::ControllerConfig {
        wrench_convention: WrenchConvention::OnTool,
        ..given.clone()
    });
    let (mut one, mut other) = (Loop::at_rest(&NOMINAL), Loop::at_rest(&NOMINAL));
    let given = controller(given);
    for i in 0..100 {
        let push = f64::from(i);
        let wrench = [0.0, 0.0, push, 0.1 * push, 0.0, 0.0];
        assert_eq!(one.step(&given, wrench), other.step(&on_tool, wrench.map(|entry| -entry)));
    }
}

#[test]
fn the_first_period_continues_the_measured_motion() {
    let robot = sawyer();
    let controller = controller(config(&robot, vec![task(&Axis::ALL, force(&Axis::ALL, &[30.0; 6]))]));
    let moving = [0.1, -0.2, 0.05, 0.3, -0.1, 0.2, 0.4];
    let mut memory = None;
    let measured =
        revprio_core::controller::Measurement { joint_velocity: Some(moving.to_vec()), ..measurement(&NOMINAL) };
    let command = step(&controller, &mut memory, &measured).unwrap();
    let twist = Loop::at_rest(&NOMINAL).configuration(&robot).twist(&moving);
    let gains = gains(&Axis::ALL, 0.0);
    for (row, speed) in twist.into_iter().enumerate() {
        let inertia = if row < 3 { 15.0 } else { 80.0 };
        let expected = speed + PERIOD / inertia * (30.0 - gains.damping()[row] * speed);
        assert!((command.targets[0].velocity[row] - expected).abs() < 1e-15, "row {row}");
    }
}

#[test]
fn the_last_command_replaces_a_missing_joint_velocity() {
    let robot = sawyer();
    let controller = controller(config(&robot, vec![task(&Axis::ALL, force(&Axis::ALL, &[30.0; 6]))]));
    let (mut measuring, mut commanded) = (Loop::at_rest(&NOMINAL), Loop::at_rest(&NOMINAL));
    for _ in 0..500 {
        let last = measuring.memory.as_ref().map_or(vec![0.0; 7], |memory| memory.last_command.as_slice().to_vec());
        let measured = revprio_core::controller::Measurement {
            joint_velocity: Some(last),
            ..measuring.measurement(PERIOD, [0.0; 6])
        };
        let command = step(&controller, &mut measuring.memory, &measured).unwrap();
        measuring.follow(&command, PERIOD);
        assert_eq!(command, commanded.step(&controller, [0.0; 6]));
    }
    // If the arm stands still against its command, the law has no damping term.
    let integrator = commanded.memory.as_ref().unwrap().task_velocities[0].clone();
    let standing = revprio_core::controller::Measurement {
        joint_velocity: Some(vec![0.0; 7]),
        ..commanded.measurement(PERIOD, [0.0; 6])
    };
    let command = step(&controller, &mut commanded.memory, &standing).unwrap();
    assert!((command.targets[0].velocity[0] - (integrator[0] + PERIOD * 30.0 / 15.0)).abs() < 1e-15);
}

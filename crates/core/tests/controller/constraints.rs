//! Virtual walls, inequalities and scaled tasks in closed loop.

use revprio_core::constraint::{Constraint, Inequality, MAX_CONSTRAINT_ROWS, PlanePoint, VirtualPlane};
use revprio_core::controller::{ConfigError, Controller, ControllerConfig, Limits, TaskConfig};
use revprio_core::limits::{LimitKind, VelocityBox};
use revprio_core::linalg::{Damping, Vector};
use revprio_core::resolution::{Solver, Status};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Axis, Configuration};

use super::arms::{Loop, NOMINAL, PERIOD, config, controller, force, impedance, sawyer, task};

/// Tolerance, m: the inequality is exact to first order of the displacement in one period.
const SECOND_ORDER: f64 = 1e-6;

fn height(robot: &RobotModel, q: &[f64], point: PlanePoint) -> f64 {
    let configuration = Configuration::new(robot, q).unwrap();
    point.position(&configuration).z
}

/// Pushes upwards with 100 N against a virtual ceiling at `distance` (m) above `point`.
fn push_against_ceiling(point: PlanePoint, distance: f64) {
    let robot = sawyer();
    let ceiling = height(&robot, &NOMINAL, point) + distance;
    let plane = VirtualPlane::new("ceiling", [0.0, 0.0, 2.0], ceiling, point, 10.0).unwrap();
    let up = task(&[Axis::Z], force(&[Axis::Z], &[100.0]));
    let controller = controller(ControllerConfig {
        constraints: vec![Constraint::Plane(plane)],
        limits: Limits::Robot(LimitKind::PositionVelocity),
        ..config(&robot, vec![up, task(&[Axis::X, Axis::Y], impedance(&[Axis::X, Axis::Y], 500.0))])
    });
    let mut arm = Loop::at_rest(&NOMINAL);
    let mut active_periods = 0;
    for _ in 0..2000 {
        let before = ceiling - height(&robot, &arm.q, point);
        let command = arm.step(&controller, [0.0; 6]);
        let after = ceiling - height(&robot, &arm.q, point);
        assert!(after >= (1.0 - 10.0 * PERIOD) * before - SECOND_ORDER, "from {before} m to {after} m in one period");
        assert_eq!(command.resolution.solver.status, Status::Optimal);
        active_periods += usize::from(command.resolution.active_constraints().next().is_some());
    }
    let remaining = ceiling - height(&robot, &arm.q, point);
    assert!((-SECOND_ORDER..0.01).contains(&remaining), "{remaining} m below the ceiling");
    assert!(active_periods > 500, "the ceiling is active in only {active_periods} periods");
}

#[test]
fn the_tool_approaches_a_virtual_wall_exponentially_and_never_passes_it() {
    push_against_ceiling(PlanePoint::Tool, 0.05);
}

#[test]
fn the_elbow_approaches_a_virtual_wall_exponentially_and_never_passes_it() {
    push_against_ceiling(PlanePoint::Joint(3), 0.02);
}

#[test]
fn an_arm_behind_a_wall_returns() {
    let robot = sawyer();
    let ceiling = height(&robot, &NOMINAL, PlanePoint::Tool) - 0.03;
    let plane = VirtualPlane::new("ceiling", [0.0, 0.0, 1.0], ceiling, PlanePoint::Tool, 10.0).unwrap();
    let controller = controller(ControllerConfig {
        constraints: vec![Constraint::Plane(plane)],
        limits: Limits::Robot(LimitKind::PositionVelocityAcceleration),
        ..config(&robot, vec![task(&[Axis::Z], force(&[Axis::Z], &[100.0]))])
    });
    let mut arm = Loop::at_rest(&NOMINAL);
    let first = arm.step(&controller, [0.0; 6]).resolution;
    // From rest, the acceleration limit allows less than the wall demands. The wall is violated and named.
    assert_eq!(first.broken_constraints().count(), 1);
    assert!(first.broken_limits().next().is_none());
    (0..1500).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
    let above = height(&robot, &arm.q, PlanePoint::Tool) - ceiling;
    assert!(above.abs() < 1e-4, "{above} m above the ceiling");
}

/// Returns planes that touch a ball of 3 cm around the tool in its first posture.
fn planes_around_the_tool(count: usize) -> Vec<Constraint> {
    let center = Configuration::new(&sawyer(), &NOMINAL).unwrap().tool_pose().translation.vector;
    let plane = |number: usize| {
        // Directions that are spread evenly over the sphere.
        let (height, turn) = ((2 * number + 1) as f64 / count as f64 - 1.0, 2.4 * number as f64);
        let radius = (1.0 - height * height).sqrt();
        let normal = [radius * turn.cos(), radius * turn.sin(), height];
        let offset = normal.iter().zip(center.iter()).map(|(n, x)| n * x).sum::<f64>() + 0.03;
        Constraint::Plane(VirtualPlane::new(number.to_string(), normal, offset, PlanePoint::Tool, 10.0).unwrap())
    };
    (0..count).map(plane).collect()
}

#[test]
fn a_tool_stays_inside_512_planes_and_more_planes_are_refused() {
    let robot = sawyer();
    let push = task(&[Axis::X, Axis::Y, Axis::Z], force(&[Axis::X, Axis::Y, Axis::Z], &[100.0, 60.0, 30.0]));
    let with = |count| ControllerConfig {
        constraints: planes_around_the_tool(count),
        limits: Limits::Robot(LimitKind::PositionVelocity),
        ..config(&robot, vec![push.clone()])
    };
    let controller = controller(with(MAX_CONSTRAINT_ROWS));
    let (mut arm, mut active) = (Loop::at_rest(&NOMINAL), 0);
    let first = arm.configuration(&robot).tool_pose().translation.vector;
    for _ in 0..1000 {
        let answer = arm.step(&controller, [0.0; 6]).resolution;
        assert!(answer.broken_bounds.is_empty() && answer.solver.status == Status::Optimal, "{answer:?}");
        active += usize::from(answer.active_constraints().next().is_some());
    }
    let moved = (arm.configuration(&robot).tool_pose().translation.vector - first).norm();
    assert!((0.025..0.034).contains(&moved) && active > 500, "{moved} m, {active} periods");
    let given = MAX_CONSTRAINT_ROWS + 1;
    assert_eq!(Controller::new(with(given)).unwrap_err(), ConfigError::ConstraintRows { given });
}

#[test]
fn a_wall_has_no_effect_if_no_joint_moves_its_point() {
    let robot = sawyer();
    let wall = VirtualPlane::new("base", [1.0, 0.0, 0.0], -1.0, PlanePoint::Joint(0), 10.0).unwrap();
    let controller = controller(ControllerConfig {
        constraints: vec![Constraint::Plane(wall)],
        ..config(&robot, vec![task(&[Axis::X], force(&[Axis::X], &[30.0]))])
    });
    let answer = Loop::at_rest(&NOMINAL).step(&controller, [0.0; 6]).resolution;
    assert!(answer.broken_constraints().next().is_none() && answer.tasks[0].residual_norm < 1e-12, "{answer:?}");
}

#[test]
fn a_fixed_inequality_couples_joints_and_its_active_set_is_reused() {
    let robot = sawyer();
    let mut coefficients = vec![0.0; 7];
    (coefficients[1], coefficients[3]) = (1.0, 1.0);
    let coupling = Inequality::new("coupling", coefficients, 0.0).unwrap();
    let tasks = vec![task(&[Axis::Z], force(&[Axis::Z], &[50.0])), task(&[Axis::X], impedance(&[Axis::X], 500.0))];
    let config = ControllerConfig { constraints: vec![Constraint::Fixed(coupling.clone())], ..config(&robot, tasks) };
    let (auto, qp) = (controller(config.clone()), controller(ControllerConfig { solver: Solver::Qp, ..config }));
    let (mut arm, mut other) = (Loop::at_rest(&NOMINAL), Loop::at_rest(&NOMINAL));
    let mut reused = 0;
    for _ in 0..300 {
        let command = arm.step(&auto, [0.0; 6]);
        let by_qp = other.step(&qp, [0.0; 6]);
        let difference = (&command.resolution.joint_velocity - &by_qp.resolution.joint_velocity).amax();
        assert!(difference <= 1e-9, "off by {difference:e}");
        assert!(coupling.violation(&command.resolution.joint_velocity) <= 1e-12);
        let active = command.resolution.active_constraints().next().is_some();
        reused += usize::from(active && command.resolution.solver.working_sets == 1);
    }
    assert!(reused > 100, "only {reused} periods with one working set");
}

#[test]
fn a_scaled_push_keeps_its_direction_at_the_limits() {
    let robot = sawyer();
    let axes = [Axis::X, Axis::Y, Axis::Z];
    let direction = Vector::from_vec(vec![300.0, 200.0, -100.0]);
    let push = task(&axes, force(&axes, direction.as_slice()));
    let with_scaling = |scaled: bool| {
        let push = TaskConfig { scaled, ..push.clone() };
        let slow = VelocityBox::new(&[-0.3; 7], &[0.3; 7]).unwrap();
        // Damping near a singularity may turn the push.
        let damping = Some(Damping::STANDARD);
        controller(ControllerConfig { limits: Limits::Fixed(slow), damping, ..config(&robot, vec![push]) })
    };
    let deviation = |scaled: bool| {
        let (controller, mut arm, mut worst) = (with_scaling(scaled), Loop::at_rest(&NOMINAL), 0.0_f64);
        for _ in 0..150 {
            let command = arm.step(&controller, [0.0; 6]);
            let achieved = &command.resolution.tasks[0].achieved;
            worst = worst.max(1.0 - direction.dot(achieved) / (direction.norm() * achieved.norm()));
        }
        worst
    };
    assert!(deviation(true) <= 1e-8, "direction changed by {}", deviation(true));
    assert!(deviation(false) > 1e-3, "the limits must matter");
}

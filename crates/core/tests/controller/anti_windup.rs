//! Integrators while limits restrict the arm, and after the limits are released.

use std::sync::Arc;

use revprio_core::controller::{AntiWindup, Command, Controller, ControllerConfig, Limits, TaskConfig};
use revprio_core::law::{ForceLaw, Law, Point, Profile};
use revprio_core::limits::{LimitKind, VelocityBox};
use revprio_core::linalg::Damping;
use revprio_core::resolution::{BoundId, Method, Solver};
use revprio_robot::kinematics::Axis;
use revprio_robot::{JointLimits, RobotModel};

use super::arms::{Loop, NOMINAL, PERIOD, config, controller, force, gains, gantry, impedance, sawyer, task};

/// F_d / M_d T: maximum change of a velocity in one period, m/s.
const ONE_PERIOD: f64 = PERIOD * 30.0 / 15.0;

fn inside(robot: &Arc<RobotModel>, tasks: Vec<TaskConfig>, lower: &[f64], upper: &[f64]) -> ControllerConfig {
    let limits = Limits::Fixed(VelocityBox::new(lower, upper).unwrap());
    ControllerConfig { limits, ..config(robot, tasks) }
}

/// Returns the same controller with narrow and without limits. Each accepts the memory of the other.
fn limited_and_free(speed: f64, method: Method, solver: Solver) -> (Controller, Controller) {
    let rest = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task(&[Axis::X], force(&[Axis::X], &[30.0])), task(&rest, force(&rest, &[0.0; 5]))];
    let limited = inside(&sawyer(), tasks.clone(), &[-speed; 7], &[speed; 7]);
    let free = config(&sawyer(), tasks);
    (
        controller(ControllerConfig { method, solver, ..limited }),
        controller(ControllerConfig { method, solver, ..free }),
    )
}

/// Pushes in free space for half a second while limits restrict the arm. Returns the value that the integrator would
/// have without anti-windup.
fn push_at_limits(limited: &Controller, arm: &mut Loop) -> f64 {
    let mut without_reset = 0.0;
    for _ in 0..500 {
        without_reset += PERIOD / 15.0 * (30.0 - 150.0 * arm.twist(&sawyer())[0]);
        let command = arm.step(limited, [0.0; 6]);
        assert!(command.resolution.broken_limits().next().is_none());
    }
    without_reset
}

#[test]
fn the_command_does_not_jump_when_limits_are_released() {
    for method in [Method::ReversePriority, Method::StrictReversePriority, Method::DampedLeastSquares] {
        for solver in [Solver::Auto, Solver::Qp] {
            let (limited, free) = limited_and_free(0.01, method, solver);
            let mut arm = Loop::at_rest(&NOMINAL);
            let without_reset = push_at_limits(&limited, &mut arm);
            let held = arm.twist(&sawyer())[0];
            assert!(held < 0.02, "{method:?}: the limits must hold: {held} m/s");

            let mut wound_up = arm.clone();
            let released = arm.step(&free, [0.0; 6]).resolution.tasks[0].achieved[0];
            // The posture moved for one period since the integrator was set, hence the factor 1.001.
            assert!((released - held).abs() < 1.001 * ONE_PERIOD, "{method:?}: {held} jumps to {released} m/s");

            let memory = wound_up.memory.as_mut().unwrap();
            memory.task_velocities[0][0] = without_reset;
            let jumped = wound_up.step(&free, [0.0; 6]).resolution.tasks[0].achieved[0];
            assert!(jumped - held > 100.0 * ONE_PERIOD, "{method:?}: only {held} to {jumped} m/s");
        }
    }
}

#[test]
fn limits_do_not_wind_up_lower_tasks() {
    let (limited, free) = limited_and_free(0.01, Method::ReversePriority, Solver::Auto);
    let mut arm = Loop::at_rest(&NOMINAL);
    push_at_limits(&limited, &mut arm);
    for _ in 0..50 {
        let before = arm.twist(&sawyer());
        let after = arm.step(&free, [0.0; 6]);
        for (row, velocity) in after.resolution.tasks[1].achieved.iter().enumerate() {
            // There is no force on these axes. They move only by the rest of the motion that the limits allowed.
            let change = (velocity - before[row + 1]).abs();
            assert!(change < 0.1 * ONE_PERIOD, "row {row}: {change}");
        }
    }
}

/// A force of ±30 N root mean square that changes its sign at 2 s.
fn alternating_force() -> Law {
    let profile = Profile::sine(vec![0.0], vec![30.0 * 2.0_f64.sqrt()], std::f64::consts::FRAC_PI_2, 0.0).unwrap();
    Law::Force(ForceLaw::new(gains(&[Axis::X], 0.0), profile).unwrap())
}

#[test]
fn a_joint_leaves_its_position_limit_in_the_period_in_which_the_force_changes_sign() {
    let robot =
        gantry(JointLimits { lower: -0.05, upper: 0.05, velocity: 1.0, acceleration: 10.0, ..JointLimits::NONE });
    for kind in [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration] {
        let limited = ControllerConfig {
            limits: Limits::Robot(kind),
            ..config(&robot, vec![task(&[Axis::X], alternating_force())])
        };
        let controller = controller(limited);
        let mut arm = Loop::at_rest(&[0.0; 3]);
        // sin(π t / 2) changes its sign at 2 s.
        (0..2000).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
        assert!((arm.q[0] - 0.05).abs() < 1e-6, "{kind:?}: not at the limit: {}", arm.q[0]);
        let integrator = arm.memory.as_ref().unwrap().task_velocities[0][0];
        assert!(integrator.abs() < 1e-3, "{kind:?}: wound up to {integrator} m/s");
        // sin(π) is a rounding error, so a few more periods are needed.
        (0..3).for_each(|_| drop(arm.step(&controller, [0.0; 6])));
        assert!(arm.memory.as_ref().unwrap().last_command[0] < 0.0, "{kind:?}");
    }
}

#[test]
fn a_fixed_joint_does_not_wind_up_tasks_of_any_priority() {
    let robot = gantry(JointLimits::NONE);
    let push = |axis| task(&[axis], force(&[axis], &[30.0]));
    for tasks in [vec![push(Axis::X), push(Axis::Y)], vec![push(Axis::Y), push(Axis::X)]] {
        for method in [Method::ReversePriority, Method::StrictReversePriority, Method::DampedLeastSquares] {
            for solver in [Solver::Auto, Solver::Qp] {
                let fixed = inside(&robot, tasks.clone(), &[0.0, -1.0, -1.0], &[0.0, 1.0, 1.0]);
                let controller = controller(ControllerConfig { method, solver, ..fixed });
                let mut arm = Loop::at_rest(&[0.0; 3]);
                let mut active = Vec::new();
                for _ in 0..1000 {
                    active = arm.step(&controller, [0.0; 6]).resolution.active_bounds;
                }
                let place = tasks.iter().position(|task| task.name == "X").unwrap();
                let integrator = arm.memory.as_ref().unwrap().task_velocities[place][0];
                let context = format!("{method:?}, {solver:?}, x is task {}", place + 1);
                assert!(integrator.abs() < 1e-9, "{context}: wound up to {integrator} m/s");
                assert!(active.iter().any(|active| active.bound.id == BoundId::Joint(0)), "{context}: {active:?}");
            }
        }
    }
}

/// 0.01 rad from a singular posture of Sawyer whose weak direction is mostly x.
const SINGULAR: [f64; 7] = [0.531, 1.877, 0.803, -0.661, 0.717, -2.326, -0.263];
const OTHERS: [Axis; 5] = [Axis::Y, Axis::Z, Axis::Rx, Axis::Ry, Axis::Rz];

/// Returns a push along x above a spring on the other axes, with the damping of the paper. The push changes its sign at
/// `change` (s).
fn reversed_push(change: f64, limits: LimitKind, anti_windup: AntiWindup) -> ControllerConfig {
    let point = |time_s: f64, force: f64| Point { time_s, value: vec![force] };
    let push = Profile::steps(vec![point(0.0, 30.0), point(change, -30.0)]).unwrap();
    let push = Law::Force(ForceLaw::new(gains(&[Axis::X], 0.0), push).unwrap());
    let tasks = vec![task(&[Axis::X], push), task(&OTHERS, impedance(&OTHERS, 1000.0))];
    let damping = Some(Damping::STANDARD);
    ControllerConfig { limits: Limits::Robot(limits), anti_windup, damping, ..config(&sawyer(), tasks) }
}

/// Largest values over a run next to a singularity.
#[derive(Debug, Default)]
struct Extremes {
    /// Request of a row of the lower task, m/s and rad/s.
    request: f64,
    /// Change of a joint velocity within one period, rad/s.
    change: f64,
    /// Excess of such a change over A T, rad/s.
    excess: f64,
    /// Difference of an integrator and the achieved velocity, m/s and rad/s.
    windup: f64,
}

/// Runs from the singular posture; the arm follows exactly.
fn run_near_singularity(config: ControllerConfig, periods: usize) -> Extremes {
    let controller = controller(config);
    let mut stepper = crate::solvers::stepper(controller);
    let (robot, mut arm, mut found) = (sawyer(), Loop::at_rest(&SINGULAR), Extremes::default());
    let mut before: Option<Command> = None;
    for _ in 0..periods {
        let measurement = arm.measurement(PERIOD, [0.0; 6]);
        let command = stepper.step(&mut arm.memory, &measurement).unwrap().clone();
        arm.follow(&command, PERIOD);
        let memory = arm.memory.as_ref().unwrap();
        for (outcome, integrator) in command.resolution.tasks.iter().zip(&memory.task_velocities) {
            found.windup = found.windup.max((&outcome.achieved - integrator).amax());
        }
        found.request = found.request.max(command.targets[1].velocity.amax());
        if let Some(before) = &before {
            let change = &command.resolution.joint_velocity - &before.resolution.joint_velocity;
            found.change = found.change.max(change.amax());
            for (change, joint) in change.iter().zip(robot.joints()) {
                found.excess = found.excess.max(change.abs() - joint.limits.acceleration * PERIOD);
            }
        }
        before = Some(command);
    }
    found
}

#[test]
fn next_to_a_singularity_a_damped_task_winds_up_only_if_damping_is_excepted() {
    let run = |anti_windup, change| {
        let config = reversed_push(change, LimitKind::PositionVelocity, anti_windup);
        run_near_singularity(ControllerConfig { method: Method::ReversePriority, ..config }, 5000)
    };
    // The published laws: 1.8 rad/s in one period after the change of sign at 1 s, and requests of 13 rad/s and more after
    // 3 s.
    let [early, late] = [1.0, 3.0].map(|change| run(AntiWindup::ExceptDamping, change));
    assert!(early.change > 1.5 && late.request > 13.0 && early.windup > 5.0, "{early:?} {late:?}");
    let [early, late] = [1.0, 3.0].map(|change| run(AntiWindup::Always, change));
    assert!(early.change < 0.2 && early.request < 2.0, "{early:?}");
    assert!(late.request < 5.0, "{late:?}");
    assert!(early.windup < 1e-8 && late.windup < 1e-8, "{early:?} {late:?}");
}

#[test]
fn next_to_a_singularity_no_integrator_winds_up_with_any_method_and_solver() {
    let methods = [
        Method::Pseudoinverse,
        Method::DampedLeastSquares,
        Method::TaskPriority,
        Method::SingularityRobust,
        Method::ReversePriority,
        Method::StrictReversePriority,
    ];
    for method in methods {
        for solver in [Solver::Auto, Solver::Qp, Solver::ClosedForm] {
            for limits in [LimitKind::PositionVelocity, LimitKind::PositionVelocityAcceleration] {
                let config = reversed_push(1.0, limits, AntiWindup::Always);
                let found = run_near_singularity(ControllerConfig { method, solver, ..config }, 1500);
                let context = format!("{method:?}, {solver:?}, {limits:?}: {found:?}");
                assert!(found.windup < 1e-8, "{context}");
                // Lower tasks take over again within the acceleration limits.
                let accelerates = limits.includes_acceleration() && solver != Solver::ClosedForm;
                assert!(!accelerates || found.excess < 1e-9, "{context}");
            }
        }
    }
}

#[test]
fn no_law_requests_more_than_the_joints_can_give() {
    for method in [Method::ReversePriority, Method::DampedLeastSquares] {
        for (law, start) in [(force(&OTHERS, &[1e6; 5]), NOMINAL), (impedance(&OTHERS, 1e6), SINGULAR)] {
            let tasks = vec![task(&[Axis::X], force(&[Axis::X], &[-1e5])), task(&OTHERS, law)];
            let limits = Limits::Robot(LimitKind::PositionVelocity);
            let controller = controller(ControllerConfig { method, limits, ..config(&sawyer(), tasks) });
            let (robot, mut arm, mut bounded) = (sawyer(), Loop::at_rest(&start), false);
            for _ in 0..300 {
                let configuration = arm.configuration(&robot);
                let reach = |axis: &Axis| -> f64 {
                    let row = configuration.jacobian().row(axis.index()).into_owned();
                    row.iter().zip(robot.joints()).map(|(a, joint)| a.abs() * joint.limits.velocity).sum()
                };
                let reaches: Vec<f64> = [Axis::X].iter().chain(&OTHERS).map(reach).collect();
                let command = arm.step(&controller, [0.0; 6]);
                let requests = command.targets.iter().flat_map(|target| target.velocity.iter().copied());
                for (request, reach) in requests.zip(&reaches) {
                    assert!(request.abs() <= reach * (1.0 + 1e-12), "{method:?}: {request} beyond {reach}");
                    bounded |= request.abs() > 0.999 * reach;
                }
            }
            assert!(bounded, "the bound must be reached");
        }
    }
}

//! Numbers at the end of their range: bounds that mean "none", rows of rounding, squares that overflow.

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{
    ActiveSet, Bound, BoundId, Method, Problem, Resolution, Resolver, Solver, Status, resolve,
};
use revprio_core::task::{Task, TaskStack};

use crate::solvers::resolve_with;

fn equation(row: &[f64], velocity: f64) -> Task {
    Task::new("", Matrix::from_row_slice(1, row.len(), row), Vector::from_element(1, velocity))
}

fn between(row: &[f64], lower: f64, upper: f64) -> Task {
    let bound = |bound| Vector::from_element(1, bound);
    Task::between("", Matrix::from_row_slice(1, row.len(), row), bound(lower), bound(upper))
}

fn within(size: f64, method: Method, tasks: Vec<Task>) -> Problem {
    let tasks = TaskStack::new(tasks).unwrap();
    let bounds = vec![size; tasks.joint_count()];
    let lower: Vec<f64> = bounds.iter().map(|bound| -bound).collect();
    Problem { limits: VelocityBox::new(&lower, &bounds).unwrap(), method, ..Problem::new(tasks) }
}

fn assert_velocity(problem: &Problem, expected: &[f64]) {
    assert_velocity_by(Solver::Auto, problem, expected);
    assert_velocity_by(Solver::Qp, problem, expected);
}

fn assert_velocity_by(solver: Solver, problem: &Problem, expected: &[f64]) {
    let answer = resolve_with(solver, problem, &[]).unwrap();
    let error = (&answer.joint_velocity - Vector::from_row_slice(expected)).amax();
    let found = answer.joint_velocity.as_slice();
    assert!(error <= 1e-9, "{solver:?}: {found:?} instead of {expected:?}, {answer:?}");
    assert_eq!(answer.solver.status, Status::Optimal, "{solver:?}");
}

/// The program of a level is too badly scaled for Clarabel, and `qp` says so.
fn assert_velocity_that_qp_is_not_sure_of(problem: &Problem, expected: &[f64]) {
    assert_velocity_by(Solver::Auto, problem, expected);
    let answer = resolve_with(Solver::Qp, problem, &[]).unwrap();
    assert_eq!(answer.solver.status, Status::NotCertified);
    assert!(problem.limits.allows(answer.joint_velocity.as_slice()), "{answer:?}");
}

/// Two equations whose answer within ±1 rad/s is (0, 1): the first one is met, the second one gives way.
fn two_equations() -> Vec<Task> {
    vec![equation(&[1.0, 2.0], 2.0), equation(&[-1.0, 1.0], 2.0)]
}

#[test]
fn a_bound_that_means_none_does_not_loosen_the_limits() {
    for size in [1e9, 1e14, 1e15, 1e300] {
        let mut tasks = two_equations();
        tasks.push(between(&[1.0, 0.0], -size, size));
        assert_velocity(&within(1.0, Method::StrictReversePriority, tasks), &[0.0, 1.0]);
        let mut problem = within(1.0, Method::StrictReversePriority, two_equations());
        problem.inequalities = vec![Inequality::new("far", vec![1.0, 0.0], size).unwrap()];
        assert_velocity(&problem, &[0.0, 1.0]);
    }
}

#[test]
fn a_row_of_rounding_does_not_loosen_the_limits() {
    let tasks =
        vec![equation(&[0.0, 0.0, 1.2246e-16], 0.5), equation(&[1.0, 2.0, 0.0], 2.0), equation(&[-1.0, 1.0, 0.0], 2.0)];
    assert_velocity_that_qp_is_not_sure_of(&within(1.0, Method::StrictReversePriority, tasks), &[0.0, 1.0, 1.0]);
}

#[test]
fn a_scaled_stack_keeps_inequality_tasks() {
    let scaled = Task { scaled: true, ..equation(&[1.0, 0.0], 2.0) };
    for lower in [f64::NEG_INFINITY, -5.0] {
        let tasks = vec![scaled.clone(), between(&[0.0, 1.0], lower, -0.5)];
        let problem = within(1.0, Method::Pseudoinverse, tasks);
        assert_velocity(&problem, &[1.0, -0.5]);
        let answer = resolve(&problem, &[]).unwrap();
        assert!((answer.tasks[0].scale.unwrap() - 0.5).abs() < 1e-9, "{:?}", answer.tasks[0].scale);
    }
}

#[test]
fn lower_inequality_tasks_correct_the_start_of_reverse_priority_in_every_solver() {
    for velocity in [-2.0, -1.000_001, -0.999_999, 0.5] {
        let tasks = vec![equation(&[1.0, 1.0], velocity), between(&[1.0, 0.0], f64::NEG_INFINITY, 0.0)];
        let mut problem = within(9.0, Method::ReversePriority, tasks);
        problem.null_space_velocity = Some(Vector::from_vec(vec![1.0, 0.0]));
        let answer = |solver| resolve_with(solver, &problem, &[]).unwrap().joint_velocity;
        assert!((answer(Solver::Auto) - answer(Solver::Qp)).amax() < 1e-9, "{velocity}");
    }
}

#[test]
fn numbers_whose_squares_overflow_are_never_called_optimal() {
    for huge in [1e155, 1e200, 1e300] {
        let jacobian = within(1.0, Method::StrictReversePriority, vec![equation(&[huge, huge], 1.0)]);
        let target = within(1.0, Method::StrictReversePriority, vec![equation(&[1.0, 2.0], huge)]);
        for mut problem in [jacobian, target] {
            for damping in [None, Some(Damping::STANDARD)] {
                problem.damping = damping;
                for solver in [Solver::Auto, Solver::Qp] {
                    let answer = resolve_with(solver, &problem, &[]).unwrap();
                    assert!(answer.joint_velocity.iter().all(|v| v.abs() <= 1.0), "{solver:?}: {answer:?}");
                    let exact = answer.tasks[0].residual_norm.is_finite();
                    assert!(answer.solver.status != Status::Optimal || exact, "{solver:?}, {huge:e}: {answer:?}");
                }
            }
        }
    }
}

/// Rounding of huge targets is larger than the limits: the answer is moved to them, and what it achieves is computed there.
#[test]
fn achieved_velocities_are_those_of_the_answer() {
    let both = Task::new("both", Matrix::identity(2, 2), Vector::from_row_slice(&[1e13, 1.5]));
    let first_held: Vec<ActiveSet> = vec![[Bound::upper(BoundId::Joint(0))].into_iter().collect()];
    for (task, guess) in [(equation(&[1.0, 2.0], 1e200), &[][..]), (both.clone(), &[]), (both, &first_held)] {
        let problem = within(1.0, Method::StrictReversePriority, vec![task]);
        let answer = resolve(&problem, guess).unwrap();
        let achieved = &problem.tasks.tasks()[0].jacobian * &answer.joint_velocity;
        assert!((&answer.tasks[0].achieved - &achieved).amax() < 1e-12, "{answer:?}");
    }
}

/// On what the limit of joint 1 leaves, row 1 is short but not rounding, and row 2 is rounding. Squared lengths that are kept by
/// subtraction say the opposite.
#[test]
fn a_short_row_is_not_mistaken_for_rounding() {
    let rows = Matrix::from_row_slice(2, 2, &[1.0, 8e-9, 0.0, 1.2e-16]);
    let task = Task::new("both", rows, Vector::from_row_slice(&[2.0, 0.0]));
    let mut problem = within(1.0, Method::StrictReversePriority, vec![task]);
    problem.limits = VelocityBox::new(&[-0.5, -1.0], &[0.5, 1.0]).unwrap();
    assert_velocity_that_qp_is_not_sure_of(&problem, &[0.5, 1.0]);
}

#[test]
fn a_resolver_that_solved_other_problems_reports_the_same_singularities() {
    let bounded = within(1.0, Method::StrictReversePriority, vec![between(&[100.0, 0.0], -1.0, 1.0)]);
    let (mut resolver, mut first, mut second) = (Resolver::default(), Resolution::default(), Resolution::default());
    resolver.resolve(&within(1.0, Method::StrictReversePriority, two_equations()), &[], &mut first).unwrap();
    resolver.resolve(&bounded, &[], &mut first).unwrap();
    resolver.resolve(&bounded, &[], &mut second).unwrap();
    assert_eq!(first.singularity, second.singularity);
    assert_eq!(first.singularity, resolve(&bounded, &[]).unwrap().singularity);
}

#[test]
fn a_target_whose_square_overflows_gives_no_false_certificate() {
    let jacobian = Matrix::from_row_slice(3, 2, &[1.0, 0.0, 0.0, 1.0, 0.0, 2.0]);
    let task = Task::new("", jacobian, Vector::from_vec(vec![1e200, 1.0, 3.0]));
    let limits = VelocityBox::new(&[0.0, -10.0], &[0.0, 10.0]).unwrap();
    let problem = Problem { limits, ..Problem::new(TaskStack::new(vec![task]).unwrap()) };
    let answer = resolve(&problem, &[]).unwrap();
    // Least squares of q̇_2 = 1 and 2 q̇_2 = 3.
    let is_right = (answer.joint_velocity[1] - 1.4).abs() < 1e-9;
    assert!(is_right || answer.solver.status != Status::Optimal, "{answer:?}");
}

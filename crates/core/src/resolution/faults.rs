//! What a failing solver does to the answer: nothing that moves the arm unasked.

use super::qp_cascade::fault::{self, Fault, SolverStatus};
use super::{Method, Problem, Resolution, Solver, Status, resolve};
use crate::limits::VelocityBox;
use crate::linalg::{Matrix, Vector};
use crate::task::{Task, TaskStack};

const FAILURES: [SolverStatus; 7] = [
    SolverStatus::Unsolved,
    SolverStatus::PrimalInfeasible,
    SolverStatus::DualInfeasible,
    SolverStatus::MaxIterations,
    SolverStatus::MaxTime,
    SolverStatus::NumericalError,
    SolverStatus::InsufficientProgress,
];

/// A problem whose closed form breaks limits, so that the solver is needed.
fn limited(method: Method, solver: Solver) -> Problem {
    let push = Task::new("push", Matrix::from_row_slice(1, 3, &[1.0, 2.0, -0.5]), Vector::from_element(1, 4.0));
    let hold = Task::new("hold", Matrix::from_row_slice(1, 3, &[0.3, -1.0, 1.0]), Vector::from_element(1, 0.5));
    let limits = VelocityBox::new(&[-1.0, 0.2, -0.4], &[1.0, 0.9, 0.4]).unwrap();
    Problem { limits, method, solver, ..Problem::new(TaskStack::new(vec![push, hold]).unwrap()) }
}

fn problems() -> impl Iterator<Item = Problem> {
    let methods = [Method::ReversePriority, Method::StrictReversePriority, Method::DampedLeastSquares];
    methods.into_iter().flat_map(|method| [limited(method, Solver::Qp), limited(method, Solver::Auto)])
}

fn faulty(problem: &Problem, status: SolverStatus, entry: f64, search: bool) -> Resolution {
    fault::with(Fault { status, entry, search }, || resolve(problem, &[]).unwrap())
}

fn assert_safe(problem: &Problem, answer: &Resolution) {
    assert!(answer.joint_velocity.iter().all(|v| v.is_finite()), "{answer:?}");
    assert_eq!(problem.limits.violation(&answer.joint_velocity), 0.0, "{answer:?}");
}

#[test]
fn a_failed_solve_is_counted_and_an_exact_search_stands_in() {
    for problem in problems() {
        let sound = resolve(&problem, &[]).unwrap();
        assert!(sound.solver.failures == 0 && sound.solver.status == Status::Optimal);
        for (status, entry) in FAILURES.into_iter().flat_map(|status| [(status, f64::NAN), (status, 1e152)]) {
            let answer = faulty(&problem, status, entry, false);
            assert_safe(&problem, &answer);
            assert!(answer.solver.failures > 0, "{status:?}");
            assert_eq!(answer.solver.status, Status::Optimal, "{status:?}: {answer:?}");
            assert!((&answer.joint_velocity - &sound.joint_velocity).amax() <= 1e-12, "{status:?}: {answer:?}");
        }
    }
}

#[test]
fn where_the_search_fails_too_the_command_is_safe_and_says_so() {
    for problem in problems() {
        for (status, entry) in FAILURES.into_iter().flat_map(|status| [(status, f64::NAN), (status, 1e152)]) {
            let answer = faulty(&problem, status, entry, true);
            assert_safe(&problem, &answer);
            assert_eq!(answer.solver.status, Status::NotCertified, "{status:?}: {answer:?}");
        }
    }
}

#[test]
fn garbage_that_claims_to_be_solved_is_not_believed() {
    for problem in problems() {
        let sound = resolve(&problem, &[]).unwrap();
        for entry in [f64::NAN, f64::INFINITY, 1e152, -3.0] {
            let answer = faulty(&problem, SolverStatus::Solved, entry, false);
            assert_safe(&problem, &answer);
            assert!((&answer.joint_velocity - &sound.joint_velocity).amax() <= 1e-12, "{entry}: {answer:?}");
        }
    }
}

//! The printed formulas and damped targets where rows are short, weak, or beyond the numbers, and their certificate.

use revprio_core::linalg::{Damping, Matrix, Vector};
use revprio_core::resolution::{Method, Problem, Solver, Status};

use crate::solvers::resolve_with;
use crate::{N, problem};

/// The second row is below the tolerance for ranks, so that its velocity is missing, which the certificate states: σ_2 ẋ_2
/// relative to ‖J‖ (‖J‖ · speeds + ‖ẋ‖).
#[test]
fn the_certificate_of_the_closed_form_is_relative_to_the_sizes_of_its_task() {
    let sigma = 1e-10;
    let rows = Matrix::from_fn(2, N, |i, j| match (i, j) {
        (0, 0) => 2.0,
        (1, 1) => sigma,
        _ => 0.0,
    });
    let weak = (rows, Vector::from_row_slice(&[1.0, 1.0]));
    let upper = (Matrix::from_fn(1, N, |_, j| f64::from(u8::from(j == 2))), Vector::from_row_slice(&[0.7]));
    for lambda in [0.0, 0.3] {
        let residual = |method: Method, solver: Solver, tasks: &[(Matrix, Vector)]| {
            let problem = Problem {
                method,
                damping: (lambda > 0.0).then(|| Damping::new(0.5, lambda).unwrap()),
                null_space_velocity: Some(Vector::from_row_slice(&[0.0, 0.0, 0.0, 3.0, 0.0])),
                ..problem(tasks)
            };
            resolve_with(solver, &problem, &[]).unwrap().solver.kkt_residual.unwrap()
        };
        let expected = |lambda: f64, speeds: f64| sigma / ((2.0 + lambda) * ((2.0 + lambda) * speeds + 2.0_f64.sqrt()));
        let moved = |lambda: f64| 2.0 / (4.0 + lambda * lambda);
        let (own, damped) = (std::slice::from_ref(&weak), moved(lambda));
        let below = [upper.clone(), weak.clone()];
        for (method, tasks, expected) in [
            (Method::Pseudoinverse, own, expected(0.0, 0.5_f64.hypot(3.0) + 3.0)),
            (Method::DampedLeastSquares, own, expected(lambda, damped.hypot(3.0) + 3.0)),
            (Method::TaskPriority, own, expected(lambda, 2.0 * damped)),
            (Method::StrictReversePriority, &below[..], expected(lambda, damped.hypot(0.7) + damped)),
            (Method::SingularityRobust, own, expected(lambda, damped.hypot(3.0) + damped)),
            (Method::ReversePriority, own, expected(lambda, 3.0 + 2.0 * damped)),
        ] {
            // Damping gives the strict hierarchy its targets by the same steps.
            let is_strict = matches!(method, Method::TaskPriority | Method::StrictReversePriority) && lambda > 0.0;
            for solver in [Solver::ClosedForm, Solver::Auto].into_iter().take(1 + usize::from(is_strict)) {
                let found = residual(method, solver, tasks);
                assert!(
                    (found / expected - 1.0).abs() < 1e-4,
                    "{method:?}, {solver:?}, {lambda}: {found:e} {expected:e}"
                );
            }
        }
    }
}

/// The lower task is too small next to the upper one to be seen. Half of what the upper one does disturbs it.
#[test]
fn the_certificate_of_reverse_priority_compares_the_lower_tasks_with_their_own_size() {
    let row = |a: f64, b: f64, target: f64| {
        (Matrix::from_row_slice(1, N, &[a, b, 0.0, 0.0, 0.0]), Vector::from_row_slice(&[target]))
    };
    let tasks = [row(1.0, 1.0, 1.0), row(0.0, 1e-13, 0.0)];
    let problem = Problem { method: Method::ReversePriority, ..problem(&tasks) };
    let answer = resolve_with(Solver::ClosedForm, &problem, &[]).unwrap();
    // (s²/4) / (s² · 2 ‖(½, ½)‖)
    assert!((answer.solver.kkt_residual.unwrap() - 0.125 * 2.0_f64.sqrt()).abs() < 1e-9, "{:?}", answer.solver);
    assert_eq!(answer.solver.status, Status::NotCertified);
}

/// The size of the gradient, ‖J‖² ‖q̇‖, is beyond the numbers. A gradient of zero needs no size.
#[test]
fn the_closed_form_is_not_certified_beyond_the_numbers() {
    let solved = |row: [f64; N], target: f64| {
        let tasks = [(Matrix::from_row_slice(1, N, &row), Vector::from_row_slice(&[target]))];
        let problem = Problem { method: Method::Pseudoinverse, ..problem(&tasks) };
        resolve_with(Solver::ClosedForm, &problem, &[]).unwrap().solver
    };
    let unit = 2.0_f64.powi(510);
    let inexact = solved([0.31, 0.73, -0.97, 0.13, 0.57].map(|entry| entry * unit), 11.3 * unit);
    assert_eq!((inexact.kkt_residual, inexact.status), (None, Status::NotCertified));
    let exact = solved([unit, 0.0, 0.0, 0.0, 0.0], 16.0 * unit);
    assert_eq!((exact.kkt_residual, exact.status), (Some(0.0), Status::Optimal));
}

/// A stage of the closed form does not depend on the length of the rows of its task, which may be much shorter than those of
/// the lower tasks, also where these determine all joints.
#[test]
fn the_closed_form_keeps_the_digits_of_short_rows() {
    let rows = |count: usize, seed: f64, unit: f64| {
        Matrix::from_fn(count, N, |i, j| unit * (seed + (2 * i * i + 3 * i) as f64 + 1.7 * (j * (i + 1)) as f64).sin())
    };
    let targets = |count: usize, unit: f64| Vector::from_fn(count, |i, _| unit * (0.4 - 0.3 * i as f64));
    for (unit, below) in [(1e-6, 1.0), (1e-8, 1.0), (1e-6, 1e4), (1e-3, 1e3)] {
        for count in [2, N] {
            let tasks = [(rows(2, 0.3, unit), targets(2, unit)), (rows(count, 1.1, below), targets(count, below))];
            let solve = |solver| resolve_with(solver, &problem(&tasks), &[]).unwrap().joint_velocity;
            let (closed, exact) = (solve(Solver::ClosedForm), solve(Solver::Auto));
            let error = (&closed - &exact).amax() / exact.norm();
            assert!(error < 1e-10, "{unit}, {below}, {count}: {error:e}");
        }
    }
}

/// Directions that a nearly dependent upper task leaves free are known up to 10⁻⁸ only. The damped targets of the strict
/// hierarchy follow the same rule; a copy of the upper task, which is singular below it, calls for them.
#[test]
fn the_rounding_of_a_projector_is_not_followed() {
    let rows = |entries: &[f64], unit: f64| Matrix::from_row_slice(entries.len() / N, N, entries) * unit;
    let speed = |angle: f64, open: f64, units: [f64; 2], solver: Solver| {
        let upper = (rows(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, angle, 0.0, 0.0, 0.0], units[0]), Vector::zeros(2));
        let lower = (rows(&[0.0, 1.0, open, 0.0, 0.0], units[1]), Vector::from_row_slice(&units[1..]));
        let problem = Problem {
            method: Method::TaskPriority,
            damping: (solver == Solver::Auto).then(|| Damping::new(1e-15, 1e-15).unwrap()),
            ..problem(&[upper.clone(), lower, upper])
        };
        resolve_with(solver, &problem, &[]).unwrap().joint_velocity[2] * open
    };
    for (angle, open, expected) in
        [(1e-6, 6e-9, 0.0), (1e-6, 1e-8, 1.0), (1.0, 0.8e-10, 0.0), (1.0, 1.3e-10, 1.0), (1.0, 6e-9, 1.0)]
    {
        for units in [[1.0, 1.0], [1e-3, 1.0], [1.0, 1e-3]] {
            for solver in [Solver::ClosedForm, Solver::Auto] {
                let found = speed(angle, open, units, solver);
                assert!((found - expected).abs() < 1e-3, "{angle} {open} {units:?} {solver:?}: {found}");
            }
        }
    }
}

/// The weak directions of an upper task are left to the lower one, whatever the unit of its rows is: one of two, both, or that of
/// a single row.
#[test]
fn weak_directions_of_a_task_are_left_to_lower_tasks_as_the_formulas_say() {
    let along = |sizes: &[f64]| Matrix::from_fn(sizes.len(), N, |i, j| if i == j { sizes[i] } else { 0.0 });
    let lower = (along(&[1.0, 1.0]), Vector::from_row_slice(&[1.0, 1.0]));
    for sizes in [&[1e-3, 1e-8][..], &[1.0, 1e-5], &[1e3, 1e-2], &[0.1, 0.02], &[0.04]] {
        let tasks = [(along(sizes), Vector::zeros(sizes.len())), lower.clone()];
        for method in [Method::ReversePriority, Method::StrictReversePriority] {
            let damping = Some(Damping::new(0.5, 0.3).unwrap());
            let solve = |solver| resolve_with(solver, &Problem { method, damping, ..problem(&tasks) }, &[]).unwrap();
            let (closed, exact) = (solve(Solver::ClosedForm), solve(Solver::Auto));
            let error = (&closed.joint_velocity - &exact.joint_velocity).amax();
            assert!(error < 1e-6, "{sizes:?} {method:?}: {} {}", closed.joint_velocity, exact.joint_velocity);
        }
    }
}

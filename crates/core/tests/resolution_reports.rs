//! Every method with and without damping against the solver, what answers report, and what is refused.

use proptest::prelude::*;
use revprio_core::limits::{Inequality, VelocityBox};
use revprio_core::linalg::{Damping, Matrix, Svd, Vector, stack};
use revprio_core::resolution::{
    MAX_UNKNOWNS, Method, Path, Problem, ProblemError, Resolution, Resolver, Side, Solver, Status, resolve,
};
use revprio_core::task::{Task, TaskStack};

const N: usize = 5;

const METHODS: [Method; 6] = [
    Method::Pseudoinverse,
    Method::DampedLeastSquares,
    Method::TaskPriority,
    Method::StrictReversePriority,
    Method::SingularityRobust,
    Method::ReversePriority,
];

fn entries(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-1.0..1.0_f64, count)
}

/// One to three rows. Some are short or nearly depend on each other, so that damping acts on the task itself.
fn task() -> impl Strategy<Value = (Matrix, Vector)> {
    let size = prop::sample::select(vec![1.0, 1.0, 0.2, 0.01]);
    (1..4_usize, entries(3 * N), entries(3), size, any::<bool>()).prop_map(|(m, rows, targets, size, is_near)| {
        let mut rows = Matrix::from_row_slice(m, N, &rows[..m * N]);
        if m > 1 {
            let near = if is_near { rows.row(0) + rows.row(m - 1) * size } else { rows.row(m - 1) * size };
            rows.set_row(m - 1, &near);
        }
        (rows, Vector::from_row_slice(&targets[..m]))
    })
}

fn problem(tasks: &[(Matrix, Vector)]) -> Problem {
    let task = |(rows, target): &(Matrix, Vector)| Task::new("task", rows.clone(), target.clone());
    Problem::new(TaskStack::new(tasks.iter().map(task).collect()).unwrap())
}

fn limits(lower: [f64; N], upper: [f64; N]) -> VelocityBox {
    VelocityBox::new(&lower, &upper).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// The factors of damping differ from method to method and from task to task.
    #[test]
    fn closed_forms_and_solvers_agree_without_limits(
        tasks in prop::collection::vec(task(), 1..4), reference in entries(N), rests in any::<bool>(),
        is_damped in any::<bool>(),
    ) {
        for method in METHODS {
            let problem = |solver| Problem {
                method,
                solver,
                damping: is_damped.then(|| Damping::new(0.5, 0.3).unwrap()),
                null_space_velocity: (!rests).then(|| Vector::from_row_slice(&reference)),
                ..problem(&tasks)
            };
            let closed = resolve(&problem(Solver::ClosedForm), &[]).unwrap();
            prop_assert_eq!(closed.solver.path, Path::ClosedForm);
            let is_optimal = closed.solver.status == Status::Optimal;
            prop_assert_eq!(closed.solver.kkt_residual.unwrap() <= 1e-9, is_optimal);
            prop_assert!(is_optimal || closed.solver.rank_uncertain, "{method:?} {:?}", closed.solver);
            for solver in [Solver::Auto, Solver::Qp] {
                let answer = resolve(&problem(solver), &[]).unwrap();
                prop_assert_eq!(answer.solver.status, Status::Optimal);
                prop_assert_eq!(answer.solver.rank_uncertain, closed.solver.rank_uncertain);
                let speed = closed.joint_velocity.norm().max(1.0);
                let error = (&answer.joint_velocity - &closed.joint_velocity).amax() / speed;
                prop_assert!(error < 1e-7 || closed.solver.rank_uncertain, "{method:?} {solver:?} {error:e}");
                let size = closed.singularity.smallest_singular_value().max(1e-3);
                let difference = answer.singularity.smallest_singular_value() - closed.singularity.smallest_singular_value();
                prop_assert!(difference.abs() < 1e-9 * size.max(1.0) && answer.singularity.algorithmic == closed.singularity.algorithmic);
            }
        }
    }

    /// Of each task alone, and of it together with the lower ones. Inequality tasks have a rank and do not count otherwise.
    #[test]
    fn ranks_and_singularities_are_those_of_singular_values(
        mut tasks in prop::collection::vec(task(), 1..4), copied in any::<bool>(), inequality in task(), is_damped in any::<bool>(),
    ) {
        if copied {
            let row = tasks[0].0.row(0).into_owned();
            tasks.last_mut().unwrap().0.set_row(0, &(2.0 * row));
        }
        let mut stated: Vec<Task> =
            tasks.iter().map(|(rows, target)| Task::new("task", rows.clone(), target.clone())).collect();
        let bounds = Vector::repeat(inequality.0.nrows(), 1.0);
        stated.push(Task::between("bounds", inequality.0.clone(), -1.0 * &bounds, bounds));
        let damping = is_damped.then(|| Damping::new(0.5, 0.3).unwrap());
        let answer = resolve(&Problem { damping, ..Problem::new(TaskStack::new(stated).unwrap()) }, &[]).unwrap();
        let sigma = |rows: &Matrix| Svd::new(rows).singular_values().to_vec();
        let rank = |rows: &Matrix| sigma(rows).iter().filter(|sigma| **sigma > 1e-10 * rows.norm()).count();
        let (mut lower, mut any) = (Matrix::zeros(0, N), false);
        for (k, (rows, _)) in tasks.iter().enumerate().rev() {
            let all = stack(rows, &lower);
            let is_algorithmic = rank(rows) + rank(&lower) > rank(&all);
            prop_assert_eq!((answer.tasks[k].rank, answer.tasks[k].algorithmic), (rank(rows), is_algorithmic));
            any |= is_algorithmic;
            lower = all;
        }
        prop_assert_eq!((answer.singularity.algorithmic, answer.tasks[tasks.len()].rank), (any, rank(&inequality.0)));
        let product: f64 = sigma(&lower).iter().product();
        let smallest = sigma(&lower)[lower.nrows().min(N) - 1];
        prop_assert!((answer.singularity.manipulability - product).abs() < 1e-10 * lower.norm().powi(5).max(1.0));
        prop_assert!((answer.singularity.smallest_singular_value() - smallest).abs() < 1e-12 * lower.norm());
    }

    /// An answer that is overwritten keeps nothing of the one before.
    #[test]
    fn an_answer_that_is_used_again_is_that_of_a_new_one(
        stacks in prop::collection::vec(prop::collection::vec(task(), 1..4), 2..5), width in 0.05..2.0_f64,
    ) {
        let (mut resolver, mut answer) = (Resolver::default(), Resolution::default());
        for (index, tasks) in stacks.iter().enumerate() {
            let mut upper = [width; N];
            if index % 2 == 1 {
                upper[0] = -width;
            }
            let problem = Problem {
                limits: if index == 2 { VelocityBox::unbounded(N) } else { limits([-width; N], upper) },
                method: METHODS[index],
                damping: (index == 1).then_some(Damping::STANDARD),
                solver: [Solver::Auto, Solver::Qp, Solver::Auto, Solver::ClosedForm][index],
                ..problem(tasks)
            };
            resolver.resolve(&problem, &[], &mut answer).unwrap();
            prop_assert_eq!(&answer, &resolve(&problem, &[]).unwrap());
        }
    }
}

/// Two tasks of one row each on two joints: everything about the answer is known.
#[test]
fn an_answer_reports_what_it_does() {
    let row = |a: f64, b: f64, target: f64| {
        (Matrix::from_row_slice(1, N, &[a, b, 0.0, 0.0, 0.0]), Vector::from_row_slice(&[target]))
    };
    let tasks = [row(1.0, 0.0, 1.0), row(0.0, 2.0, 1.0)];
    let free = resolve(&problem(&tasks), &[]).unwrap();
    assert_eq!((free.solver.path, free.solver.working_sets), (Path::ClosedForm, 1));
    assert_eq!((free.tasks[0].rank, free.tasks[1].rank, free.singularity.manipulability), (1, 1, 2.0));
    assert!(free.active_limits.is_empty() && free.violated_limits.is_empty());
    let narrow = limits([-3.0, -3.0, 0.5, -3.0, -3.0], [0.75, 3.0, 0.5, 3.0, 3.0]);
    let limited = resolve(&Problem { limits: narrow.clone(), ..problem(&tasks) }, &[]).unwrap();
    assert_eq!(limited.solver.path, Path::ActiveSet);
    let active: Vec<_> = limited.active_limits.iter().map(|it| (it.joint, it.value)).collect();
    assert_eq!((active, limited.active_limits[0].side), (vec![(0, 0.75), (2, 0.5)], Side::Upper));
    assert!((limited.tasks[0].residual_norm - 0.25).abs() < 1e-12 && limited.tasks[1].residual_norm < 1e-12);
    // The empty set and the proposal of the search; one set more for each lower stage.
    let stages = Problem { limits: narrow.clone(), method: Method::SingularityRobust, ..problem(&tasks) };
    let stages = resolve(&stages, &[]).unwrap();
    assert_eq!((limited.solver.working_sets, stages.solver.working_sets), (2, 3));
    let closed = Problem { limits: narrow, solver: Solver::ClosedForm, ..problem(&tasks) };
    let closed = resolve(&closed, &[]).unwrap();
    let broken: Vec<_> = closed.violated_limits.iter().map(|it| (it.joint, it.side, it.limit)).collect();
    assert_eq!(broken, [(0, Side::Upper, 0.75), (2, Side::Lower, 0.5)]);
    let dependent = resolve(&problem(&[row(1.0, 0.0, 1.0), row(2.0, 0.0, 1.0)]), &[]).unwrap();
    assert_eq!((dependent.tasks[0].rank, dependent.tasks[1].rank), (1, 1));
    assert!(dependent.tasks[0].algorithmic && !dependent.tasks[1].algorithmic && dependent.singularity.algorithmic);
    assert_eq!(dependent.solver.path, Path::ClosedForm);
    let still = Problem { limits: limits([-3.0, -3.0, -3.0, -3.0, 0.0], [3.0, 3.0, 3.0, 3.0, 0.0]), ..problem(&tasks) };
    let still = resolve(&still, &[]).unwrap();
    let pinned: Vec<_> = still.active_limits.iter().map(|it| (it.joint, it.side, it.value, it.multiplier)).collect();
    assert_eq!((still.solver.path, pinned), (Path::ClosedForm, vec![(4, Side::Upper, 0.0, 0.0)]));
    assert_ne!(free.singularity, resolve(&problem(&tasks[..1]), &[]).unwrap().singularity);
    let bounds = Vector::from_row_slice(&[1.0]);
    let inequality = Task::between("bounds", tasks[0].0.clone(), -1.0 * &bounds, bounds);
    let open = resolve(&Problem::new(TaskStack::new(vec![inequality]).unwrap()), &[]).unwrap();
    assert_eq!((open.singularity.manipulability, open.singularity.smallest_singular_value()), (0.0, 0.0));
}

#[test]
fn problems_whose_parts_differ_in_size_are_refused() {
    let tasks = [(Matrix::from_row_slice(1, N, &[1.0; N]), Vector::from_row_slice(&[1.0]))];
    let refusal = |problem: Problem| resolve(&problem, &[]).unwrap_err();
    let limits = Problem { limits: VelocityBox::unbounded(4), ..problem(&tasks) };
    assert_eq!(refusal(limits), ProblemError::Limits { expected: N, given: 4 });
    let short = Inequality::new("short", vec![1.0; 4], 1.0).unwrap();
    let fits = Inequality::new("fits", vec![1.0; N], 1.0).unwrap();
    let inequalities = Problem { inequalities: vec![fits, short], ..problem(&tasks) };
    let expected = ProblemError::Inequality { name: "short".to_owned(), index: 1, expected: N, given: 4 };
    assert_eq!(refusal(inequalities), expected);
    for zeta in [vec![0.0; 4], vec![f64::NAN; N]] {
        let zeta = Problem { null_space_velocity: Some(Vector::from_vec(zeta)), ..problem(&tasks) };
        assert_eq!(refusal(zeta), ProblemError::NullSpaceVelocity { expected: N });
    }
    let wide = |joints: usize, scaled: bool| {
        let task = Task::new("wide", Matrix::from_fn(1, joints, |_, _| 1.0), Vector::from_row_slice(&[1.0]));
        Problem::new(TaskStack::new(vec![Task { scaled, ..task }]).unwrap())
    };
    assert!(resolve(&wide(MAX_UNKNOWNS, false), &[]).is_ok());
    let limit = MAX_UNKNOWNS;
    assert_eq!(refusal(wide(limit, true)), ProblemError::Size { given: limit + 1, limit });
    assert_eq!(refusal(wide(limit + 1, false)), ProblemError::Size { given: limit + 1, limit });
}

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
                solver,
                damping: (lambda > 0.0).then(|| Damping::new(0.5, lambda).unwrap()),
                null_space_velocity: Some(Vector::from_row_slice(&[0.0, 0.0, 0.0, 3.0, 0.0])),
                ..problem(tasks)
            };
            resolve(&problem, &[]).unwrap().solver.kkt_residual.unwrap()
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
    let problem = Problem { solver: Solver::ClosedForm, method: Method::ReversePriority, ..problem(&tasks) };
    let answer = resolve(&problem, &[]).unwrap();
    // (s²/4) / (s² · 2 ‖(½, ½)‖)
    assert!((answer.solver.kkt_residual.unwrap() - 0.125 * 2.0_f64.sqrt()).abs() < 1e-9, "{:?}", answer.solver);
    assert_eq!(answer.solver.status, Status::NotCertified);
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
            solver,
            method: Method::TaskPriority,
            damping: (solver == Solver::Auto).then(|| Damping::new(1e-15, 1e-15).unwrap()),
            ..problem(&[upper.clone(), lower, upper])
        };
        resolve(&problem, &[]).unwrap().joint_velocity[2] * open
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

/// Two rows at a small angle: in one task its rank changes at the tolerance, in two tasks their singularity together.
#[test]
fn ranks_of_tasks_change_at_the_tolerance() {
    let rows = |entries: &[[f64; 2]], unit: f64| {
        let rows = Matrix::from_fn(entries.len(), N, |i, j| entries[i].get(j).map_or(0.0, |entry| unit * entry));
        (rows, Vector::zeros(entries.len()))
    };
    for unit in [1.0, 1e3, 1e-3] {
        for (angle, rank) in [(1.7e-10, 1), (2.3e-10, 2)] {
            let (a, b) = ([1.0, 0.0], [1.0, angle]);
            let one = resolve(&problem(&[rows(&[a, b], unit)]), &[]).unwrap();
            assert_eq!(one.tasks[0].rank, rank, "{angle}, {unit}");
            let two = resolve(&problem(&[rows(&[a], unit), rows(&[b], unit)]), &[]).unwrap();
            assert_eq!(
                (two.tasks[0].algorithmic, two.singularity.algorithmic),
                (rank == 1, rank == 1),
                "{angle}, {unit}"
            );
        }
    }
}

/// A stage of the closed form does not depend on the length of the rows of its task, which may be much shorter than those of
/// the lower tasks.
#[test]
fn the_closed_form_keeps_the_digits_of_short_rows() {
    let rows =
        |seed: f64, unit: f64| Matrix::from_fn(2, N, |i, j| unit * (seed + 3.0 * i as f64 + 1.7 * j as f64).sin());
    for (unit, below) in [(1e-6, 1.0), (1e-6, 1e3), (1e-3, 1e3)] {
        let tasks = [
            (rows(0.3, unit), Vector::from_row_slice(&[0.4 * unit, -0.7 * unit])),
            (rows(1.1, below), Vector::from_row_slice(&[0.9 * below, 0.2 * below])),
        ];
        let solve = |solver| resolve(&Problem { solver, ..problem(&tasks) }, &[]).unwrap().joint_velocity;
        let (closed, exact) = (solve(Solver::ClosedForm), solve(Solver::Auto));
        assert!((&closed - &exact).amax() < 1e-7 * exact.norm(), "{unit}, {below}: {closed} {exact}");
    }
}

/// The size of the gradient, ‖J‖² ‖q̇‖, is beyond the numbers. A gradient of zero needs no size.
#[test]
fn the_closed_form_is_not_certified_beyond_the_numbers() {
    let solved = |row: [f64; N], target: f64| {
        let tasks = [(Matrix::from_row_slice(1, N, &row), Vector::from_row_slice(&[target]))];
        let problem = Problem { solver: Solver::ClosedForm, method: Method::Pseudoinverse, ..problem(&tasks) };
        resolve(&problem, &[]).unwrap().solver
    };
    let unit = 2.0_f64.powi(510);
    let inexact = solved([0.31, 0.73, -0.97, 0.13, 0.57].map(|entry| entry * unit), 11.3 * unit);
    assert_eq!((inexact.kkt_residual, inexact.status), (None, Status::NotCertified));
    let exact = solved([unit, 0.0, 0.0, 0.0, 0.0], 16.0 * unit);
    assert_eq!((exact.kkt_residual, exact.status), (Some(0.0), Status::Optimal));
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
            let solve = |solver| resolve(&Problem { solver, method, damping, ..problem(&tasks) }, &[]).unwrap();
            let (closed, exact) = (solve(Solver::ClosedForm), solve(Solver::Auto));
            let error = (&closed.joint_velocity - &exact.joint_velocity).amax();
            assert!(error < 1e-6, "{sizes:?} {method:?}: {} {}", closed.joint_velocity, exact.joint_velocity);
        }
    }
}

/// −0 counts as 0: reflections take their sign from the first entry of a row, which decides the last bits.
#[test]
fn a_negative_zero_gives_the_bits_of_zero() {
    let bits = |zero: f64| {
        let first = Matrix::from_row_slice(2, N, &[zero, 0.7, -0.3, 0.9, 0.1, zero, 0.2, 0.8, -0.6, 0.4]);
        let second = Matrix::from_row_slice(1, N, &[zero, 0.5, 0.3, 0.2, -0.7]);
        let tasks = [(first, Vector::from_row_slice(&[0.31, -0.17])), (second, Vector::from_row_slice(&[0.53]))];
        let answer = resolve(&problem(&tasks), &[]).unwrap().joint_velocity;
        answer.iter().map(|entry| (entry + 0.0).to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(-0.0), bits(0.0));
}

/// The rows of the task are independent. A joint that stands still leaves them with an angle of 10⁻⁸. Also, rows at this angle
/// may have a certain rank only at the limits, which does not make the rank of the task certain.
#[test]
fn a_rank_is_uncertain_with_and_without_limits() {
    let rows = Matrix::from_row_slice(2, N, &[1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1e-8, 0.0, -1.0, 0.0]);
    let tasks = [(rows, Vector::from_row_slice(&[0.5, 0.5 + 1e-8]))];
    for (speed, expected) in [(3.0, false), (0.0, true)] {
        let limits = limits([-3.0, -3.0, -3.0, -speed, -3.0], [3.0, 3.0, 3.0, speed, 3.0]);
        let answer = resolve(&Problem { limits, ..problem(&tasks) }, &[]).unwrap();
        assert_eq!((answer.solver.status, answer.solver.rank_uncertain), (Status::Optimal, expected));
    }
    let rows = Matrix::from_row_slice(2, N, &[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1e-8, 0.0, 0.0, 0.0]);
    let tasks = [(rows, Vector::from_row_slice(&[0.5, 0.7]))];
    for solver in [Solver::Auto, Solver::ClosedForm] {
        let limits = limits([-3.0; N], [3.0; N]);
        assert!(
            resolve(&Problem { limits, solver, ..problem(&tasks) }, &[]).unwrap().solver.rank_uncertain,
            "{solver:?}"
        );
    }
}

/// Each bound has the multiplier of the first level that it holds back: what the task misses there, or the distance from the
/// reference.
#[test]
fn active_bounds_are_listed_with_their_sides_and_multipliers() {
    let rows = |count: usize| Matrix::from_fn(count, N, |i, j| f64::from(u8::from(i == j)));
    let vector = Vector::from_row_slice;
    let inequality = Task::between("bounds", rows(2), vector(&[-1.0, 0.3]), vector(&[0.2, 1.0]));
    let goal = Task::new("goal", rows(3), vector(&[1.0, 0.0, 1.0]));
    let stack = TaskStack::new(vec![inequality, goal]).unwrap();
    let limits = limits([-3.0, -3.0, -3.0, 0.0, 0.1], [3.0, 3.0, 0.4, 0.0, 3.0]);
    for solver in [Solver::Auto, Solver::Qp] {
        let problem = Problem {
            limits: limits.clone(),
            method: Method::StrictReversePriority,
            solver,
            ..Problem::new(stack.clone())
        };
        let answer = resolve(&problem, &[]).unwrap();
        assert!((&answer.joint_velocity - vector(&[0.2, 0.3, 0.4, 0.0, 0.1])).amax() < 1e-12, "{answer:?}");
        assert!(answer.solver.kkt_residual.unwrap() < 1e-12 && answer.violated_limits.is_empty());
        let rows: Vec<_> = answer.tasks[0].active_rows.iter().map(|it| (it.row, it.side)).collect();
        assert_eq!((rows, answer.tasks[1].active_rows.len()), (vec![(0, Side::Upper), (1, Side::Lower)], 0));
        let joints: Vec<_> = answer.active_limits.iter().map(|it| (it.joint, it.side)).collect();
        assert_eq!(joints, [(2, Side::Upper), (3, Side::Upper), (4, Side::Lower)]);
        let of_rows = answer.tasks[0].active_rows.iter().map(|it| it.multiplier);
        let multipliers: Vec<f64> = of_rows.chain(answer.active_limits.iter().map(|it| it.multiplier)).collect();
        let error = (Vector::from_vec(multipliers) - vector(&[0.8, 0.3, 0.6, 0.0, 0.1])).amax();
        assert!(error < 1e-12, "{answer:?}");
    }
}

//! What answers report, and which problems are refused.

use revprio_core::constraint::Inequality;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{
    Bound, BoundId, MAX_UNKNOWNS, Method, Path, Problem, ProblemError, Side, Solver, Status, resolve,
};
use revprio_core::task::{Task, TaskStack};

use crate::solvers::resolve_with;
use crate::{N, limits, problem};

/// Two tasks of one row each on two joints: everything about the answer is known.
#[test]
fn an_answer_reports_what_it_does() {
    let row = |a: f64, b: f64, target: f64| {
        (Matrix::from_row_slice(1, N, &[a, b, 0.0, 0.0, 0.0]), Vector::from_row_slice(&[target]))
    };
    let tasks = [row(1.0, 0.0, 1.0), row(0.0, 2.0, 1.0)];
    let free = resolve(&problem(&tasks), &[]).unwrap();
    assert_eq!((free.solver.path, free.solver.working_sets), (Path::ClosedForm, 1));
    assert_eq!((free.tasks[0].rank, free.tasks[1].rank, free.singularity.manipulability()), (1, 1, 2.0));
    assert!(free.active_limits().next().is_none() && free.broken_limits().next().is_none());
    let narrow = limits([-3.0, -3.0, 0.5, -3.0, -3.0], [0.75, 3.0, 0.5, 3.0, 3.0]);
    let limited = resolve(&Problem { limits: narrow.clone(), ..problem(&tasks) }, &[]).unwrap();
    assert_eq!(limited.solver.path, Path::ActiveSet);
    let active: Vec<_> = limited.active_limits().map(|(joint, it)| (joint, it.value)).collect();
    assert_eq!((active, limited.active_bounds[0].bound.side), (vec![(0, 0.75), (2, 0.5)], Side::Upper));
    assert!((limited.tasks[0].residual_norm - 0.25).abs() < 1e-12 && limited.tasks[1].residual_norm < 1e-12);
    // The empty set and the proposal of the search; one set more for each lower stage.
    let stages = Problem { limits: narrow.clone(), method: Method::SingularityRobust, ..problem(&tasks) };
    let stages = resolve(&stages, &[]).unwrap();
    assert_eq!((limited.solver.working_sets, stages.solver.working_sets), (2, 3));
    let again = Problem { limits: narrow.clone(), ..problem(&tasks) };
    assert_eq!(resolve(&again, &limited.active_set).unwrap().solver.working_sets, 1);
    let closed = Problem { limits: narrow, ..problem(&tasks) };
    let closed = resolve_with(Solver::ClosedForm, &closed, &[]).unwrap();
    let broken: Vec<_> = closed.broken_limits().map(|(joint, it)| (joint, it.bound.side, it.limit)).collect();
    assert_eq!(broken, [(0, Side::Upper, 0.75), (2, Side::Lower, 0.5)]);
    let dependent = resolve(&problem(&[row(1.0, 0.0, 1.0), row(2.0, 0.0, 1.0)]), &[]).unwrap();
    assert_eq!((dependent.tasks[0].rank, dependent.tasks[1].rank), (1, 1));
    assert!(dependent.tasks[0].algorithmic && !dependent.tasks[1].algorithmic && dependent.singularity.algorithmic);
    assert_eq!(dependent.solver.path, Path::ClosedForm);
    let still = Problem { limits: limits([-3.0, -3.0, -3.0, -3.0, 0.0], [3.0, 3.0, 3.0, 3.0, 0.0]), ..problem(&tasks) };
    let still = resolve(&still, &[]).unwrap();
    let pinned: Vec<_> =
        still.active_limits().map(|(joint, it)| (joint, it.bound.side, it.value, it.multiplier)).collect();
    assert_eq!((still.solver.path, pinned), (Path::ClosedForm, vec![(4, Side::Upper, 0.0, 0.0)]));
    assert_ne!(free.singularity, resolve(&problem(&tasks[..1]), &[]).unwrap().singularity);
    let bounds = Vector::from_row_slice(&[1.0]);
    let inequality = Task::between("bounds", tasks[0].0.clone(), -1.0 * &bounds, bounds);
    let open = resolve(&Problem::new(TaskStack::new(vec![inequality]).unwrap()), &[]).unwrap();
    assert_eq!((open.singularity.manipulability(), open.singularity.smallest_singular_value()), (0.0, 0.0));
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
        let problem =
            Problem { limits: limits.clone(), method: Method::StrictReversePriority, ..Problem::new(stack.clone()) };
        let answer = resolve_with(solver, &problem, &[]).unwrap();
        assert!((&answer.joint_velocity - vector(&[0.2, 0.3, 0.4, 0.0, 0.1])).amax() < 1e-12, "{answer:?}");
        assert!(answer.solver.kkt_residual.unwrap() < 1e-12 && answer.broken_limits().next().is_none());
        assert_eq!(answer.solver.iterations > 0, solver == Solver::Qp);
        let rows: Vec<_> = answer.active_rows(0).map(|(row, it)| (row, it.bound.side)).collect();
        assert_eq!((rows, answer.active_rows(1).count()), (vec![(0, Side::Upper), (1, Side::Lower)], 0));
        let joints: Vec<_> = answer.active_limits().map(|(joint, it)| (joint, it.bound.side)).collect();
        assert_eq!(joints, [(2, Side::Upper), (3, Side::Upper), (4, Side::Lower)]);
        let of_rows = answer.active_rows(0).map(|(_, it)| it.multiplier);
        let multipliers: Vec<f64> = of_rows.chain(answer.active_limits().map(|(_, it)| it.multiplier)).collect();
        let error = (Vector::from_vec(multipliers) - vector(&[0.8, 0.3, 0.6, 0.0, 0.1])).amax();
        assert!(error < 1e-12, "{answer:?}");
        let again = resolve(&problem, &answer.active_set).unwrap();
        assert_eq!((again.solver.working_sets, again.active_set), (1, answer.active_set));
    }
}

/// The velocity that meets the task without limits is 1 for joint 0. It breaks q̇_0 − 3 q̇_1 ≤ 0.5. The active set names
/// both bounds and is confirmed at once.
#[test]
fn an_inequality_is_kept_although_the_task_alone_breaks_it() {
    let along = |joint: usize| Matrix::from_fn(1, N, |_, j| f64::from(u8::from(j == joint)));
    let vector = Vector::from_row_slice;
    let inequality = |a: [f64; 2], b: f64| Inequality::new("", vec![a[0], a[1], 0.0, 0.0, 0.0], b).unwrap();
    let tasks = vec![
        Task::new("first", along(0), vector(&[1.0])),
        Task::between("bounds", along(2), vector(&[-1.0]), vector(&[0.2])),
        Task::new("goal", along(2), vector(&[1.0])),
    ];
    let problem = Problem {
        inequalities: vec![inequality([1.0, 0.0], 9.0), inequality([1.0, -3.0], 0.5)],
        method: Method::StrictReversePriority,
        ..Problem::new(TaskStack::new(tasks).unwrap())
    };
    let answer = resolve(&problem, &[]).unwrap();
    assert!((&answer.joint_velocity - vector(&[1.0, 0.5 / 3.0, 0.2, 0.0, 0.0])).amax() < 1e-12, "{answer:?}");
    let held = [BoundId::Constraint { index: 1, row: 0 }, BoundId::Task { index: 1, row: 0 }].map(Bound::upper);
    assert_eq!(answer.active_set[0][..], held);
    assert_eq!(resolve(&problem, &answer.active_set).unwrap().solver.working_sets, 1);
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
            resolve_with(solver, &Problem { limits, ..problem(&tasks) }, &[]).unwrap().solver.rank_uncertain,
            "{solver:?}"
        );
    }
}

/// −0 counts as 0: reflections take their sign from the first entry of a row, which decides the last bits.
#[test]
fn a_negative_zero_gives_the_bits_of_zero() {
    let bits = |seed: usize, zero: f64| {
        let entry = |i: usize, j: usize| ((1 + seed + 7 * i + 3 * j * j) as f64).sin();
        let rows = Matrix::from_fn(3, N, |i, j| if (i, j) == (0, 0) { zero } else { entry(i, j) });
        let tasks = [(rows, Vector::from_fn(3, |i, _| entry(i, N)))];
        let answer = resolve(&problem(&tasks), &[]).unwrap().joint_velocity;
        answer.iter().map(|entry| (entry + 0.0).to_bits()).collect::<Vec<_>>()
    };
    for seed in 0..100 {
        assert_eq!(bits(seed, -0.0), bits(seed, 0.0), "{seed}");
    }
}

/// Levels of inequalities need not be in the order of their names; active sets are, because a memory with another order is refused.
#[test]
fn active_sets_are_in_the_order_of_names() {
    let along = |joint: usize| (0..N).map(|j| f64::from(u8::from(j == joint))).collect::<Vec<_>>();
    let inequality = |joint: usize, level: u8| {
        let mut inequality = Inequality::new("", along(joint), 0.5).unwrap();
        inequality.set_level(level);
        inequality
    };
    let goal = Task::new("goal", Matrix::identity(N, N), Vector::from_element(N, 1.0));
    for solver in [Solver::Auto, Solver::Qp] {
        let inequalities = vec![inequality(0, u8::MAX), inequality(1, 1), inequality(2, 0)];
        let problem = Problem { inequalities, ..Problem::new(TaskStack::new(vec![goal.clone()]).unwrap()) };
        let answer = resolve_with(solver, &problem, &[]).unwrap();
        let names = [0, 1, 2].map(|index| Bound::upper(BoundId::Constraint { index, row: 0 }));
        assert_eq!(answer.active_set[0][..], names, "{solver:?}");
        assert_eq!(resolve(&problem, &answer.active_set).unwrap().solver.working_sets, 1);
    }
}

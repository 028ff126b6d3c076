//! Every method with and without damping against the solver, what answers report, and what is refused.

mod answers;
mod formulas;
#[path = "../solvers/mod.rs"]
mod solvers;

use proptest::prelude::*;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Damping, Matrix, Svd, Vector, stack};
use revprio_core::resolution::{Method, Path, Problem, Resolution, Solver, Status, resolve};
use revprio_core::task::{Task, TaskStack};
use solvers::resolve_with;

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

/// Returns whether a rank of some tasks may be doubtful to one solver only: their levels have other rows, norms and singular values.
fn is_near_the_threshold(tasks: &[(Matrix, Vector)]) -> bool {
    let (mut higher, mut lower, mut sigmas) = (Matrix::zeros(0, N), Matrix::zeros(0, N), Vec::new());
    for ((rows, _), (low, _)) in tasks.iter().zip(tasks.iter().rev()) {
        higher = stack(&higher, rows);
        lower = stack(low, &lower);
        sigmas.extend([rows, &higher, &lower].map(|rows| Svd::new(rows).singular_values().to_vec()).concat());
    }
    let least = tasks.iter().map(|(rows, _)| rows.norm()).fold(f64::INFINITY, f64::min);
    let largest = higher.norm();
    sigmas.iter().any(|sigma| (1e-7 * least..1e-5 * largest).contains(sigma))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// The factors of damping differ from method to method and from task to task.
    #[test]
    fn closed_forms_and_solvers_agree_without_limits(
        tasks in prop::collection::vec(task(), 1..4), reference in entries(N), rests in any::<bool>(),
        is_damped in any::<bool>(),
    ) {
        let is_doubtful = is_near_the_threshold(&tasks);
        for method in METHODS {
            let problem = Problem {
                method,
                damping: is_damped.then(|| Damping::new(0.5, 0.3).unwrap()),
                null_space_velocity: (!rests).then(|| Vector::from_row_slice(&reference)),
                ..problem(&tasks)
            };
            let closed = resolve_with(Solver::ClosedForm, &problem, &[]).unwrap();
            prop_assert_eq!(closed.solver.path, Path::ClosedForm);
            let is_optimal = closed.solver.status == Status::Optimal;
            prop_assert_eq!(closed.solver.kkt_residual.unwrap() <= 1e-11, is_optimal);
            let is_certain = closed.solver.kkt_residual.unwrap() <= 1e-9;
            prop_assert!(is_certain || closed.solver.rank_uncertain, "{method:?} {:?}", closed.solver);
            for solver in [Solver::Auto, Solver::Qp] {
                let answer = resolve_with(solver, &problem, &[]).unwrap();
                prop_assert_eq!(answer.solver.status, Status::Optimal, "{:?} {:?} {:?}", method, solver, answer.solver);
                let doubts = [answer.solver.rank_uncertain, closed.solver.rank_uncertain];
                prop_assert!(doubts[0] == doubts[1] || is_doubtful, "{doubts:?} {method:?} {solver:?}");
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
        prop_assert!((answer.singularity.manipulability() - product).abs() < 1e-10 * lower.norm().powi(5).max(1.0));
        prop_assert!((answer.singularity.smallest_singular_value() - smallest).abs() < 1e-12 * lower.norm());
    }

    /// An answer that is overwritten keeps nothing of the one before.
    #[test]
    fn an_answer_that_is_used_again_is_that_of_a_new_one(
        stacks in prop::collection::vec(prop::collection::vec(task(), 1..4), 2..5), width in 0.05..2.0_f64,
    ) {
        let mut solvers = [Solver::Auto, Solver::Qp, Solver::ClosedForm].map(solvers::solver);
        let mut answer = Resolution::default();
        for (index, tasks) in stacks.iter().enumerate() {
            let mut upper = [width; N];
            if index % 2 == 1 {
                upper[0] = -width;
            }
            let problem = Problem {
                limits: if index == 2 { VelocityBox::unbounded(N) } else { limits([-width; N], upper) },
                method: METHODS[index],
                damping: (index == 1).then_some(Damping::STANDARD),
                ..problem(tasks)
            };
            for (place, name) in [Solver::Auto, Solver::Qp, Solver::ClosedForm].into_iter().enumerate() {
                solvers[place].solve(&problem, &[], &mut answer).unwrap();
                prop_assert_eq!(&answer, &resolve_with(name, &problem, &[]).unwrap());
            }
        }
    }
}

//! What `Qp` must get from Clarabel: accurate answers of its own before the polish, the closed form inside limits, and
//! the priorities in their order.

use revprio_problem::{Matrix, Method, Problem, Resolution, Solve, Status, Task, TaskStack, Vector, VelocityBox};
use revprio_reference::{ClosedForm, Qp};

/// Largest relative residual of an ordinary level before the polish. Clarabel's tolerance is 1e-10.
const PRECISE: f64 = 1e-6;

fn solve(solver: &mut dyn Solve, problem: &Problem) -> Resolution {
    let mut answer = Resolution::default();
    solver.solve(problem, &[], &mut answer).unwrap();
    answer
}

/// Full rows without structure, the same for the same seed.
fn matrix(rows: usize, columns: usize, seed: usize) -> Matrix {
    Matrix::from_fn(rows, columns, |i, j| ((seed * 31 + 7 * i + 3 * j * j) as f64).sin())
}

/// Two tasks of three and two rows for seven joints with these limits (rad/s).
fn two_tasks(seed: usize, limit: f64, method: Method) -> Problem {
    let task = |name: &str, rows, offset| {
        let velocity = matrix(rows, 1, seed + offset).column(0).into_owned();
        Task::new(name, matrix(rows, 7, seed + offset + 1000), velocity)
    };
    let tasks = TaskStack::new(vec![task("first", 3, 0), task("second", 2, 500)]).unwrap();
    let limits = VelocityBox::new(&[-limit; 7], &[limit; 7]).unwrap();
    Problem { limits, method, ..Problem::new(tasks) }
}

const METHODS: [Method; 3] = [Method::ReversePriority, Method::StrictReversePriority, Method::TaskPriority];

#[test]
fn qp_equals_the_closed_form_inside_limits() {
    let mut qp = Qp::default();
    for seed in 0..50 {
        for method in METHODS {
            let problem = two_tasks(seed, 1e3, method);
            let (found, exact) = (solve(&mut qp, &problem), solve(&mut ClosedForm, &problem));
            let size = exact.joint_velocity.amax();
            let error = (&found.joint_velocity - &exact.joint_velocity).amax() / size;
            assert!(size > 1e-3 && error < 1e-9, "problem {seed}, {method:?}: off by {error:e}");
            assert_eq!(found.solver.status, Status::Optimal, "problem {seed}, {method:?}");
        }
    }
}

#[test]
fn clarabel_solves_each_open_level_accurately_before_the_polish() {
    let mut qp = Qp::default();
    for seed in 0..50 {
        for method in METHODS {
            for limit in [1e3, 0.5, 0.2] {
                let answer = solve(&mut qp, &two_tasks(seed, limit, method));
                let context = format!("problem {seed}, {method:?}, {limit} rad/s: {:?}", answer.levels);
                let open: Vec<_> = answer.levels.iter().filter(|level| level.iterations > 0).collect();
                // The first task is always open.
                assert!(answer.levels[0].iterations > 0 && !open.is_empty(), "{context}");
                // Clarabel ends at once only where its start is the answer.
                let is_idle = |residual: f64| residual <= 1e-12;
                assert!(
                    answer.levels.iter().all(|level| level.iterations > 0 || is_idle(level.clarabel_residual)),
                    "{context}"
                );
                assert!(open.iter().all(|level| level.clarabel_residual <= PRECISE), "{context}");
            }
        }
    }
}

/// Two joints up to 1 rad/s. The first task wants their sum to be 1.5 rad/s, the second one the first joint at −1 rad/s.
fn conflict(method: Method) -> Problem {
    let sum = Task::new("sum", Matrix::from_row_slice(1, 2, &[1.0, 1.0]), Vector::from_vec(vec![1.5]));
    let first = Task::new("first joint", Matrix::from_row_slice(1, 2, &[1.0, 0.0]), Vector::from_vec(vec![-1.0]));
    let limits = VelocityBox::new(&[-1.0; 2], &[1.0; 2]).unwrap();
    Problem { limits, method, ..Problem::new(TaskStack::new(vec![sum, first]).unwrap()) }
}

#[test]
fn limits_that_keep_both_tasks_apart_leave_the_first_one_exact() {
    for method in METHODS {
        let answer = solve(&mut Qp::default(), &conflict(method));
        // The sum needs (0.5, 1) at least. That is as near to −1 rad/s as the second task comes.
        let expected = Vector::from_vec(vec![0.5, 1.0]);
        let error = (&answer.joint_velocity - expected).amax();
        assert!(error < 1e-9, "{method:?}: {:?}", answer.joint_velocity.as_slice());
        assert_eq!(answer.solver.status, Status::Optimal);
        let residuals = answer.levels.iter().map(|level| level.clarabel_residual).fold(0.0, f64::max);
        assert!(residuals <= PRECISE, "{method:?}: {residuals:e} before the polish");
    }
}

#[test]
fn the_order_of_two_conflicting_tasks_decides_which_one_is_exact() {
    let row = [0.6, 0.8, 0.0];
    let task =
        |name: &str, velocity| Task::new(name, Matrix::from_row_slice(1, 3, &row), Vector::from_vec(vec![velocity]));
    for method in METHODS {
        for (first, second) in [(0.3, -0.7), (-0.7, 0.3)] {
            let limits = VelocityBox::new(&[-2.0; 3], &[2.0; 3]).unwrap();
            let tasks = TaskStack::new(vec![task("first", first), task("second", second)]).unwrap();
            let answer = solve(&mut Qp::default(), &Problem { limits, method, ..Problem::new(tasks) });
            let achieved = answer.tasks[0].achieved[0];
            assert!((achieved - first).abs() < 1e-9, "{method:?}: {achieved} instead of {first}");
            assert!((answer.tasks[1].residual_norm - 1.0).abs() < 1e-9, "{method:?}");
        }
    }
}

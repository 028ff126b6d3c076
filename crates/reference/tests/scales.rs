//! Numbers of very different size in one problem: bounds that mean none, tiny rows, demands that nothing can meet.

use revprio_problem::{
    Damping, Inequality, Matrix, Method, Problem, Resolution, Solve, Status, Task, TaskStack, Vector, VelocityBox,
};
use revprio_reference::Qp;

/// Returns a task with bounds for each row.
fn between(rows: &[&[f64]], lower: &[f64], upper: &[f64]) -> Task {
    let jacobian = Matrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    Task::between("", jacobian, Vector::from_row_slice(lower), Vector::from_row_slice(upper))
}

/// Returns a task of one equation.
fn equation(row: &[f64], velocity: f64) -> Task {
    Task::new("", Matrix::from_row_slice(1, row.len(), row), Vector::from_element(1, velocity))
}

fn problem(method: Method, tasks: Vec<Task>) -> Problem {
    Problem { method, ..Problem::new(TaskStack::new(tasks).unwrap()) }
}

fn assert_solved(problem: &Problem, expected: &[f64]) {
    let mut answer = Resolution::default();
    Qp::default().solve(problem, &[], &mut answer).unwrap();
    let error = (&answer.joint_velocity - Vector::from_row_slice(expected)).amax();
    let size = expected.iter().fold(0.0_f64, |size, x| size.max(x.abs()));
    assert!(error <= 1e-9 * size, "{:?} instead of {expected:?}", answer.joint_velocity.as_slice());
    assert_eq!(answer.solver.status, Status::Optimal);
}

const INF: f64 = f64::INFINITY;

#[test]
fn far_bounds_of_tasks_do_not_hide_near_ones() {
    for far in [1e6, 1e9, 1e15] {
        for near in [1e-6, 1e-3, 1.0] {
            let task = between(&[&[1.0]], &[-far], &[-near]);
            assert_solved(&problem(Method::ReversePriority, vec![task]), &[-near]);
        }
        let task = between(&[&[1.0], &[-1.0]], &[-far, 1.0], &[0.0, INF]);
        assert_solved(&problem(Method::ReversePriority, vec![task]), &[-1.0]);
        let task = between(&[&[0.0], &[0.0], &[1.0]], &[-INF, -far, -INF], &[-1.0, 0.0, 1.0]);
        assert_solved(&problem(Method::StrictReversePriority, vec![task]), &[0.0]);
    }
}

#[test]
fn far_limits_do_not_hide_tasks() {
    let task = between(&[&[-1.0, -1.0]], &[-INF], &[0.0]);
    for far in [1.0, 1e6, 1e9] {
        let limits = VelocityBox::new(&[-1.0, 0.0], &[0.0, far]).unwrap();
        let inequalities = vec![Inequality::new("away", vec![1.0, 0.0], -1e6).unwrap()];
        let problem = Problem { limits, inequalities, ..problem(Method::TaskPriority, vec![task.clone()]) };
        assert_solved(&problem, &[-1.0, 1.0]);
    }
}

#[test]
fn tiny_rows_are_met_and_do_not_hide_others() {
    let tasks = vec![equation(&[1.0, 0.0], 0.0), equation(&[0.0, 1.0], 1.0), equation(&[-1e-16, 0.0], 1.0)];
    assert_solved(&problem(Method::StrictReversePriority, tasks), &[0.0, 1.0]);
    for tiny in [1e-16, 1e-100] {
        let task = between(&[&[tiny]], &[-1.0], &[-3.0 * tiny]);
        assert_solved(&problem(Method::DampedLeastSquares, vec![task]), &[-3.0]);
    }
}

/// What a lower task asks for in vain must not move a joint across an inequality.
#[test]
fn large_demands_do_not_break_inequalities() {
    let inequality = Inequality::new("away", vec![1.0], -0.1).unwrap();
    let limits = VelocityBox::new(&[-1e9], &[0.0]).unwrap();
    let task = equation(&[-1e-5], -2.0);
    let inequalities = vec![inequality];
    let problem = Problem { limits, inequalities, ..problem(Method::StrictReversePriority, vec![task]) };
    assert_solved(&problem, &[-0.1]);
    let pinned = VelocityBox::new(&[-1.0, 0.0], &[1.0, 0.0]).unwrap();
    let demand = Some(Vector::from_vec(vec![0.0, -4e5]));
    let inequalities =
        vec![Inequality::new("a", vec![1.0, 0.0], -0.08).unwrap(), Inequality::new("b", vec![0.1, 1.0], 0.0).unwrap()];
    let rest = problem_of_rest();
    assert_solved(&Problem { limits: pinned, inequalities, null_space_velocity: demand, ..rest }, &[-0.08, 0.0]);
}

fn problem_of_rest() -> Problem {
    problem(Method::StrictReversePriority, vec![equation(&[0.0, 0.0], 0.0)])
}

/// A limit that means none is no reason to move: damped answers tend to the middle of the box.
#[test]
fn wide_limits_do_not_move_damped_joints() {
    for far in [1e3, 1e9] {
        let limits = VelocityBox::new(&[0.2, -far, 0.0], &[1.0; 3]).unwrap();
        let damping = Some(Damping::STANDARD);
        let task = equation(&[0.0, 1.0, 0.0], 0.0);
        let problem = Problem { limits, damping, ..problem(Method::ReversePriority, vec![task]) };
        let mut answer = Resolution::default();
        Qp::default().solve(&problem, &[], &mut answer).unwrap();
        assert!(answer.joint_velocity[1].abs() < 0.01, "{:?}", answer.joint_velocity.as_slice());
    }
}

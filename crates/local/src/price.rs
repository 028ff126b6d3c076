//! The price of a resolution, known before the work starts.
//!
//! Work up to a budget runs on the thread of the steps. Work above it goes to worker threads.
//!
//! One unit is about 0.25 µs in the worst case that a search found, on one core at 2 to 3 GHz: `tools/fuzz/examples/dearest.rs`
//! varies size, limits, conflicts, method and solver. Common problems cost a tenth of their price.

use revprio_core::constraint::Constraint;
use revprio_core::controller::ControllerConfig;
use revprio_core::resolution::{Problem, Solver};

/// Maximum price of a stateless problem on the thread of the steps: 18 rows in 3 tasks for 7 joints, or 1 ms in the worst
/// case.
pub const RESOLVE_BUDGET: usize = 4_000;

/// Maximum price of a step on the thread of the steps: 20 rows in 4 tasks and 2 inequalities for 7 joints, or 2 ms in the
/// worst case. Handing a step over costs more than most steps.
pub const STEP_BUDGET: usize = 8_000;

/// A bound or an inequality may enter and leave the working set. It costs as much as this number of equations.
const PER_BOUND: usize = 4;

/// Number of joints that even a smaller robot costs: with few joints, what each row costs by itself counts.
const LEAST_UNKNOWNS: usize = 7;

/// The solver `qp` costs as much as this number of `auto`.
const QP: usize = 8;

/// The same for `closed_form`: its decompositions have as many columns as a task has rows.
const CLOSED_FORM: usize = 2;

/// A controller that looks ahead costs as much as this number of others: it solves for postures at several times.
const LOOKS_AHEAD: usize = 2;

/// Returns the price of a problem.
pub fn of_problem(problem: &Problem, solver: Solver) -> usize {
    let tasks = problem.tasks.tasks().iter().map(|task| (task.lower.len(), task.lower != task.upper));
    of_solver(solver) * price(tasks, problem.inequalities.len(), problem.tasks.joint_count())
}

/// Returns the price of one step of a controller.
pub fn of_controller(config: &ControllerConfig) -> usize {
    let tasks = config.tasks.iter().map(|task| (task.rows.len(), task.law.bounds().is_some()));
    let constraints = config.constraints.iter().map(Constraint::row_count).sum();
    let of_distances = |constraint: &Constraint| {
        constraint.distances().map_or(0, |avoidance| avoidance.work(&config.robot, config.period_s))
    };
    let distances: usize = config.constraints.iter().map(of_distances).sum();
    let looks_ahead = if config.path().is_some() { LOOKS_AHEAD } else { 1 };
    looks_ahead * of_solver(config.solver) * price(tasks, constraints, config.robot.joint_count()) + distances
}

const fn of_solver(solver: Solver) -> usize {
    match solver {
        Solver::Qp => QP,
        Solver::ClosedForm => CLOSED_FORM,
        Solver::Auto => 1,
    }
}

/// Returns tasks × (equations + 4 × (bounds + inequalities) + n) × n², where n is the number of joints, at least 7. Each task gives its number of rows and
/// whether they are bounds. The sizes of a request are bounded, so the product does not overflow.
fn price(tasks: impl Iterator<Item = (usize, bool)>, inequalities: usize, joints: usize) -> usize {
    let (mut count, mut rows) = (0, 0);
    for (task_rows, are_bounds) in tasks {
        count += 1;
        rows += task_rows * if are_bounds { PER_BOUND } else { 1 };
    }
    let unknowns = joints.max(LEAST_UNKNOWNS);
    count * (rows + PER_BOUND * inequalities + unknowns) * unknowns * unknowns
}

#[cfg(test)]
mod tests {
    use revprio_core::constraint::Inequality;

    use super::*;

    /// A task of equations and one of bounds, next to an inequality.
    #[test]
    fn the_price_of_a_problem_counts_its_tasks_rows_and_inequalities() {
        use revprio_core::linalg::{Matrix, Vector};
        use revprio_core::task::{Task, TaskStack};

        let equations = Task::new("a", Matrix::from_fn(3, 5, |_, _| 1.0), Vector::zeros(3));
        let bounds = Task::between("b", Matrix::from_fn(2, 5, |_, _| 1.0), Vector::zeros(2), Vector::repeat(2, 1.0));
        let mut problem = Problem::new(TaskStack::new(vec![equations, bounds]).unwrap());
        problem.inequalities.push(Inequality::new("sum", vec![1.0; 5], 1.0).unwrap());
        assert_eq!(of_problem(&problem, Solver::Auto), 2 * (3 + 4 * (2 + 1) + 7) * 49);
        assert_eq!(of_problem(&problem, Solver::Qp), 8 * of_problem(&problem, Solver::Auto));
    }

    /// A law of two rows and bounds of one row, next to a constraint.
    #[test]
    fn the_price_of_a_controller_counts_its_tasks_rows_and_constraints() {
        use revprio_core::controller::TaskConfig;
        use revprio_core::law::{Law, Profile, VelocityBounds};
        use revprio_core::robot::kinematics::{Axis, AxisSelection};
        use revprio_core::rows::{TaskRows, ToolRows};

        let task = |axes: &[Axis], law: Law| TaskConfig {
            name: format!("{axes:?}"),
            rows: TaskRows::Tool(ToolRows::new(AxisSelection::new(axes).unwrap())),
            law,
            scaled: false,
            streaming: revprio_core::streaming::Streaming::default(),
        };
        let moves = task(&[Axis::X, Axis::Y], Law::Velocity(Profile::constant(vec![0.1, 0.0]).unwrap()));
        let bounds = task(&[Axis::Z], Law::Bounds(VelocityBounds::new(vec![-0.1], vec![0.1]).unwrap()));
        let robot = revprio_core::robot::built_in()[0].clone();
        let mut config = ControllerConfig::new(robot, 0.001, vec![moves, bounds]);
        config.constraints.push(Constraint::Fixed(Inequality::new("sum", vec![1.0; 7], 1.0).unwrap()));
        assert_eq!(of_controller(&config), 2 * (2 + 4 * (1 + 1) + 7) * 49);
    }

    const fn rows(count: usize) -> (usize, bool) {
        (count, false)
    }

    #[test]
    fn an_arm_is_inside_the_budgets_and_eight_rows_of_thirty_two_joints_are_not() {
        assert!(price([rows(6), rows(6), rows(6)].into_iter(), 0, 7) <= RESOLVE_BUDGET);
        assert!(price([rows(6), rows(1), rows(6), rows(7)].into_iter(), 2, 7) <= STEP_BUDGET);
        assert!(price([rows(8)].into_iter(), 0, 32) > STEP_BUDGET);
        assert!(price((0..64).map(|_| rows(1)), 0, 7) > STEP_BUDGET);
    }

    /// The dearest requests that the search found while a robot of one joint cost nearly nothing, and `qp` as much as `auto`.
    #[test]
    fn many_rows_of_few_joints_and_two_tasks_of_qp_are_beyond_the_budget() {
        assert!(price([rows(256), rows(256)].into_iter(), 0, 1) > RESOLVE_BUDGET);
        assert!(price((0..32).map(|_| (1, true)), 7, 1) > STEP_BUDGET);
        assert!(price([(1, true)].into_iter(), 512, 1) > STEP_BUDGET);
        assert!(QP * price([rows(1), rows(5)].into_iter(), 0, 7) > RESOLVE_BUDGET);
        assert!(QP * price([rows(1)].into_iter(), 0, 7) <= RESOLVE_BUDGET);
    }

    #[test]
    fn bounds_and_inequalities_cost_more_than_equations() {
        let of = |rows: (usize, bool), inequalities| price([rows].into_iter(), inequalities, 7);
        assert!(of((3, true), 0) > of((3, false), 0) && of((3, false), 2) > of((5, false), 0));
    }
}

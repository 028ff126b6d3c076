//! The problems of `tools/bench/peers`: kinematics and resolution of each, for a table with other programs.

#![allow(non_snake_case)]

use std::path::Path;

use revprio::service::solver as solver_of;
use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{ActiveSet, Problem, Resolution, Solve, Solver};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration, TaskFrame};
use revprio_robot::{RobotModel, built_in};

use super::core::cycle::NOMINAL;
use super::document;
use super::error::BenchError;
use super::timing::{Budget, Times, problem_by_problem};

/// Number of values per row: q, ẋ, limit, closed form, solution inside the limits.
const WIDTHS: [usize; 5] = [7, 6, 7, 7, 7];

/// Returns a line `name,median_s,p99_s,error,task_1_error` for each way to resolve the problems of a file.
pub fn lines(path: &Path, budget: Budget) -> Result<Vec<String>, BenchError> {
    let robot = sawyer()?;
    let rows = rows(path)?;
    let mut lines = vec![kinematics(robot, &rows, budget)?];
    for (name, solver, limits) in [
        ("closed form: revprio", Solver::ClosedForm, Limits::Ignored),
        ("closed form: revprio, auto", Solver::Auto, Limits::Ignored),
        ("limits: revprio", Solver::Auto, Limits::Kept),
        ("limits, Clarabel: revprio", Solver::Qp, Limits::Kept),
    ] {
        lines.push(resolution(robot, &rows, name, solver, limits, budget)?);
    }
    Ok(lines)
}

/// Returns the lines for a trajectory: from nothing in each period, and from the active limits of the period before.
pub fn trajectory_lines(path: &Path, budget: Budget) -> Result<Vec<String>, BenchError> {
    let robot = sawyer()?;
    let rows = rows(path)?;
    let from = |name: &str, warm: bool| {
        let (mut cycle, mut errors) = (Cycle::new(robot, Solver::Auto)?, Errors::default());
        let mut guess: Vec<ActiveSet> = Vec::new();
        let mut period = |index: usize, errors: Option<&mut Errors>| {
            if index == 0 || !warm {
                guess.clear();
            } else {
                std::mem::swap(&mut guess, &mut cycle.answer.active_set);
            }
            cycle.resolve(robot, &rows[index], Limits::Kept, &guess)?;
            if let Some(errors) = errors {
                errors.add(&cycle, &rows[index].limited);
            }
            Ok(())
        };
        let times = problem_by_problem(name, budget, rows.len(), |index| period(index, None))?;
        (0..rows.len()).try_for_each(|index| period(index, Some(&mut errors)))?;
        Ok::<_, BenchError>(errors.line(&times))
    };
    Ok(vec![from("trajectory: revprio, cold", false)?, from("trajectory: revprio, warm", true)?])
}

fn sawyer() -> Result<&'static RobotModel, BenchError> {
    let robot = built_in().iter().find(|robot| robot.name() == "sawyer");
    Ok(robot.ok_or_else(|| BenchError::Defect("there is no robot `sawyer`".to_owned()))?)
}

fn rows(path: &Path) -> Result<Vec<Row>, BenchError> {
    document::read(path)?.lines().map(Row::read).collect()
}

fn kinematics(robot: &RobotModel, rows: &[Row], budget: Budget) -> Result<String, BenchError> {
    let mut configuration = Configuration::new(robot, &NOMINAL).map_err(BenchError::defect)?;
    let call = |index: usize| configuration.update(robot, &rows[index].q).map_err(BenchError::defect);
    let times = problem_by_problem("kinematics: revprio", budget, rows.len(), call)?;
    Ok(format!("{},{:.4e},{:.4e},,", times.name, times.median(), times.quantile(0.99)))
}

fn resolution(
    robot: &RobotModel,
    rows: &[Row],
    name: &str,
    solver: Solver,
    limits: Limits,
    budget: Budget,
) -> Result<String, BenchError> {
    let (mut cycle, mut errors) = (Cycle::new(robot, solver)?, Errors::default());
    for row in rows {
        cycle.resolve(robot, row, limits, &[])?;
        errors.add(&cycle, if limits == Limits::Kept { &row.limited } else { &row.closed_form });
    }
    let call = |index: usize| cycle.resolve(robot, &rows[index], limits, &[]);
    Ok(errors.line(&problem_by_problem(name, budget, rows.len(), call)?))
}

/// Whether a problem has the limits of its row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Limits {
    Kept,
    Ignored,
}

/// Kinematics and resolution with memory that is allocated once, as in a control loop.
struct Cycle {
    configuration: Configuration,
    /// The rows of the tasks: x, and the other five.
    axes: [AxisSelection; 2],
    problem: Problem,
    solver: Box<dyn Solve>,
    answer: Resolution,
}

impl Cycle {
    fn new(robot: &RobotModel, solver: Solver) -> Result<Self, BenchError> {
        let axes = |axes: &[Axis]| AxisSelection::new(axes).map_err(BenchError::defect);
        let axes = [axes(&Axis::ALL[..1])?, axes(&Axis::ALL[1..])?];
        let n = robot.joint_count();
        let task = |axes: &AxisSelection| Task::new("", Matrix::zeros(axes.len(), n), Vector::zeros(axes.len()));
        let tasks = TaskStack::new(axes.iter().map(task).collect()).map_err(BenchError::defect)?;
        Ok(Self {
            configuration: Configuration::new(robot, &NOMINAL).map_err(BenchError::defect)?,
            axes,
            problem: Problem::new(tasks),
            solver: solver_of(solver),
            answer: Resolution::default(),
        })
    }

    fn resolve(
        &mut self,
        robot: &RobotModel,
        row: &Row,
        limits: Limits,
        guess: &[ActiveSet],
    ) -> Result<(), BenchError> {
        let Self { configuration, axes, problem, solver, answer } = self;
        configuration.update(robot, &row.q).map_err(BenchError::defect)?;
        let xdot = [&row.xdot[..1], &row.xdot[1..]];
        let write = |k: usize, jacobian: &mut Matrix, lower: &mut Vector, upper: &mut Vector| {
            TaskFrame::default().at(configuration).write_rows(&axes[k], jacobian);
            lower.as_mut_slice().copy_from_slice(xdot[k]);
            upper.as_mut_slice().copy_from_slice(xdot[k]);
        };
        problem.tasks.overwrite(write).map_err(BenchError::defect)?;
        if limits == Limits::Kept {
            problem.limits.copy_from(&row.limits);
        }
        solver.solve(problem, guess, answer).map_err(BenchError::defect)
    }
}

/// The largest errors of q̇ and of task 1 over the rows with an exact solution.
#[derive(Default)]
struct Errors {
    velocity: f64,
    first_task: f64,
}

impl Errors {
    fn add(&mut self, cycle: &Cycle, exact: &[f64]) {
        if exact.iter().any(|entry| entry.is_nan()) {
            return;
        }
        let difference = &cycle.answer.joint_velocity - Vector::from_row_slice(exact);
        self.velocity = self.velocity.max(difference.amax());
        self.first_task = self.first_task.max((&cycle.problem.tasks.tasks()[0].jacobian * difference).amax());
    }

    fn line(&self, times: &Times) -> String {
        let (median, p99) = (times.median(), times.quantile(0.99));
        format!("{},{median:.4e},{p99:.4e},{:.1e},{:.1e}", times.name, self.velocity, self.first_task)
    }
}

struct Row {
    q: Vec<f64>,
    xdot: Vec<f64>,
    limits: VelocityBox,
    closed_form: Vec<f64>,
    limited: Vec<f64>,
}

impl Row {
    fn read(line: &str) -> Result<Self, BenchError> {
        let numbers: Vec<f64> =
            line.split(',').map(str::parse).collect::<Result<_, _>>().map_err(BenchError::defect)?;
        if numbers.len() != WIDTHS.iter().sum::<usize>() {
            return Err(BenchError::Defect(format!("a row of the problem file has {} numbers", numbers.len())));
        }
        let mut rest = numbers.as_slice();
        let [q, xdot, limit, closed_form, limited] = WIDTHS.map(|width| {
            let (part, after) = rest.split_at(width);
            rest = after;
            part.to_vec()
        });
        let lower: Vec<f64> = limit.iter().map(|limit| -limit).collect();
        let limits = VelocityBox::new(&lower, &limit).map_err(BenchError::defect)?;
        Ok(Self { q, xdot, limits, closed_form, limited })
    }
}

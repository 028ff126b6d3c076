//! The problems of `tools/bench/peers`: kinematics and resolution of each, for a table with other programs.

#![allow(non_snake_case)]

use std::path::Path;

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::Vector;
use revprio_core::resolution::{Problem, Solver, resolve};
use revprio_core::task::{Task, TaskStack};
use revprio_robot::kinematics::{Axis, AxisSelection, Configuration};
use revprio_robot::{RobotModel, built_in};

use super::core::cycle::NOMINAL;
use super::timing::{Budget, Subject, side_by_side};
use super::{BenchError, document};

/// Number of values per row: q, ẋ, limit, closed form, solution inside the limits.
const WIDTHS: [usize; 5] = [7, 6, 7, 7, 7];

/// Returns a line `name,median_s,p99_s,error,task_1_error` for each way to resolve the problems of a file.
pub fn lines(path: &Path, budget: Budget) -> Result<Vec<String>, BenchError> {
    let robot = built_in().iter().find(|robot| robot.name() == "sawyer");
    let robot = robot.ok_or_else(|| BenchError::Defect("there is no robot `sawyer`".to_owned()))?;
    let rows: Vec<Row> = document::read(path)?.lines().map(Row::read).collect::<Result<_, _>>()?;
    let mut lines = vec![kinematics(robot, &rows, budget)?];
    let ways = [("closed form", Solver::ClosedForm), ("limits", Solver::Auto), ("limits, Clarabel", Solver::Qp)];
    for (name, solver) in ways {
        lines.push(resolution(robot, &rows, name, solver, budget)?);
    }
    Ok(lines)
}

fn kinematics(robot: &RobotModel, rows: &[Row], budget: Budget) -> Result<String, BenchError> {
    let mut next = rows.iter().cycle();
    let step = || Configuration::new(robot, next.next().map_or(&NOMINAL[..], |row| &row.q)).map_err(BenchError::defect);
    let times = side_by_side(budget, vec![Subject::fallible("kinematics: revprio", step)])?;
    Ok(format!("{},{:.4e},{:.4e},,", times[0].name, times[0].median(), times[0].quantile(0.99)))
}

fn resolution(
    robot: &RobotModel,
    rows: &[Row],
    name: &str,
    solver: Solver,
    budget: Budget,
) -> Result<String, BenchError> {
    let (mut error, mut first) = (0.0_f64, 0.0_f64);
    for row in rows {
        let (qdot, J) = row.resolved(robot, solver)?;
        let exact = if solver == Solver::ClosedForm { &row.closed_form } else { &row.limited };
        let difference = qdot - Vector::from_row_slice(exact);
        error = error.max(difference.amax());
        first = first.max((J * difference).amax());
    }
    let mut next = rows.iter().cycle();
    let step = || next.next().map(|row| row.resolved(robot, solver)).transpose();
    let times = side_by_side(budget, vec![Subject::fallible(format!("{name}: revprio"), step)])?;
    let (median, p99) = (times[0].median(), times[0].quantile(0.99));
    Ok(format!("{},{median:.4e},{p99:.4e},{error:.1e},{first:.1e}", times[0].name))
}

struct Row {
    q: Vec<f64>,
    xdot: Vec<f64>,
    limit: Vec<f64>,
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
        Ok(Self { q, xdot, limit, closed_form, limited })
    }

    /// Resolves the problem. Returns q̇ and J_1.
    fn resolved(
        &self,
        robot: &RobotModel,
        solver: Solver,
    ) -> Result<(Vector, revprio_core::linalg::Matrix), BenchError> {
        let configuration = Configuration::new(robot, &self.q).map_err(BenchError::defect)?;
        let task = |name: &str, axes: &[Axis], xdot: &[f64]| {
            let axes = AxisSelection::new(axes).map_err(BenchError::defect)?;
            Ok::<_, BenchError>(Task::new(name, axes.rows_of(configuration.jacobian()), Vector::from_row_slice(xdot)))
        };
        let tasks = vec![task("1", &Axis::ALL[..1], &self.xdot[..1])?, task("2", &Axis::ALL[1..], &self.xdot[1..])?];
        let J_1 = tasks[0].jacobian.clone();
        let lower: Vec<f64> = self.limit.iter().map(|limit| -limit).collect();
        let limits = VelocityBox::new(&lower, &self.limit).map_err(BenchError::defect)?;
        let tasks = TaskStack::new(tasks).map_err(BenchError::defect)?;
        let resolution =
            resolve(&Problem { limits, solver, ..Problem::new(tasks) }, &[]).map_err(BenchError::defect)?;
        Ok((resolution.joint_velocity, J_1))
    }
}

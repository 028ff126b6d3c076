//! The hierarchies of `tools/bench/peers`: 35 joints and four levels, for a table with another solver.

use std::path::Path;

use revprio_core::limits::VelocityBox;
use revprio_core::linalg::{Matrix, Vector};
use revprio_core::resolution::{ActiveSet, Method, Problem, Resolution, Resolver, Status};
use revprio_core::task::{Task, TaskStack};

use super::document;
use super::error::BenchError;
use super::timing::{Budget, problem_by_problem};

const JOINTS: usize = 35;

/// Rows per level.
const LEVELS: [usize; 4] = [12, 6, 6, 8];
const ROWS: usize = 32;

/// Problems at the beginning of the file that do not follow each other.
const INDEPENDENT: usize = 100;

/// Numbers of a problem: limits, rows, velocities and solution.
const WIDTH: usize = 3 * JOINTS + ROWS * JOINTS + ROWS;

/// Returns two lines for each way: `name,median_s,p99_s,error,level_1_error`, and a remark with the errors of all
/// levels.
pub fn lines(path: &Path, budget: Budget) -> Result<Vec<String>, BenchError> {
    let bytes = document::read_bytes(path)?;
    let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let hierarchies: Vec<Hierarchy> = numbers.chunks(WIDTH).map(Hierarchy::read).collect::<Result<_, _>>()?;
    if hierarchies.len() <= INDEPENDENT {
        return Err(BenchError::Defect(format!("the file has only {} hierarchies", hierarchies.len())));
    }
    let (independent, trajectory) = hierarchies.split_at(INDEPENDENT);
    let ways = [
        measured("35 joints: revprio, cold", independent, false, budget)?,
        measured("35 joints along a trajectory: revprio, cold", trajectory, false, budget)?,
        measured("35 joints along a trajectory: revprio, warm", trajectory, true, budget)?,
    ];
    Ok(ways.concat())
}

/// Resolves the hierarchies in order, from nothing or from the active limits of the one before.
fn measured(name: &str, hierarchies: &[Hierarchy], warm: bool, budget: Budget) -> Result<[String; 2], BenchError> {
    let (mut resolver, mut answer, mut errors) = (Resolver::default(), Resolution::default(), Errors::default());
    let mut guess: Vec<ActiveSet> = Vec::new();
    let mut next = |index: usize, errors: Option<&mut Errors>| {
        if index == 0 || !warm {
            guess.clear();
        } else {
            std::mem::swap(&mut guess, &mut answer.active_set);
        }
        resolver.resolve(&hierarchies[index].problem, &guess, &mut answer).map_err(BenchError::defect)?;
        if let Some(errors) = errors {
            errors.add(&hierarchies[index], &answer);
        }
        Ok(())
    };
    let times = problem_by_problem(name, budget, hierarchies.len(), |index| next(index, None))?;
    (0..hierarchies.len()).try_for_each(|index| next(index, Some(&mut errors)))?;
    let Errors { velocity, levels: [first, second, third, fourth], uncertified, outside } = errors;
    Ok([
        format!("{name},{:.4e},{:.4e},{velocity:.1e},{first:.1e}", times.median(), times.quantile(0.99)),
        format!(
            "{name}: residuals of levels 1 to 4 above the optimum by up to {first:.1e} {second:.1e} {third:.1e} \
             {fourth:.1e}; {uncertified} of {} not certified; limits exceeded by up to {outside:.1e}",
            hierarchies.len()
        ),
    ])
}

/// The largest errors over the hierarchies with an exact solution.
#[derive(Default)]
struct Errors {
    velocity: f64,
    /// Residual of each level above that of the exact solution.
    levels: [f64; LEVELS.len()],
    uncertified: u32,
    /// Excess over a limit.
    outside: f64,
}

impl Errors {
    fn add(&mut self, hierarchy: &Hierarchy, answer: &Resolution) {
        self.uncertified += u32::from(answer.solver.status != Status::Optimal);
        self.outside = self.outside.max(hierarchy.problem.limits.violation(&answer.joint_velocity));
        if hierarchy.exact.iter().any(|entry| entry.is_nan()) {
            return;
        }
        self.velocity = self.velocity.max((&answer.joint_velocity - &hierarchy.exact).amax());
        for (worst, task) in self.levels.iter_mut().zip(hierarchy.problem.tasks.tasks()) {
            let residual = |velocity: &Vector| (&task.jacobian * velocity - &task.lower).norm();
            *worst = worst.max(residual(&answer.joint_velocity) - residual(&hierarchy.exact));
        }
    }
}

struct Hierarchy {
    problem: Problem,
    exact: Vector,
}

impl Hierarchy {
    fn read(numbers: &[f64]) -> Result<Self, BenchError> {
        if numbers.len() != WIDTH {
            return Err(BenchError::Defect(format!("a hierarchy of the file has {} numbers", numbers.len())));
        }
        let mut rest = numbers;
        let [lower, upper, rows, velocities, exact] = [JOINTS, JOINTS, ROWS * JOINTS, ROWS, JOINTS].map(|width| {
            let (part, after) = rest.split_at(width);
            rest = after;
            part
        });
        let (mut rows, mut velocities) = (rows, velocities);
        let tasks = LEVELS.map(|m| {
            let (jacobian, velocity);
            (jacobian, rows) = rows.split_at(m * JOINTS);
            (velocity, velocities) = velocities.split_at(m);
            Task::new("", Matrix::from_row_slice(m, JOINTS, jacobian), Vector::from_row_slice(velocity))
        });
        let tasks = TaskStack::new(tasks.to_vec()).map_err(BenchError::defect)?;
        let limits = VelocityBox::new(lower, upper).map_err(BenchError::defect)?;
        let problem = Problem { limits, method: Method::StrictReversePriority, ..Problem::new(tasks) };
        Ok(Self { problem, exact: Vector::from_row_slice(exact) })
    }
}

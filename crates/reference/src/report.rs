//! Writing the answer of a reference solver.

use revprio_problem::{
    ActiveInequality, ActiveLimit, ActiveRow, ActiveSet, InequalityViolation, LimitViolation, Problem, Resolution,
    RowName, Side, SolverReport, Status, TaskOutcome, Vector,
};

use crate::hierarchy::{Hierarchy, Solution};
use crate::polish::CERTIFIED;
use crate::singularity::Singularities;

/// Writes the velocity and what follows from it alone. A velocity that is not finite is replaced by the slowest one inside the
/// limits, with the status `failed`.
pub fn write_velocity(problem: &Problem, known: &Singularities, x: &Vector, answer: &mut Resolution) {
    let n = problem.tasks.joint_count();
    let is_finite = x.iter().take(n).all(|velocity| velocity.is_finite());
    answer.joint_velocity = if is_finite { x.rows(0, n).into_owned() } else { problem.limits.clamp(&Vector::zeros(n)) };
    let velocity = &answer.joint_velocity;
    let outcome = |(task, known): (&revprio_problem::Task, &crate::singularity::TaskSingularity)| {
        let achieved = &task.jacobian * velocity;
        let bounds = task.lower.iter().zip(task.upper.iter());
        let missing = achieved.iter().zip(bounds).map(|(value, (lower, upper))| (lower - value).max(value - upper));
        TaskOutcome {
            residual_norm: missing.filter(|missing| *missing > 0.0).fold(0.0, f64::hypot),
            achieved,
            rank: if is_finite { known.rank } else { 0 },
            algorithmic: is_finite && known.algorithmic,
            scale: (task.scaled && is_finite).then_some(1.0),
            active_rows: Vec::new(),
        }
    };
    answer.tasks = problem.tasks.tasks().iter().zip(&known.tasks).map(outcome).collect();
    answer.singularity = revprio_problem::Singularity::default();
    if is_finite {
        answer.singularity.algorithmic = known.tasks.iter().any(|task| task.algorithmic);
        answer.singularity.set(known.smallest, known.product);
    }
    let broken = problem.inequalities.iter().filter(|inequality| inequality.violation(velocity) > 0.0);
    let violation = |inequality: &revprio_problem::Inequality| InequalityViolation {
        name: inequality.shared_name(),
        bound: inequality.bound(),
        value: inequality.value(velocity),
    };
    answer.violated_inequalities = broken.map(violation).collect();
    answer.violated_limits.clear();
    answer.active_limits.clear();
    answer.active_inequalities.clear();
    answer.contradictions.clear();
    answer.active_set.clear();
    answer.levels.clear();
    answer.certificate = None;
    let status = if is_finite { Status::NotCertified } else { Status::Failed };
    answer.solver = SolverReport { status, ..SolverReport::default() };
}

/// Returns how sure an answer with this residual of the optimality conditions is.
pub fn status(residual: f64) -> Status {
    if residual <= CERTIFIED { Status::Optimal } else { Status::NotCertified }
}

/// Lists the limits that the velocity breaks.
pub fn write_violations(problem: &Problem, answer: &mut Resolution) {
    let bounds = problem.limits.lower().iter().zip(problem.limits.upper().iter());
    let broken = |(joint, (&value, (&lower, &upper))): (usize, (&f64, (&f64, &f64)))| {
        let (side, limit) = if value > upper { (Side::Upper, upper) } else { (Side::Lower, lower) };
        (value > upper || value < lower).then_some(LimitViolation { joint, side, limit, value })
    };
    answer.violated_limits = answer.joint_velocity.iter().zip(bounds).enumerate().filter_map(broken).collect();
}

/// Writes what holds the answer back, from the multipliers of the last problem.
pub fn write_bounds(problem: &Problem, hierarchy: &Hierarchy, solution: &Solution, answer: &mut Resolution) {
    for joint in 0..problem.tasks.joint_count() {
        let multiplier = solution.multipliers[joint];
        let side = if multiplier < 0.0 { Side::Lower } else { Side::Upper };
        if multiplier != 0.0 || hierarchy.is_pinned(joint) {
            let value = hierarchy.bound(joint, side);
            answer.active_limits.push(ActiveLimit { joint, side, value, multiplier: multiplier.abs() });
        }
    }
    let n = problem.tasks.joint_count();
    let joints = (0..n).filter_map(|joint| Some((joint, solution.active[joint]?)));
    let mut set: ActiveSet = joints.collect();
    for (index, level) in hierarchy.levels.iter().enumerate() {
        for (row, name) in level.names.iter().enumerate() {
            let multiplier = solution.row_multipliers[index][row];
            if let Some(side) = solution.active_rows[index][row] {
                set.extend(place(problem, *name).map(|place| (place, side)));
            }
            if multiplier == 0.0 {
                continue;
            }
            let side = if multiplier < 0.0 { Side::Lower } else { Side::Upper };
            match *name {
                RowName::Inequality(index) => {
                    let inequality = &problem.inequalities[index];
                    answer.active_inequalities.push(ActiveInequality {
                        name: inequality.shared_name(),
                        bound: inequality.bound(),
                        // The rows of the problem have length one.
                        multiplier: multiplier.abs() / inequality.coefficients().norm(),
                    });
                }
                RowName::Task { task, row } => {
                    answer.tasks[task].active_rows.push(ActiveRow { row, side, multiplier: multiplier.abs() });
                }
                RowName::Auxiliary => {}
            }
        }
    }
    answer.active_set = vec![set];
}

/// Returns the index of a row in an active set.
fn place(problem: &Problem, name: RowName) -> Option<usize> {
    let n = problem.tasks.joint_count();
    match name {
        RowName::Inequality(index) => Some(n + index),
        RowName::Task { task, row } => Some(n + problem.inequalities.len() + problem.tasks.first_row(task) + row),
        RowName::Auxiliary => None,
    }
}

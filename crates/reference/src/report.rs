//! Writing the answer of a reference solver.

use revprio_problem::{
    ActiveBound, ActiveSet, Bound, BoundId, BrokenBound, Problem, Resolution, Side, SolverReport, Status, TaskOutcome,
    Vector,
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
        }
    };
    answer.tasks = problem.tasks.tasks().iter().zip(&known.tasks).map(outcome).collect();
    answer.singularity = revprio_problem::Singularity::default();
    if is_finite {
        answer.singularity.algorithmic = known.tasks.iter().any(|task| task.algorithmic);
        answer.singularity.set(known.smallest, known.product);
    }
    let broken = problem.constraint_rows().filter(|(_, inequality)| inequality.violation(velocity) > 0.0);
    let violation = |(id, inequality): (BoundId, &revprio_problem::Inequality)| BrokenBound {
        bound: Bound::upper(id),
        limit: inequality.bound(),
        value: inequality.value(velocity),
    };
    answer.broken_bounds = broken.map(violation).collect();
    answer.active_bounds.clear();
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
        let bound = Bound { id: BoundId::Joint(joint), side };
        (value > upper || value < lower).then_some(BrokenBound { bound, limit, value })
    };
    let broken = answer.joint_velocity.iter().zip(bounds).enumerate().filter_map(broken);
    // Joints come first.
    answer.broken_bounds.splice(..0, broken);
}

/// Writes what holds the answer back, from the multipliers of the last problem.
pub fn write_bounds(problem: &Problem, hierarchy: &Hierarchy, solution: &Solution, answer: &mut Resolution) {
    let n = problem.tasks.joint_count();
    let mut set = ActiveSet::new();
    for joint in 0..n {
        let (id, multiplier) = (BoundId::Joint(joint), solution.multipliers[joint]);
        set.extend(solution.active[joint].map(|side| Bound { id, side }));
        if multiplier != 0.0 || hierarchy.is_pinned(joint) {
            let side = Side::of_multiplier(multiplier);
            let value = hierarchy.bound(joint, side);
            answer.active_bounds.push(ActiveBound { bound: Bound { id, side }, value, multiplier: multiplier.abs() });
        }
    }
    for (index, level) in hierarchy.levels.iter().enumerate() {
        for (row, &name) in level.names.iter().enumerate() {
            let Some(id) = name else { continue };
            set.extend(solution.active_rows[index][row].map(|side| Bound { id, side }));
            let multiplier = solution.row_multipliers[index][row];
            if multiplier == 0.0 {
                continue;
            }
            let side = Side::of_multiplier(multiplier);
            let (value, length) = match id {
                // Constraints have rows of length one.
                BoundId::Constraint { .. } => {
                    let found = problem.constraint_rows().find(|(other, _)| *other == id);
                    found.map_or((f64::INFINITY, 1.0), |(_, row)| (row.bound(), row.coefficients().norm()))
                }
                _ if side == Side::Lower => (level.lower[row], 1.0),
                _ => (level.upper[row], 1.0),
            };
            let bound = Bound { id, side };
            answer.active_bounds.push(ActiveBound { bound, value, multiplier: multiplier.abs() / length });
        }
    }
    // The levels need not be in the order of the names.
    set.sort_unstable_by_key(|bound| bound.id);
    answer.active_set = vec![set];
}

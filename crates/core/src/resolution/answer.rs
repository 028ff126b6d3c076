//! Writing the answer: joint velocities with their explanation.

use revprio_problem::{
    ActiveBound, ActiveSet, Bound, BoundId, BrokenBound, Path, Problem, Resolution, Side, Singularity, SolverReport,
    Status, Task, TaskOutcome,
};

use super::engine::Engine;
use super::hierarchy::Hierarchy;
use super::named_bounds::write_active_set;
use super::plan_run::PlanRun;
use super::singularity::{Singularities, TaskSingularity};
use super::solution::{Certainty, Solution, refill};
use crate::linalg::{Vector, all_finite, write_product};
use crate::tolerances::TOLERANCES;

/// Sets the answer from the solution of a plan.
pub fn write_answer(
    answer: &mut Resolution,
    problem: &Problem,
    singularities: &Singularities,
    run: &mut PlanRun,
    engine: &Engine,
) {
    let PlanRun { levels, solution, scales, contradictions, .. } = run;
    let path = if solution.working_set.is_empty() { Path::ClosedForm } else { Path::ActiveSet };
    let achieved = task_values(levels, problem.tasks.first_row(singularities.tasks.len()), solution);
    report_velocity(answer, problem, singularities, &solution.x, achieved);
    for (task, (scale, stated)) in answer.tasks.iter_mut().zip(scales.iter().zip(problem.tasks.tasks())) {
        task.scale = scale.filter(|_| stated.scaled);
    }
    let is_failed = answer.solver.status == Status::Failed;
    report_solver(answer, path, solution.certainty);
    if is_failed {
        clear_bounds(answer);
        return;
    }
    report_bounds(answer, problem, levels, solution);
    std::mem::swap(&mut answer.contradictions, contradictions);
    answer.solver.rank_uncertain |= singularities.rank_uncertain;
    answer.solver.last_resorts = engine.last_resorts;
    if solution.working_set.is_empty() {
        answer.active_set.clear();
        return;
    }
    answer.active_set.resize_with(1, ActiveSet::new);
    write_active_set(levels, problem.tasks.joint_count(), &solution.working_set, &mut answer.active_set[0]);
}

/// Returns J_k q̇ of all tasks in their order, if the rows of the problem are the `count` rows of the tasks and no others;
/// otherwise nothing.
fn task_values<'a>(levels: &Hierarchy, count: usize, solution: &'a Solution) -> &'a [f64] {
    let has_tasks_alone =
        levels.rows.len() == count && levels.rows.iter().all(|row| matches!(row.origin, Some(BoundId::Task { .. })));
    if has_tasks_alone { &solution.row_values } else { &[] }
}

/// Sets the velocity and what follows from it alone. A velocity that is not finite is replaced by standstill, with the
/// status `failed`. `achieved`: as for [`report_tasks`].
fn report_velocity(
    answer: &mut Resolution,
    problem: &Problem,
    singularities: &Singularities,
    x: &[f64],
    achieved: &[f64],
) {
    let x = &x[..problem.tasks.joint_count()];
    let is_finite = all_finite(x);
    if is_finite {
        set_velocity(answer, x);
        singularities.write(&problem.tasks, &mut answer.singularity);
        answer.solver.status = Status::NotCertified;
    } else {
        answer.joint_velocity = problem.limits.clamp(&Vector::zeros(x.len()));
        answer.singularity = Singularity::default();
        answer.solver.status = Status::Failed;
    }
    report_tasks(answer, problem, singularities, if is_finite { achieved } else { &[] });
    if !is_finite {
        for outcome in &mut answer.tasks {
            (outcome.rank, outcome.algorithmic, outcome.scale) = (0, false, None);
        }
    }
    let velocity = &answer.joint_velocity;
    let broken = problem.constraint_rows().filter(|(_, inequality)| inequality.violation(velocity) > 0.0);
    refill(
        &mut answer.broken_bounds,
        broken.map(|(id, inequality)| BrokenBound {
            bound: Bound::upper(id),
            limit: inequality.bound(),
            value: inequality.value(velocity),
        }),
    );
}

fn set_velocity(answer: &mut Resolution, x: &[f64]) {
    if answer.joint_velocity.len() != x.len() {
        answer.joint_velocity = Vector::zeros(x.len());
    }
    answer.joint_velocity.as_mut_slice().copy_from_slice(x);
}

/// Sets the outcomes of the tasks at the velocity. `achieved`: the values of the rows of all tasks; empty: they are computed.
fn report_tasks(answer: &mut Resolution, problem: &Problem, singularities: &Singularities, mut achieved: &[f64]) {
    let tasks = problem.tasks.tasks();
    answer.tasks.resize_with(tasks.len(), TaskOutcome::default);
    for ((outcome, task), known) in answer.tasks.iter_mut().zip(tasks).zip(&singularities.tasks) {
        let own = achieved.split_off(..task.jacobian.nrows());
        report_task(outcome, task, *known, answer.joint_velocity.as_slice(), own);
    }
}

fn clear_bounds(answer: &mut Resolution) {
    answer.active_bounds.clear();
    answer.contradictions.clear();
    answer.active_set.clear();
}

/// Lists the active bounds from the multipliers.
fn report_bounds(answer: &mut Resolution, problem: &Problem, levels: &Hierarchy, solution: &Solution) {
    let (lower, upper) = (problem.limits.lower().as_slice(), problem.limits.upper().as_slice());
    let bounds = lower.iter().zip(upper).zip(&solution.multipliers).enumerate();
    let is_active =
        |(_, ((lower, upper), multiplier)): &(usize, ((&f64, &f64), &f64))| lower == upper || **multiplier != 0.0;
    let active = |(joint, ((&lower, &upper), &multiplier)): (usize, ((&f64, &f64), &f64))| {
        let side = Side::of_multiplier(multiplier);
        let value = if side == Side::Lower { lower } else { upper };
        let bound = Bound { id: BoundId::Joint(joint), side };
        ActiveBound { bound, value, multiplier: multiplier.abs() }
    };
    refill(&mut answer.active_bounds, bounds.filter(is_active).map(active));
    // The rows of the constraints are the first ones, with length one.
    let mut constraints = problem.constraint_rows();
    for &index in &levels.inequalities {
        let (row, multiplier) = (&levels.rows[index], solution.row_multipliers[index]);
        let is_constraint = matches!(row.origin, Some(BoundId::Constraint { .. }));
        let constraint = if is_constraint { constraints.next() } else { None };
        let Some(id) = row.origin.filter(|_| multiplier != 0.0) else { continue };
        let side = Side::of_multiplier(multiplier);
        let (value, length) = constraint
            .map_or((row.bound(side), 1.0), |(_, inequality)| (inequality.bound(), inequality.coefficients().norm()));
        let bound = Bound { id, side };
        answer.active_bounds.push(ActiveBound { bound, value, multiplier: multiplier.abs() / length });
    }
}

fn report_solver(answer: &mut Resolution, path: Path, certainty: Certainty) {
    if answer.solver.status == Status::Failed {
        answer.solver = SolverReport { path, ..SolverReport::default() };
        return;
    }
    let Certainty { is_optimal, rank_uncertain, kkt_residual, working_sets } = certainty;
    answer.solver = SolverReport {
        path,
        status: if is_optimal { status(kkt_residual) } else { Status::NotCertified },
        kkt_residual: Some(kkt_residual).filter(|residual| residual.is_finite()),
        rank_uncertain,
        working_sets,
        ..SolverReport::default()
    };
}

/// Sets the outcome at q̇, whose product with the Jacobian may be known; a scaled task that no limit cuts has the scale 1.
fn report_task(
    outcome: &mut TaskOutcome,
    task: &Task,
    known: TaskSingularity,
    joint_velocity: &[f64],
    achieved: Option<&[f64]>,
) {
    let rows = task.jacobian.nrows();
    if outcome.achieved.len() != rows {
        outcome.achieved = Vector::zeros(rows);
    }
    match achieved {
        Some(achieved) => outcome.achieved.as_mut_slice().copy_from_slice(achieved),
        None => write_product(&task.jacobian, joint_velocity, outcome.achieved.as_mut_slice()),
    }
    let bounds = || task.lower.as_slice().iter().zip(task.upper.as_slice());
    let missing = |(achieved, (lower, upper)): (&f64, (&f64, &f64))| {
        let (above, below) = (achieved - upper, lower - achieved);
        if above > below { above } else { below }.max(0.0)
    };
    let missing = || outcome.achieved.as_slice().iter().zip(bounds()).map(missing);
    let square: f64 = missing().map(|missing| missing * missing).sum();
    let is_exact = square >= f64::MIN_POSITIVE / f64::EPSILON && square.is_finite();
    outcome.residual_norm = if is_exact { square.sqrt() } else { missing().fold(0.0, f64::hypot) };
    outcome.rank = known.rank;
    outcome.algorithmic = known.algorithmic;
    outcome.scale = task.scaled.then_some(1.0);
}

/// Returns how sure an answer is that meets its optimality conditions up to this residual.
fn status(residual: f64) -> Status {
    if residual <= TOLERANCES.certified { Status::Optimal } else { Status::NotCertified }
}

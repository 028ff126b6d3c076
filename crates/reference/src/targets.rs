//! The task velocities that damping leaves, without limits.
//!
//! Each of them is the solution of a least-squares problem, which Clarabel solves as all other levels.
#![allow(non_snake_case)]

use revprio_problem::{BoundId, Damping, Matrix, Problem, Task, Vector};

use crate::damping::{factor, kept_directions};
use crate::hierarchy::{Hierarchy, Level};
use crate::plan::Aim;
use crate::singularity::Singularities;
use crate::step::Step;
use crate::svd::{PROJECTION_ERROR, RANK_TOLERANCE, Svd};

/// Solves a problem without limits.
pub type Solver<'a> = &'a mut dyn FnMut(&Hierarchy) -> Vector;

/// Replaces the targets of a step by what damping leaves of them; returns λ of its damping rows.
pub fn damp(problem: &Problem, step: Step, known: &Singularities, aim: &mut Aim, solve: Solver) -> f64 {
    let (Some(damping), tasks) = (problem.damping, problem.tasks.tasks()) else { return 0.0 };
    match step {
        Step::OneLevel => {
            let all = tasks.iter().position(Task::is_equation).map_or(0.0, |first| known.tasks[first].lambda);
            let damps = problem.method == revprio_problem::Method::DampedLeastSquares;
            let lambda = if damps { all } else { 0.0 };
            if lambda > 0.0 && tasks.iter().any(|task| task.scaled) {
                // A scaled stack has one velocity. Damping forms it first.
                lower(problem, 0..tasks.len(), lambda, aim, solve);
                return 0.0;
            }
            lambda
        }
        Step::Levels => {
            lower_hierarchy(problem, damping, aim, solve);
            0.0
        }
        Step::Stage { task, keeps_lower_tasks } => {
            let lambda = if keeps_lower_tasks { known.tasks[task].lambda } else { 0.0 };
            if known.tasks[task].mu > 0.0 {
                let reached = lower(problem, task..task + 1, known.tasks[task].mu, aim, solve);
                if keeps_lower_tasks && tasks[task + 1..].iter().any(Task::is_equation) {
                    fade(problem, task, lambda, &reached, aim, solve);
                }
            }
            lambda
        }
    }
}

/// Solves min ‖J q̇ − ẋ‖² + λ² ‖q̇ − q̇'‖² for the equations of tasks and sets their targets to J q̇; returns q̇.
fn lower(problem: &Problem, tasks: std::ops::Range<usize>, lambda: f64, aim: &mut Aim, solve: Solver) -> Vector {
    let own = || tasks.clone().map(|k| (k, &problem.tasks.tasks()[k])).filter(|(_, task)| task.is_equation());
    let mut level = Level::new(aim.before.len());
    for (k, task) in own() {
        let target = aim.targets[k].as_slice();
        level.push(&task.jacobian, target, target, |row| Some(BoundId::Task { index: k, row }));
    }
    level.push_damping(lambda, &aim.before);
    let mut hierarchy = Hierarchy::new(aim.before.clone());
    hierarchy.push(level);
    let reached = solve(&hierarchy);
    for (k, task) in own() {
        aim.targets[k] = &task.jacobian * &reached;
    }
    reached
}

/// Moves the targets of task k, after [`lower`] has found q̇ = `reached`, along the directions of its weak singular values: the
/// smaller one is, the more its direction does what the lower tasks do with it where it is free.
fn fade(problem: &Problem, k: usize, lambda: f64, reached: &Vector, aim: &mut Aim, solve: Solver) {
    let task = &problem.tasks.tasks()[k];
    let svd = Svd::new(&task.jacobian);
    let rank = svd.rank(RANK_TOLERANCE * task.jacobian.norm());
    for (kept, share) in kept_directions(svd.singular_values(), rank, problem.damping) {
        if kept == rank {
            continue;
        }
        let mut hierarchy = Hierarchy::new(aim.before.clone());
        let mut level = Level::new(aim.before.len());
        let directions = svd.row_space(kept).transpose();
        let values = &directions * reached;
        level.push(&directions, values.as_slice(), values.as_slice(), |_| None);
        hierarchy.push(level);
        let mut level = Level::new(aim.before.len());
        for lower in problem.tasks.tasks()[k + 1..].iter().filter(|task| task.is_equation()) {
            let achieved = &lower.jacobian * &aim.before;
            level.push(&lower.jacobian, achieved.as_slice(), achieved.as_slice(), |_| None);
        }
        level.push_damping(lambda, &aim.before);
        hierarchy.push(level);
        let released = solve(&hierarchy);
        aim.targets[k] += &task.jacobian * (released - reached) * share;
    }
}

/// One choice of directions that higher tasks keep from lower ones.
struct Chain {
    weight: f64,
    /// q̇ of the tasks so far.
    point: Vector,
    /// Projector onto what they leave, and the number of its dimensions.
    N: Matrix,
    open: usize,
    /// Smallest relative singular value that is kept.
    weakest: f64,
}

/// Chains with less weight are left out, and so are those beyond this number: one weak singular value asks for two.
const NEGLIGIBLE: f64 = 1e-9;
const MAX_CHAINS: usize = 64;

/// Sets the targets of the strict hierarchy to those of q̇ ← q̇ + (J_k N)^# (ẋ_k − J_k q̇), k = 1 … l, an average over the
/// directions that tasks keep; then N ζ̇. Nothing is changed where no task is damped.
fn lower_hierarchy(problem: &Problem, damping: Damping, aim: &mut Aim, solve: Solver) {
    let n = aim.before.len();
    let equations: Vec<usize> = (0..aim.targets.len()).filter(|&k| problem.tasks.tasks()[k].is_equation()).collect();
    let tasks = || equations.iter().map(|&k| &problem.tasks.tasks()[k]);
    if !is_damped(tasks(), damping) {
        return;
    }
    let mut chains = vec![Chain::new(n)];
    for &k in &equations {
        let task = &problem.tasks.tasks()[k];
        // Nothing uses what the lowest task leaves but the null-space velocity.
        let fades = Some(&k) != equations.last() || aim.before.amax() > 0.0;
        let next = |chain: Chain| chain.add(task, &aim.targets[k], fades, damping, solve);
        chains = chains.into_iter().flat_map(next).collect();
        chains.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        chains.truncate(MAX_CHAINS);
        let total: f64 = chains.iter().map(|chain| chain.weight).sum();
        for chain in &mut chains {
            chain.weight /= total;
        }
    }
    let parts = chains.iter().map(|chain| (&chain.point + &chain.N * &aim.before) * chain.weight);
    let average = parts.fold(Vector::zeros(n), |sum, part| sum + part);
    for k in equations {
        aim.targets[k] = &problem.tasks.tasks()[k].jacobian * &average;
    }
}

/// Returns whether damping acts on a task of the strict hierarchy.
fn is_damped<'a>(tasks: impl Iterator<Item = &'a Task>, damping: Damping) -> bool {
    let mut chain: Option<Chain> = None;
    for task in tasks {
        let before = chain.unwrap_or_else(|| Chain::new(task.jacobian.ncols()));
        let projected = before.project(task);
        if factor(Some(damping), projected.smallest) > 0.0 {
            return true;
        }
        chain = Some(before.keeping(&projected, projected.rank, 1.0));
    }
    false
}

/// J_k N, decomposed.
struct Projected {
    svd: Svd,
    norm: f64,
    rank: usize,
    /// σ_min on what the higher tasks leave.
    smallest: f64,
}

impl Chain {
    fn new(n: usize) -> Self {
        Self { weight: 1.0, point: Vector::zeros(n), N: Matrix::identity(n, n), open: n, weakest: 1.0 }
    }

    fn project(&self, task: &Task) -> Projected {
        let norm = task.jacobian.norm();
        let svd = Svd::new(&(&task.jacobian * &self.N));
        let open = task.jacobian.nrows().min(self.open);
        let rank = svd.rank(RANK_TOLERANCE.max(PROJECTION_ERROR / self.weakest) * norm).min(open);
        let smallest = open.checked_sub(1).map_or(0.0, |last| svd.singular_values()[last]);
        Projected { svd, norm, rank, smallest }
    }

    /// Returns the chain after a task that keeps `kept` directions.
    fn keeping(&self, Projected { svd, norm, .. }: &Projected, kept: usize, share: f64) -> Self {
        Self {
            weight: self.weight * share,
            point: self.point.clone(),
            N: &self.N - svd.row_projector(kept),
            open: self.open - kept,
            weakest: if kept > 0 { self.weakest.min(svd.singular_values()[kept - 1] / norm) } else { self.weakest },
        }
    }

    /// Adds a task; returns the chains that go on, one for each way to keep its directions.
    fn add(mut self, task: &Task, target: &Vector, fades: bool, damping: Damping, solve: Solver) -> Vec<Self> {
        let projected = self.project(task);
        let Projected { svd, rank, smallest, .. } = &projected;
        let missing = svd.range(*rank).tr_mul(&(target - &task.jacobian * &self.point));
        let mut rows = svd.row_space(*rank).transpose();
        for (mut row, sigma) in rows.row_iter_mut().zip(svd.singular_values()) {
            row *= *sigma;
        }
        let rest = Vector::zeros(self.point.len());
        let mut level = Level::new(rest.len());
        level.push(&rows, missing.as_slice(), missing.as_slice(), |_| None);
        level.push_damping(factor(Some(damping), *smallest), &rest);
        let mut hierarchy = Hierarchy::new(rest);
        hierarchy.push(level);
        if *rank > 0 {
            self.point += solve(&hierarchy);
        }
        let mut ways = kept_directions(svd.singular_values(), *rank, fades.then_some(damping));
        ways.retain(|(kept, share)| kept == rank || self.weight * share > NEGLIGIBLE);
        ways.into_iter().map(|(kept, share)| self.keeping(&projected, kept, share)).collect()
    }
}

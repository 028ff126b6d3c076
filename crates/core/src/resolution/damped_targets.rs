//! The velocities that damping leaves of the tasks, without limits.

use std::ops::Range;

use super::engine::Engine;
use super::level::{Hierarchy, Solution, refill};
use super::problem::Problem;
use crate::linalg::row_times;

/// Damps one task after the other; each one starts from the point of the one before.
#[derive(Default)]
pub struct DampedTargets {
    /// Whether all problems since [`Self::clear`] were solved to optimality, and their largest residual.
    pub is_optimal: bool,
    pub kkt_residual: f64,
    point: Vec<f64>,
    problem: Hierarchy,
    solution: Solution,
}

impl DampedTargets {
    /// Forgets how sure earlier answers were.
    pub fn clear(&mut self) {
        (self.is_optimal, self.kkt_residual) = (true, 0.0);
    }

    /// Sets the point x from which damping counts.
    pub fn start(&mut self, point: impl Iterator<Item = f64>) {
        refill(&mut self.point, point);
    }

    /// Solves min ‖J q̇ − ẋ‖² + factor² ‖q̇ − x‖² for the rows of `tasks` without changing the targets of the tasks `kept`, sets
    /// the targets of `tasks` to J q̇ and x to q̇. Inequality tasks take no part.
    pub fn lower(
        &mut self,
        problem: &Problem,
        kept: Range<usize>,
        tasks: Range<usize>,
        factor: f64,
        targets: &mut [f64],
        engine: &mut Engine,
    ) {
        let Self { point, problem: levels, solution, .. } = self;
        levels.clear(point);
        for k in kept {
            push_targets(problem, k, targets, levels);
            levels.end_level();
        }
        for k in tasks.clone() {
            push_targets(problem, k, targets, levels);
        }
        if factor > 0.0 {
            for (i, &x) in point.iter().enumerate() {
                let row = (0..point.len()).map(|j| if i == j { factor } else { 0.0 });
                levels.push_row(row, factor * x, factor * x);
            }
        }
        levels.end_level();
        engine.solve(levels, None, solution);
        self.is_optimal &= solution.is_optimal;
        self.kkt_residual = self.kkt_residual.max(solution.kkt_residual);
        refill(point, solution.x.iter().copied());
        for task in tasks.map(|k| (&problem.tasks.tasks()[k], problem.tasks.first_row(k))) {
            let (task, first) = task;
            for row in (0..task.jacobian.nrows()).filter(|_| task.is_equation()) {
                targets[first + row] = row_times(&task.jacobian, row, point);
            }
        }
    }
}

/// Adds the rows of an equation task at their targets.
fn push_targets(problem: &Problem, k: usize, targets: &[f64], levels: &mut Hierarchy) {
    let (task, first) = (&problem.tasks.tasks()[k], problem.tasks.first_row(k));
    if task.is_equation() {
        for row in 0..task.jacobian.nrows() {
            levels.push_matrix_row(&task.jacobian, row, targets[first + row], targets[first + row]);
        }
    }
}

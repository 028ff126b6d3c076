//! The velocity that damping leaves of one task after the other, without limits.

use revprio_problem::{Damping, Problem};

use super::engine::Engine;
use super::hierarchy::Hierarchy;
use super::solution::{Certainty, Solution, Start, refill};
use crate::linalg::{DampingFactor, Svd, row_times};
use crate::tolerances::TOLERANCES;

/// Damps the tasks of the stages of reverse priority, and all rows as one level.
#[derive(Default)]
pub struct DampedTargets {
    /// Whether all problems since [`Self::clear`] were solved to optimality, and their largest residual. Their working sets and
    /// ranks do not count.
    pub certainty: Certainty,
    point: Vec<f64>,
    problem: Hierarchy,
    solution: Solution,
    svd: Svd,
}

impl DampedTargets {
    /// Forgets how sure earlier answers were.
    pub fn clear(&mut self) {
        self.certainty = Certainty::default();
    }

    /// Solves min ‖J q̇ − ẋ‖² + factor² ‖q̇ − q̇'‖² for the rows of `tasks` and sets their targets to J q̇. Inequality tasks take
    /// no part.
    pub fn lower(
        &mut self,
        problem: &Problem,
        tasks: std::ops::Range<usize>,
        factor: f64,
        before: &[f64],
        targets: &mut [f64],
        engine: &mut Engine,
    ) {
        self.problem.clear(before);
        for k in tasks.clone().filter(|&k| problem.tasks.tasks()[k].is_equation()) {
            let (task, first) = (&problem.tasks.tasks()[k], problem.tasks.first_row(k));
            self.problem.push_equations(&task.jacobian, |row| targets[first + row]);
        }
        end_damped_level(&mut self.problem, factor, before);
        self.solve(engine);
        refill(&mut self.point, self.solution.x.iter().copied());
        for k in tasks.filter(|&k| problem.tasks.tasks()[k].is_equation()) {
            let (task, first) = (&problem.tasks.tasks()[k], problem.tasks.first_row(k));
            for row in 0..task.jacobian.nrows() {
                targets[first + row] = row_times(&task.jacobian, row, &self.point);
            }
        }
    }

    /// Moves the targets of task k, right after [`Self::lower`], along the directions of its weak singular values: the smaller
    /// one is, the more its direction does what the lower tasks do with it where it is free. `factor` damps the lower tasks.
    pub fn fade(
        &mut self,
        problem: &Problem,
        k: usize,
        (damping, factor): (Damping, f64),
        before: &[f64],
        targets: &mut [f64],
        engine: &mut Engine,
    ) {
        let (task, first) = (&problem.tasks.tasks()[k], problem.tasks.first_row(k));
        let (m, n) = task.jacobian.shape();
        self.svd.decompose(m, n, |i, j| task.jacobian[(i, j)]);
        let rank = self.svd.rank(TOLERANCES.rank * task.jacobian.norm());
        let weak = (0..rank).rev().take_while(|&place| damping.keeps(self.svd.sigma(place)) < 1.0).count();
        for kept in (rank - weak..rank).rev() {
            let next = if kept == 0 { 1.0 } else { damping.keeps(self.svd.sigma(kept - 1)) };
            let weight = next - damping.keeps(self.svd.sigma(kept));
            self.write_released(problem, k, kept, factor, before);
            self.solve(engine);
            for (row, target) in targets[first..first + m].iter_mut().enumerate() {
                let released = row_times(&task.jacobian, row, &self.solution.x);
                *target += weight * (released - row_times(&task.jacobian, row, &self.point));
            }
        }
    }

    /// Writes the stage of task k that keeps the directions of its `kept` largest singular values alone.
    fn write_released(&mut self, problem: &Problem, k: usize, kept: usize, factor: f64, before: &[f64]) {
        let Self { problem: levels, svd, point, .. } = self;
        levels.clear(before);
        for place in 0..kept {
            let reached = svd.right(place).zip(point.iter()).map(|(a, x)| a * x).sum();
            levels.push_equation(svd.right(place), reached);
        }
        levels.end_level();
        for task in problem.tasks.tasks()[k + 1..].iter().filter(|task| task.is_equation()) {
            levels.push_equations(&task.jacobian, |row| row_times(&task.jacobian, row, before));
        }
        end_damped_level(levels, factor, before);
    }

    fn solve(&mut self, engine: &mut Engine) {
        engine.solve(&self.problem, Start::default(), &mut self.solution);
        self.certainty.add(&Certainty { rank_uncertain: false, working_sets: 0, ..self.solution.certainty });
    }
}

/// Adds the rows factor q̇ = factor q̇', and ends the level.
fn end_damped_level(levels: &mut Hierarchy, factor: f64, before: &[f64]) {
    if factor > 0.0 {
        levels.push_near(factor, before);
    }
    levels.end_level();
}

//! The velocities that damping leaves of the tasks of the strict hierarchy, without limits.
//!
//! Task k moves q̇ by Z (J_k Z)^# (ẋ_k − J_k q̇), where the columns of Z are an orthonormal basis of what the higher tasks leave, so
//! that Z Zᵀ is their null-space projector N. Where J_k Z has a weak singular value, the result is an average of two: lower tasks may
//! use its direction, or not.

use revprio_problem::{Damping, Problem, Task};

use super::solution::refill;
use crate::linalg::{DampingFactor, Svd, add_scaled, dot, reflect_row, row_times};
use crate::tolerances::TOLERANCES;

const MAX_CHAINS: usize = 64;

/// One choice of directions that higher tasks keep from lower ones.
#[derive(Default)]
struct Chain {
    weight: f64,
    /// q̇ of the tasks so far.
    point: Vec<f64>,
    /// An orthonormal basis as columns, n × n by rows: first the directions that the tasks so far keep, then Z. Empty while nothing is
    /// kept: then Z = I.
    basis: Vec<f64>,
    /// The number of directions that are kept.
    kept: usize,
    /// The smallest singular value that is kept, relative to its task.
    weakest: f64,
}

/// Computes the damped velocities.
#[derive(Default)]
pub struct StrictTargets {
    chains: Vec<Chain>,
    spare: Vec<Chain>,
    /// J_k Z.
    rows: Vec<f64>,
    svd: Svd,
    /// The change of q̇ by a task, as coordinates in Z.
    delta: Vec<f64>,
    /// Directions to keep, and the basis below them.
    turned: Vec<f64>,
    point: Vec<f64>,
    residual: Vec<f64>,
    /// Whether a task is damped.
    acts: bool,
}

impl StrictTargets {
    /// Sets the targets of the tasks to what damping leaves of them, if it acts; returns the largest relative residual of the optimality
    /// conditions. Inequality tasks take no part.
    pub fn lower(&mut self, problem: &Problem, damping: Damping, zeta: &[f64], targets: &mut [f64]) -> f64 {
        let tasks = problem.tasks.tasks();
        let n = zeta.len();
        let is_at_rest = zeta.iter().all(|&entry| entry == 0.0);
        let lowest = tasks.iter().rposition(Task::is_equation);
        self.acts = false;
        self.spare.append(&mut self.chains);
        let mut first = self.spare.pop().unwrap_or_default();
        (first.weight, first.weakest) = (1.0, 1.0);
        refill(&mut first.point, std::iter::repeat_n(0.0, n));
        first.basis.clear();
        first.kept = 0;
        self.chains.push(first);
        let mut kkt_residual = 0.0_f64;
        for (k, task) in tasks.iter().enumerate().filter(|(_, task)| task.is_equation()) {
            let target = &targets[problem.tasks.first_row(k)..][..task.jacobian.nrows()];
            // Nothing uses what the lowest task leaves but the null-space velocity.
            let fades = lowest != Some(k) || !is_at_rest;
            for place in 0..self.chains.len() {
                let mut chain = std::mem::take(&mut self.chains[place]);
                kkt_residual = kkt_residual.max(self.add_task(&mut chain, task, target, damping, fades));
                self.chains[place] = chain;
            }
        }
        if !self.acts {
            return 0.0;
        }
        refill(&mut self.point, std::iter::repeat_n(0.0, n));
        for Chain { weight, point, basis, kept, .. } in &self.chains {
            for (x, (y, zeta)) in self.point.iter_mut().zip(point.iter().zip(zeta)) {
                *x += weight * (y + zeta);
            }
            refill(&mut self.delta, std::iter::repeat_n(0.0, *kept));
            for (row, zeta) in basis.chunks_exact(n).zip(zeta) {
                add_scaled(&mut self.delta, weight * zeta, row);
            }
            for (x, row) in self.point.iter_mut().zip(basis.chunks_exact(n)) {
                *x -= dot(&self.delta, &row[..*kept]);
            }
        }
        aim_at(problem, &self.point, targets);
        kkt_residual
    }

    /// Adds a task to a chain and starts the chains without its weak directions; returns the residual.
    fn add_task(&mut self, chain: &mut Chain, task: &Task, target: &[f64], damping: Damping, fades: bool) -> f64 {
        let (m, n) = task.jacobian.shape();
        let norm = task.jacobian.norm();
        let open = n - chain.kept;
        self.project(task, chain);
        let rows = &self.rows;
        let least = TOLERANCES.rank.max(TOLERANCES.reflection_error / chain.weakest) * norm;
        // Rows that depend on the tasks above have no singular value to look for.
        let depends = length(rows) <= least;
        self.svd.decompose(if depends { 0 } else { m }, open, |i, j| rows[i * open + j]);
        let rank = self.svd.rank(least);
        let lambda = damping.factor(self.svd.smallest());
        self.acts |= lambda > 0.0;
        let kkt_residual = self.step(chain, task, target, rank, lambda);
        let keeps = |svd: &Svd, place: usize| damping.keeps(svd.sigma(place));
        let weak = (0..rank).rev().take_while(|&place| fades && keeps(&self.svd, place) < 1.0).count();
        let total = chain.weight;
        for kept in (rank - weak..rank).rev() {
            let next = if kept == 0 { 1.0 } else { keeps(&self.svd, kept - 1) };
            let weight = total * (next - keeps(&self.svd, kept));
            if weight > TOLERANCES.chain_weight && self.chains.len() < MAX_CHAINS {
                let mut other = self.spare.pop().unwrap_or_default();
                (other.weight, other.weakest, other.kept) = (weight, chain.weakest, chain.kept);
                other.point.clone_from(&chain.point);
                other.basis.clone_from(&chain.basis);
                self.keep(&mut other, kept, norm);
                self.chains.push(other);
                chain.weight -= weight;
            }
        }
        if fades {
            self.keep(chain, rank, norm);
        }
        kkt_residual
    }

    /// Writes J_k Z.
    fn project(&mut self, task: &Task, chain: &Chain) {
        let (m, n) = task.jacobian.shape();
        self.rows.clear();
        if chain.basis.is_empty() {
            self.rows.extend((0..m).flat_map(|row| (0..n).map(move |j| task.jacobian[(row, j)])));
            return;
        }
        let open = n - chain.kept;
        for row in 0..m {
            let start = self.rows.len();
            self.rows.resize(start + open, 0.0);
            for (j, basis) in chain.basis.chunks_exact(n).enumerate() {
                add_scaled(&mut self.rows[start..], task.jacobian[(row, j)], &basis[chain.kept..]);
            }
        }
    }

    /// Moves the point by Z (J_k Z)^# (ẋ_k − J_k q̇); returns the relative residual of min ‖J_k Z δ − e‖² + λ² ‖δ‖².
    fn step(&mut self, chain: &mut Chain, task: &Task, target: &[f64], rank: usize, lambda: f64) -> f64 {
        let n = chain.point.len();
        let open = n - chain.kept;
        let Self { rows, svd, residual, delta, .. } = self;
        let missing = |point: &[f64], row: usize| target[row] - row_times(&task.jacobian, row, point);
        refill(residual, (0..target.len()).map(|row| missing(&chain.point, row)));
        refill(delta, std::iter::repeat_n(0.0, open));
        for place in 0..rank {
            let sigma = svd.sigma(place);
            let asked: f64 = svd.left(place).zip(residual.iter()).map(|(a, b)| a * b).sum();
            let part = sigma / (sigma * sigma + lambda * lambda) * asked;
            delta.iter_mut().zip(svd.right(place)).for_each(|(x, entry)| *x += part * entry);
        }
        if chain.basis.is_empty() {
            add_scaled(&mut chain.point, 1.0, delta);
        } else {
            let rows = chain.basis.chunks_exact(n);
            chain.point.iter_mut().zip(rows).for_each(|(x, row)| *x += dot(&row[chain.kept..], delta));
        }
        refill(residual, (0..target.len()).map(|row| missing(&chain.point, row)));
        let gradient = |j: usize| {
            let reached: f64 = residual.iter().enumerate().map(|(row, missing)| rows[row * open + j] * missing).sum();
            (reached - lambda * lambda * delta[j]).abs()
        };
        let largest = (0..open).map(gradient).fold(0.0, f64::max);
        let norm = task.jacobian.norm() + lambda;
        let size = norm * (norm * (length(&chain.point) + length(delta)) + length(target));
        if largest == 0.0 { 0.0 } else { largest / size.max(f64::MIN_POSITIVE) }
    }

    /// Keeps the first `count` right singular vectors of a task with this norm: reflections turn the basis until they are its next
    /// directions.
    fn keep(&mut self, chain: &mut Chain, count: usize, norm: f64) {
        if count == 0 {
            return;
        }
        let Self { svd, turned, .. } = self;
        let n = chain.point.len();
        turned.clear();
        for place in 0..count {
            turned.extend(std::iter::repeat_n(0.0, chain.kept).chain(svd.right(place)));
        }
        if chain.basis.is_empty() {
            turned.extend((0..n * n).map(|at| if at % n == at / n { 1.0 } else { 0.0 }));
        } else {
            turned.extend_from_slice(&chain.basis);
        }
        for place in 0..count {
            let (above, below) = turned.split_at_mut((place + 1) * n);
            reflect_row(&mut above[place * n + chain.kept + place..], below, n);
        }
        refill(&mut chain.basis, turned[count * n..].iter().copied());
        chain.kept += count;
        chain.weakest = chain.weakest.min(svd.sigma(count - 1) / norm);
    }
}

/// Sets the targets of the equation tasks to their velocities at q̇.
pub fn aim_at(problem: &Problem, velocity: &[f64], targets: &mut [f64]) {
    for (k, task) in problem.tasks.tasks().iter().enumerate().filter(|(_, task)| task.is_equation()) {
        for row in 0..task.jacobian.nrows() {
            targets[problem.tasks.first_row(k) + row] = row_times(&task.jacobian, row, velocity);
        }
    }
}

fn length(entries: &[f64]) -> f64 {
    dot(entries, entries).sqrt()
}

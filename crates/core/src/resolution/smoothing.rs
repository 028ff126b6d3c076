//! Makes damped answers continuous where limits are active.
//!
//! An exact hierarchy within limits jumps where what the limits leave of its levels loses rank. The damped answer is therefore
//! blended from solutions X_K, …, X_0 of the same problem: X_k keeps the first k levels exactly, and reaches for the levels
//! below as far as damping lets it. X_0 is the solution of strictly convex problems and always continuous. With s_k between 0
//! (what the limits leave of the first k levels is singular) and 1 (far from it),
//!
//! x^(0) = X_0,  x^(k) = x^(k−1) + s_k (X_k − x^(k−1)),  and the answer is x^(K).
//!
//! `docs/solver.md` proves that it is continuous. Every X_k is inside the limits, and so is the blend. Where s_K = 1 the answer
//! is X_K, the exact one, and nothing else is computed. Without an active bound X_K is x^f, the answer without limits.

use revprio_problem::{BoundId, Damping, Part};

use super::certified::Record;
use super::engine::Engine;
use super::hierarchy::{Hierarchy, Level};
use super::regularity::Regularity;
use super::relaxed_levels::RelaxedLevels;
use super::solution::Solution;

/// The workspace of the blend.
#[derive(Default)]
pub struct Smoothing {
    relaxed: RelaxedLevels,
    regularity: Regularity,
    parts: Vec<Solution>,
    weights: Vec<f64>,
    /// Indices of the recorded problems whose solutions are the parts.
    recorded: Vec<usize>,
}

impl Smoothing {
    /// Begins an answer, which may take several problems of a plan.
    pub fn clear(&mut self) {
        self.relaxed.clear();
    }

    /// Replaces the exact solution X_K of a planned problem by the blend, if damping acts on what its limits leave.
    pub fn apply(&mut self, levels: &Hierarchy, damping: Damping, engine: &mut Engine, solution: &mut Solution) {
        let is_hard = |level: &&Level| matches!(levels.rows[level.start].origin, Some(BoundId::Constraint { .. }));
        let hard = levels.levels.iter().take_while(is_hard).count();
        let is_pinned = levels.bounds().any(|(lower, upper)| lower == upper);
        let is_free = solution.working_set.is_empty() && !is_pinned;
        if is_free || damping.max_factor() == 0.0 {
            return;
        }
        let count = levels.levels.len();
        self.regularity.start(levels);
        let first_unmet = first_unmet_level(levels, solution);
        let is_unmet = first_unmet.is_some_and(|level| level + 1 < count);
        let mut weight = if is_unmet { 0.0 } else { self.regularity.of(levels, count, solution, damping.threshold()) };
        if weight == 1.0 {
            return;
        }
        let exact = engine.record.as_ref().map(Record::last);
        self.relaxed.start(levels, hard, engine, solution);
        self.weights.clear();
        self.parts.resize_with((count - hard + 1).max(self.parts.len()), Solution::default);
        self.parts[0].copy_from(solution);
        self.recorded.clear();
        self.recorded.extend(exact);
        let mut part = 0;
        let most = first_unmet.map_or(count, |level| self.most_kept(levels, level, damping)).max(hard);
        for kept in (hard..count.min(most + 1)).rev() {
            if kept > hard && !self.relaxed.has_time_for(levels, kept) {
                solution.certainty.is_optimal = false;
                continue;
            }
            self.weights.push(weight);
            part += 1;
            let found = &mut self.parts[part];
            self.relaxed.solve(levels, kept, damping, engine, found);
            self.recorded.extend(engine.record.as_ref().map(Record::last));
            weight = if kept == hard { 1.0 } else { self.regularity.of(levels, kept, found, damping.threshold()) };
            if weight == 1.0 {
                break;
            }
        }
        self.blend(part, levels, solution);
        if let Some(record) = &mut engine.record {
            record.set_answer(self.recorded_parts());
        }
    }

    /// Returns the largest k < K whose s_k may be above zero, where `unmet` is the first level that is not met. That level
    /// itself can be regular by columns only.
    fn most_kept(&mut self, levels: &Hierarchy, unmet: usize, damping: Damping) -> usize {
        let determines = self.regularity.column_regularity(levels, unmet + 1, damping.threshold()) > 0.0;
        unmet + usize::from(determines)
    }

    /// Returns the recorded parts of the blend, X_K first, with the weight that each has in the answer.
    fn recorded_parts(&self) -> Vec<Part> {
        let mut rest = 1.0;
        let weights = self.weights[..self.recorded.len() - 1].iter().chain([&1.0]);
        let part = |(&problem, weight): (&usize, &f64)| {
            let part = Part { problem, weight: rest * weight };
            rest *= 1.0 - weight;
            part
        };
        self.recorded.iter().zip(weights).map(part).collect()
    }

    /// Blends the parts from the last one, X_k with the fewest exact levels, to the first one, X_K.
    fn blend(&mut self, last: usize, levels: &Hierarchy, solution: &mut Solution) {
        solution.x.clone_from(&self.parts[last].x);
        for part in (0..last).rev() {
            let weight = self.weights[part];
            for (x, other) in solution.x.iter_mut().zip(&self.parts[part].x) {
                *x += weight * (other - *x);
            }
        }
        for part in self.parts[1..=last].iter().chain([&self.relaxed.free]) {
            solution.certainty.add(&part.certainty);
        }
        levels.settle(solution, &self.parts[last]);
    }
}

/// Returns the highest level that leaves a residual above rounding; `None` without one, or if it has damping rows.
fn first_unmet_level(levels: &Hierarchy, solution: &Solution) -> Option<usize> {
    let is_unmet = |level: &Level| levels.missing_rows(solution, level).next().is_some();
    let first = levels.levels.iter().position(is_unmet)?;
    levels.levels[first].rows().all(|row| levels.rows[row].origin.is_some()).then_some(first)
}

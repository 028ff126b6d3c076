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
use crate::linalg::dot;
use crate::tolerances::TOLERANCES;

/// The workspace of the blend.
#[derive(Default)]
pub struct Smoothing {
    relaxed: RelaxedLevels,
    regularity: Regularity,
    /// X_k.
    found: Solution,
    /// The point of the solution before.
    before: Vec<f64>,
}

impl Smoothing {
    /// Begins an answer, which may take several problems of a plan.
    pub fn clear(&mut self) {
        self.relaxed.clear();
    }

    /// Replaces the exact solution X_K of a planned problem by the blend, if damping acts on what its limits leave.
    pub fn apply(&mut self, levels: &Hierarchy, damping: Damping, engine: &mut Engine, solution: &mut Solution) {
        let first = levels.rows.first().and_then(|row| row.origin);
        let hard = usize::from(matches!(first, Some(BoundId::Constraint { .. })));
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
        let Self { relaxed, regularity, found, before } = self;
        let mut parts: Vec<Part> = Vec::new();
        let mut note = |weight: f64, record: Option<&Record>| {
            parts.extend(record.map(|record| Part { problem: record.last(), weight }));
        };
        note(weight, engine.record.as_ref());
        found.copy_from(solution);
        relaxed.start(levels, hard, engine, found);
        // What the solutions so far leave to the others.
        let mut rest = 1.0 - weight;
        let most = first_unmet.map_or(count, |level| most_kept(regularity, levels, level, damping)).max(hard);
        for kept in (hard..count.min(most + 1)).rev() {
            if kept > hard && !relaxed.has_time_for(levels, kept) {
                solution.certainty.is_optimal = false;
                continue;
            }
            before.clone_from(&found.x);
            relaxed.solve(levels, kept, damping, engine, found);
            // x^(K) = X_K + Σ rest_k (X_k − X_{k+1}): the same bits where these are the same.
            for (x, (after, before)) in solution.x.iter_mut().zip(found.x.iter().zip(&*before)) {
                *x += rest * (after - before);
            }
            weight = if kept == hard { 1.0 } else { regularity.of(levels, kept, found, damping.threshold()) };
            note(rest * weight, engine.record.as_ref());
            rest *= 1.0 - weight;
            solution.certainty.add(&found.certainty);
            if weight == 1.0 {
                break;
            }
        }
        solution.certainty.add(&relaxed.free.certainty);
        levels.settle(solution, found);
        if let Some(record) = &mut engine.record {
            record.set_answer(parts);
        }
    }
}

/// Returns the largest k < K whose s_k may be above zero, where `unmet` is the first level that is not met. That level itself
/// can be regular by columns only.
fn most_kept(regularity: &mut Regularity, levels: &Hierarchy, unmet: usize, damping: Damping) -> usize {
    unmet + usize::from(regularity.column_regularity(levels, unmet + 1, damping.threshold()) > 0.0)
}

/// Returns the highest level that leaves a residual above rounding; `None` without one, or if it has damping rows.
fn first_unmet_level(levels: &Hierarchy, solution: &Solution) -> Option<usize> {
    let missing = |row: usize| {
        let (value, demand) = (solution.row_values[row], &levels.rows[row]);
        (value - demand.upper).max(demand.lower - value)
    };
    let speed = dot(&solution.x, &solution.x).sqrt();
    let is_unmet = |level: &Level| {
        let most = level.rows().map(missing).fold(0.0, f64::max);
        most > TOLERANCES.proof_weight * levels.size(level, speed)
    };
    let first = levels.levels.iter().position(is_unmet)?;
    levels.levels[first].rows().all(|row| levels.rows[row].origin.is_some()).then_some(first)
}

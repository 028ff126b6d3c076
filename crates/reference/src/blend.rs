//! Damped answers within limits: a blend that is continuous where limits leave a level near a singularity.
//!
//! X_k keeps the first k levels exactly and reaches for the others as far as damping lets it; X_K is the exact answer. With
//! s_k between 0 (what the limits leave of the first k levels is singular) and 1 (far from it),
//!
//! x^(0) = X_0,  x^(k) = x^(k−1) + s_k (X_k − x^(k−1)),  and the answer is x^(K).
//!
//! `docs/solver.md`, section 9, has the definitions and the proof.
#![allow(non_snake_case)]

use revprio_problem::{BoundId, Damping, Matrix, Part, Vector};

use crate::damping::smoothstep;
use crate::hierarchy::{Hierarchy, Level, Solution};
use crate::polish::CERTAIN;
use crate::recorder::Recorder;
use crate::svd::Svd;

/// Half width for rows and joints that have one bound or none, rad/s or m/s.
const HALF_WIDTH: f64 = 1.0;

/// Half width of the widest box whose middle counts, rad/s: no joint of an arm is as fast.
const WIDEST: f64 = 10.0;

/// Distance from the bound of an unknown or a row, relative to ‖x‖ or ‖a‖‖x‖, up to which x reaches it.
const ROUNDING: f64 = 1e-13;

/// Weight of a level that has been reached for, relative to the level that is reached for next.
const KEPT: f64 = 60.0;

/// Weight of the highest task while it is reached for, relative to that of a lower task.
const FIRST: f64 = 2.0;

/// Replaces the exact solution X_K of a problem by the blend, if damping acts on what its limits leave.
pub fn blend(hierarchy: &Hierarchy, damping: Damping, recorder: &mut Recorder, solution: &mut Solution) {
    let count = hierarchy.levels.len();
    let is_pinned = (0..hierarchy.unknowns()).any(|j| hierarchy.is_pinned(j));
    if damping.max_factor() == 0.0 || !(solution.is_bounded() || is_pinned) {
        return;
    }
    let is_hard = |level: &&Level| matches!(level.names[0], Some(BoundId::Constraint { .. }));
    let hard = hierarchy.levels.iter().take_while(is_hard).count();
    let mut weight = regularity(hierarchy, count, &solution.x, damping.threshold());
    if weight == 1.0 {
        return;
    }
    let mut parts = vec![Averaged { problem: recorder.last(), solution: solution.clone(), weight }];
    let reach = Reach::new(hierarchy, hard, damping, recorder);
    for kept in (hard..count).rev() {
        let found = reach.answer(kept, recorder);
        weight = if kept == hard { 1.0 } else { regularity(hierarchy, kept, &found.x, damping.threshold()) };
        parts.push(Averaged { problem: recorder.last(), solution: found, weight });
        if weight == 1.0 {
            break;
        }
    }
    average(hierarchy, &parts, recorder, solution);
}

/// One X_k with its weight s_k.
struct Averaged {
    /// Index of its problem in the record.
    problem: usize,
    solution: Solution,
    weight: f64,
}

/// Averages the parts, X_K first. A part has its weight in what the parts before leave.
fn average(hierarchy: &Hierarchy, parts: &[Averaged], recorder: &mut Recorder, solution: &mut Solution) {
    let (mut rest, mut answer) = (1.0, Vec::new());
    for part in parts {
        answer.push(Part { problem: part.problem, weight: rest * part.weight });
        rest *= 1.0 - part.weight;
    }
    recorder.set_answer(answer);
    let Some((last, others)) = parts.split_last() else { return };
    let (mut x, mut error) = (last.solution.x.clone(), last.solution.error);
    // A bound that all parts reach is reached to the last bit.
    for part in others.iter().rev() {
        x += (&part.solution.x - &x) * part.weight;
        error += (part.solution.error - error) * part.weight;
    }
    // Large parts may cancel.
    recorder.is_unsure |= error > CERTAIN * x.norm();
    solution.x = hierarchy.clamp(&x);
    keep_reached(hierarchy, solution, &last.solution);
}

/// Keeps the multipliers of the bounds that x reaches, those of `other` where the solution has none. A bound that the average does
/// not reach holds nothing back.
fn keep_reached(hierarchy: &Hierarchy, solution: &mut Solution, other: &Solution) {
    let rounding = ROUNDING * solution.x.norm();
    let reaches = |multiplier: f64, value: f64, lower: f64, upper: f64, length: f64| {
        let near = rounding * length;
        if multiplier < 0.0 { value <= lower + near } else { multiplier > 0.0 && value >= upper - near }
    };
    for (j, multiplier) in solution.multipliers.iter_mut().enumerate() {
        let reaches = |it: &f64| reaches(*it, solution.x[j], hierarchy.lower[j], hierarchy.upper[j], 1.0);
        *multiplier = [*multiplier, other.multipliers[j]].into_iter().find(reaches).unwrap_or(0.0);
    }
    for (level, multipliers) in hierarchy.levels.iter().zip(&mut solution.row_multipliers) {
        for (row, multiplier) in multipliers.iter_mut().enumerate() {
            let (value, length) = (level.value(row, &solution.x), level.rows.row(row).norm());
            if !reaches(*multiplier, value, level.lower[row], level.upper[row], length) {
                *multiplier = 0.0;
            }
        }
    }
}

/// Returns s_k for the first `kept` levels at x: from their rows, or from the columns of a level that determines every unknown.
fn regularity(hierarchy: &Hierarchy, kept: usize, x: &Vector, threshold: f64) -> f64 {
    let by_rows = |levels: &[Level]| smoothstep(row_regularity(hierarchy, levels, x) / threshold);
    let levels = &hierarchy.levels[..kept];
    let independent = by_rows(levels);
    let rows: usize = levels.iter().map(|level| level.rows.nrows()).sum();
    if independent == 1.0 || rows < hierarchy.unknowns() {
        return independent;
    }
    let equations = levels.iter().flat_map(|level| {
        (0..level.rows.nrows()).filter(|&row| level.is_equation(row)).map(|row| level.rows.row(row).into_owned())
    });
    let equations: Vec<_> = equations.collect();
    let columns =
        if equations.is_empty() { Matrix::zeros(0, hierarchy.unknowns()) } else { Matrix::from_rows(&equations) };
    let smallest = if equations.len() < hierarchy.unknowns() { 0.0 } else { Svd::new(&columns).smallest() };
    let above = if kept == 1 { 1.0 } else { by_rows(&levels[..kept - 1]) };
    independent.max(smoothstep(smallest / threshold) * above)
}

/// Returns σ_min of M = [A C, diag(c)] with C the room of the unknowns and c that of the rows, 0 for equations. Damping rows do
/// not count.
fn row_regularity(hierarchy: &Hierarchy, levels: &[Level], x: &Vector) -> f64 {
    let n = hierarchy.unknowns();
    let is_auxiliary = |level: &Level, row: usize| level.names[row].is_none();
    let rows: Vec<(&Level, usize)> = levels
        .iter()
        .flat_map(|level| (0..level.rows.nrows()).map(move |row| (level, row)))
        .filter(|(level, row)| !is_auxiliary(level, *row))
        .collect();
    let mut M = Matrix::zeros(rows.len(), n + rows.len());
    for (i, (level, row)) in rows.iter().enumerate() {
        for j in 0..n {
            M[(i, j)] = level.rows[(*row, j)] * room(x[j], hierarchy.lower[j], hierarchy.upper[j]);
        }
        M[(i, n + i)] = room(level.value(*row, x), level.lower[*row], level.upper[*row]);
    }
    // Without rows nothing is singular.
    if rows.is_empty() { f64::INFINITY } else { Svd::new(&M).smallest() }
}

/// Returns the distance to the nearer bound, relative to half the width between the bounds, at most [`WIDEST`], and at most 1.
fn room(value: f64, lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    let half_width = if half_width.is_finite() { half_width.min(WIDEST) } else { HALF_WIDTH };
    let distance = (value - lower).min(upper - value).max(0.0);
    if distance == 0.0 { 0.0 } else { (distance / half_width).min(1.0) }
}

/// What the answers X_k share.
struct Reach<'a> {
    hierarchy: &'a Hierarchy,
    /// Number of levels of hard inequalities above the tasks.
    hard: usize,
    /// x^f, the answer without limits and inequality rows.
    free: Vector,
    /// τ: how much of the way from the middle of the box to x^f is in the box.
    tau: f64,
    /// x^s.
    start: Vector,
    /// w = 1 + 1/λ_max.
    weight: f64,
}

impl<'a> Reach<'a> {
    fn new(hierarchy: &'a Hierarchy, hard: usize, damping: Damping, recorder: &mut Recorder) -> Self {
        let mut unlimited = Hierarchy::new(hierarchy.reference.clone());
        for level in &hierarchy.levels {
            let rows: Vec<usize> = (0..level.rows.nrows()).filter(|&row| level.is_equation(row)).collect();
            let targets: Vec<f64> = rows.iter().map(|&row| level.lower[row]).collect();
            let mut equations = Level::new(hierarchy.unknowns());
            equations.push(&level.rows.select_rows(&rows), &targets, &targets, |_| None);
            unlimited.push(equations);
        }
        let free = recorder.solve(&unlimited).x;
        let mut tau = 1.0_f64;
        for j in 0..free.len() {
            let middle = middle(hierarchy.lower[j], hierarchy.upper[j]);
            let width = if free[j] > middle { hierarchy.upper[j] - middle } else { middle - hierarchy.lower[j] };
            let distance = (free[j] - middle).abs();
            // A pinned joint has no way inside the box.
            if distance > width && width > 0.0 {
                tau = tau.min(width / distance);
            }
        }
        let start = Vector::from_fn(free.len(), |j, _| {
            let middle = middle(hierarchy.lower[j], hierarchy.upper[j]);
            middle + tau * (free[j] - middle)
        });
        let start = hierarchy.clamp(&start);
        Self { hierarchy, hard, free, tau, start, weight: 1.0 + 1.0 / damping.max_factor() }
    }

    /// Computes X_k, k = `kept`.
    fn answer(&self, kept: usize, recorder: &mut Recorder) -> Solution {
        let mut found = Solution::new(self.hierarchy, self.start.clone());
        for reached in kept..self.hierarchy.levels.len() {
            let before = found.error;
            found = recorder.solve(&self.problem(kept, reached, &found.x));
            found.error += before;
        }
        found
    }

    /// Poses the problem that reaches for one level: the first `kept` levels, then a level of rows that reach for it, rows that
    /// keep what the levels between have achieved, and the distance from the point before.
    fn problem(&self, kept: usize, reached: usize, near: &Vector) -> Hierarchy {
        let n = near.len();
        let mut problem = Hierarchy::new(near.clone());
        (problem.lower, problem.upper) = (self.hierarchy.lower.clone(), self.hierarchy.upper.clone());
        let mut levels = self.hierarchy.levels.iter().enumerate();
        levels.by_ref().take(kept).for_each(|(_, level)| problem.push(level.clone()));
        let mut reaching = Level::new(n);
        for (index, level) in self.hierarchy.levels.iter().enumerate().take(reached + 1).skip(kept) {
            if index < reached {
                push_weighted(&mut reaching, level, KEPT * self.weight, near, 1.0);
            } else {
                let first = if index == self.hard { FIRST } else { 1.0 };
                push_weighted(&mut reaching, level, first * self.weight, &self.free, self.tau);
            }
        }
        reaching.push(&Matrix::identity(n, n), near.as_slice(), near.as_slice(), |_| None);
        problem.push(reaching);
        problem
    }
}

/// Adds the rows of a level with a weight. Equations aim at b + τ (a·point − b); bounds that the point violates are moved by the
/// part τ of the violation.
fn push_weighted(reaching: &mut Level, level: &Level, weight: f64, point: &Vector, tau: f64) {
    let bound = |row: usize, bound: f64, is_lower: bool| {
        let beyond = level.value(row, point) - bound;
        let counted = match is_lower {
            _ if level.is_equation(row) => beyond,
            true => beyond.min(0.0),
            false => beyond.max(0.0),
        };
        weight * (bound + tau * counted)
    };
    let rows = 0..level.rows.nrows();
    let lower: Vec<f64> = rows.clone().map(|row| bound(row, level.lower[row], true)).collect();
    let upper: Vec<f64> =
        rows.map(|row| if level.is_equation(row) { lower[row] } else { bound(row, level.upper[row], false) }).collect();
    reaching.push(&(&level.rows * weight), &lower, &upper, |_| None);
}

/// Returns the middle between two bounds. Bounds farther apart mean none: the speed next to zero that is [`WIDEST`] inside, and
/// with one bound or none, the one that is [`HALF_WIDTH`] inside.
fn middle(lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    if half_width <= WIDEST {
        return 0.5 * (lower + upper);
    }
    let inside = if half_width.is_finite() { WIDEST } else { HALF_WIDTH };
    0.0_f64.max(lower + inside).min(upper - inside)
}

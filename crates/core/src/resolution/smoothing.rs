//! Makes damped answers continuous where limits are active.
//!
//! An exact hierarchy within limits jumps where what the limits leave of its levels loses rank. The damped answer is therefore
//! blended from solutions X_K, …, X_0 of the same problem: X_k keeps the first k levels exactly, and below them it stays
//! near the answer x^f without limits, in a metric that weighs each level more than the next one. X_0 is the solution of one
//! strictly convex problem and always continuous. With s_k between 0 (what the limits leave of the first k levels is
//! singular) and 1 (far from it),
//!
//! x^(0) = X_0,  x^(k) = x^(k−1) + s_k (X_k − x^(k−1)),  and the answer is x^(K).
//!
//! `docs/solver.md` proves that it is continuous. Every X_k is inside the limits, and so is the blend. Where s_K = 1 the answer
//! is X_K, the exact one, and nothing else is computed. Without an active bound X_K is x^f.

use super::engine::Engine;
use super::level::{Hierarchy, Solution, refill};
use super::plan::{Origin, PlannedProblem};
use crate::linalg::{Damping, Matrix, write_singular_values};

/// Fraction of half the width between two bounds within which a bound counts as near.
const NEAR: f64 = 0.1;

/// Half width for rows and joints that have one bound or none, in units of joint speed: rad/s or m/s.
const HALF_WIDTH: f64 = 1.0;

/// Matrices above this size get their eigenvalues from nalgebra, which allocates.
const MAX_JACOBI_SIZE: usize = 32;

/// The workspace of the blend.
#[derive(Default)]
pub struct Smoothing {
    /// The problem without limits, then the problems of X_k.
    problem: Hierarchy,
    free: Solution,
    parts: Vec<Solution>,
    weights: Vec<f64>,
    room: Vec<f64>,
    row_room: Vec<f64>,
    gram: Vec<f64>,
    factor: Vec<f64>,
    sigma: Vec<f64>,
    /// Rows of tasks and inequalities, without damping rows.
    counted: Vec<usize>,
}

impl Smoothing {
    /// Replaces the exact solution X_K of a planned problem by the blend, if damping acts on what its limits leave.
    pub fn apply(&mut self, planned: &PlannedProblem, damping: Damping, engine: &mut Engine, solution: &mut Solution) {
        let levels = &planned.levels;
        let hard = usize::from(planned.origins.first().is_some_and(|origin| matches!(origin, Origin::Inequality(_))));
        let is_scaled = planned.scale_unknowns.iter().any(Option::is_some);
        let is_pinned = levels.lower.iter().zip(&levels.upper).any(|(lower, upper)| lower == upper);
        let is_free = solution.working_set.is_empty() && !is_pinned;
        if is_free || is_scaled || damping.max_factor() == 0.0 {
            return;
        }
        let count = levels.level_ends.len();
        let counted = (0..levels.row_count()).filter(|&row| planned.origins[row] != Origin::Auxiliary);
        refill(&mut self.counted, counted);
        let mut weight = self.regularity(levels, count, solution, damping.threshold());
        if weight == 1.0 {
            return;
        }
        self.solve_without_limits(planned, engine);
        self.weights.clear();
        self.parts.resize_with((count - hard + 1).max(self.parts.len()), Solution::default);
        self.parts[0].copy_from(solution);
        let mut part = 0;
        for kept in (hard..count).rev() {
            self.weights.push(weight);
            part += 1;
            self.write_part(levels, kept, damping);
            let mut found = std::mem::take(&mut self.parts[part]);
            engine.solve(&self.problem, None, &mut found);
            weight = if kept == hard { 1.0 } else { self.regularity(levels, kept, &found, damping.threshold()) };
            self.parts[part] = found;
            if weight == 1.0 {
                break;
            }
        }
        self.blend(part, levels, solution);
    }

    /// Solves the problem without limits and without inequality rows.
    fn solve_without_limits(&mut self, planned: &PlannedProblem, engine: &mut Engine) {
        let levels = &planned.levels;
        let problem = &mut self.problem;
        problem.clear(&levels.reference);
        for level in 0..levels.level_ends.len() {
            for row in (levels.level_start(level)..levels.level_ends[level]).filter(|&row| levels.is_equation(row)) {
                problem.push_row(levels.row(row).iter().copied(), levels.row_lower[row], levels.row_upper[row]);
            }
            problem.end_level();
        }
        engine.solve(problem, None, &mut self.free);
    }

    /// Writes the problem of X_k: the first `kept` levels, then one level that stays near x^f.
    ///
    /// Level j has the weight (1 + 1/λ_max)^(K − j + 1) there, and the distance from x^f itself the weight 1.
    fn write_part(&mut self, levels: &Hierarchy, kept: usize, damping: Damping) {
        let Self { problem, free, .. } = self;
        problem.clear(&free.x);
        problem.lower.copy_from_slice(&levels.lower);
        problem.upper.copy_from_slice(&levels.upper);
        let ratio = 1.0 + 1.0 / damping.max_factor();
        let mut weight = 1.0;
        let count = levels.level_ends.len();
        for level in 0..count {
            let is_kept = level < kept;
            if !is_kept {
                let below = i32::try_from(count - level).unwrap_or(i32::MAX);
                weight = ratio.powi(below);
            }
            for row in levels.level_start(level)..levels.level_ends[level] {
                let coefficients = levels.row(row);
                let (lower, upper) = (levels.row_lower[row], levels.row_upper[row]);
                if is_kept {
                    problem.push_row(coefficients.iter().copied(), lower, upper);
                    continue;
                }
                let achieved: f64 = coefficients.iter().zip(&free.x).map(|(a, x)| a * x).sum();
                let (lower, upper) =
                    if lower == upper { (achieved, achieved) } else { (lower.min(achieved), upper.max(achieved)) };
                problem.push_row(coefficients.iter().map(|a| weight * a), weight * lower, weight * upper);
            }
            if is_kept {
                problem.end_level();
            }
        }
        let n = free.x.len();
        for (i, &x) in free.x.iter().enumerate() {
            problem.push_row((0..n).map(|j| if i == j { 1.0 } else { 0.0 }), x, x);
        }
        problem.end_level();
    }

    /// Returns s for the first `kept` levels at a solution, from 0 (singular) to 1 (singular values above the threshold).
    ///
    /// The rows count as regular if they are independent on what the bounds leave, or if the last level determines every
    /// unknown and the rows above it are independent on what the bounds leave.
    fn regularity(&mut self, levels: &Hierarchy, kept: usize, solution: &Solution, threshold: f64) -> f64 {
        self.measure_room(levels, solution);
        let end = levels.level_ends[kept - 1];
        let independent = self.row_regularity(levels, end, threshold);
        let start = levels.level_start(kept - 1);
        if independent == 1.0 || end < levels.unknowns {
            return independent;
        }
        let determined = self.column_regularity(levels, end, threshold);
        let above = if start == 0 { 1.0 } else { self.row_regularity(levels, start, threshold) };
        independent.max(determined * above)
    }

    /// Measures how much room each unknown and each inequality row has to its nearer bound: 0 at the bound, 1 far from it.
    fn measure_room(&mut self, levels: &Hierarchy, solution: &Solution) {
        let bounds = levels.lower.iter().zip(&levels.upper);
        refill(&mut self.room, solution.x.iter().zip(bounds).map(|(&x, (&lower, &upper))| room(x, lower, upper)));
        let rows = (0..levels.row_count())
            .map(|row| room(solution.row_values[row], levels.row_lower[row], levels.row_upper[row]));
        refill(&mut self.row_room, rows);
    }

    /// Returns the regularity of the first `end` rows: from the smallest singular value of [A C, diag(c)], with C the room of
    /// the unknowns and c that of the rows, 0 for equations.
    fn row_regularity(&mut self, levels: &Hierarchy, end: usize, threshold: f64) -> f64 {
        let Self { room, row_room, gram, counted, .. } = self;
        let rows = counted.partition_point(|&row| row < end);
        if counted[..rows].iter().filter(|&&row| row_room[row] == 0.0).count() > levels.unknowns {
            return 0.0;
        }
        gram.clear();
        for &i in &counted[..rows] {
            for &j in &counted[..rows] {
                let product = levels.row(i).iter().zip(levels.row(j)).zip(room.iter());
                let sum: f64 = product.map(|((a, b), c)| a * b * c * c).sum();
                gram.push(sum + if i == j { row_room[i] * row_room[i] } else { 0.0 });
            }
        }
        self.regularity_of_gram(rows, threshold)
    }

    /// Returns the regularity of the columns of the first `end` rows.
    fn column_regularity(&mut self, levels: &Hierarchy, end: usize, threshold: f64) -> f64 {
        let n = levels.unknowns;
        refill(&mut self.gram, std::iter::repeat_n(0.0, n * n));
        for row in (0..end).filter(|&row| levels.is_equation(row)).map(|row| levels.row(row)) {
            for i in 0..n {
                for j in 0..n {
                    self.gram[i * n + j] += row[i] * row[j];
                }
            }
        }
        self.regularity_of_gram(n, threshold)
    }

    /// Returns smoothstep(σ_min/threshold) of a matrix from its Gram matrix, of `size` rows.
    fn regularity_of_gram(&mut self, size: usize, threshold: f64) -> f64 {
        let Self { gram, factor, sigma, .. } = self;
        factor.clone_from(gram);
        if exceeds(factor, size, threshold * threshold) {
            return 1.0;
        }
        let smallest = if size > MAX_JACOBI_SIZE {
            Matrix::from_row_slice(size, size, gram).symmetric_eigenvalues().min()
        } else {
            write_singular_values(gram, size, sigma);
            sigma.last().copied().unwrap_or(0.0)
        };
        let smallest = smallest.max(0.0).sqrt();
        let ratio = (smallest / threshold).min(1.0);
        ratio * ratio * (3.0 - 2.0 * ratio)
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
        for part in self.parts[1..=last].iter().chain([&self.free]) {
            solution.is_optimal &= part.is_optimal;
            solution.kkt_residual = solution.kkt_residual.max(part.kkt_residual);
            solution.working_sets += part.working_sets;
            solution.rank_uncertain |= part.rank_uncertain;
        }
        for (x, (lower, upper)) in solution.x.iter_mut().zip(levels.lower.iter().zip(&levels.upper)) {
            // Not a number stays one: the answer is then refused.
            *x = if *x < *lower {
                *lower
            } else if *x > *upper {
                *upper
            } else {
                *x
            };
        }
        for row in 0..levels.row_count() {
            solution.row_values[row] = levels.row(row).iter().zip(&solution.x).map(|(a, x)| a * x).sum();
        }
        // A bound that the blend does not reach holds nothing back.
        let reaches = |multiplier: f64, value: f64, lower: f64, upper: f64| {
            if multiplier < 0.0 { value <= lower } else { multiplier > 0.0 && value >= upper }
        };
        for (j, multiplier) in solution.multipliers.iter_mut().enumerate() {
            let reaches = |it: &f64| reaches(*it, solution.x[j], levels.lower[j], levels.upper[j]);
            *multiplier = [*multiplier, self.parts[last].multipliers[j]].into_iter().find(reaches).unwrap_or(0.0);
        }
        for (row, multiplier) in solution.row_multipliers.iter_mut().enumerate() {
            let value = solution.row_values[row];
            if !levels.is_equation(row) && !reaches(*multiplier, value, levels.row_lower[row], levels.row_upper[row]) {
                *multiplier = 0.0;
            }
        }
    }
}

/// Returns the distance to the nearer bound, relative to a tenth of half the width between the bounds, at most 1.
fn room(value: f64, lower: f64, upper: f64) -> f64 {
    let half_width = 0.5 * (upper - lower);
    let half_width = if half_width.is_finite() { half_width } else { HALF_WIDTH };
    let distance = (value - lower).min(upper - value).max(0.0);
    if distance == 0.0 { 0.0 } else { (distance / (NEAR * half_width)).min(1.0) }
}

/// Returns whether all eigenvalues of a symmetric matrix exceed `bound`, by Cholesky's factorisation in place.
fn exceeds(matrix: &mut [f64], size: usize, bound: f64) -> bool {
    for i in 0..size {
        matrix[i * size + i] -= bound;
        for j in 0..=i {
            let sum: f64 = (0..j).map(|l| matrix[i * size + l] * matrix[j * size + l]).sum();
            let rest = matrix[i * size + j] - sum;
            matrix[i * size + j] = if i > j {
                rest / matrix[j * size + j]
            } else if rest > 0.0 {
                rest.sqrt()
            } else {
                return false;
            };
        }
    }
    true
}

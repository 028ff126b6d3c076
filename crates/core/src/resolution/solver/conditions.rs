//! The optimality conditions on a working set: what is wrong, the multipliers, the certificate.
//!
//! Everything is evaluated with the rows of the problem, not with those of the factorisation. Section numbers refer to
//! `docs/solver.md`.

use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use crate::linalg::Row;
use crate::resolution::solution::{WorkingSet, refill};

/// A working set and the least-squares solution on it.
#[derive(Clone, Copy)]
pub struct Trial<'a, const N: usize> {
    pub problem: &'a ProblemRows<'a, N>,
    pub set: &'a WorkingSet,
    pub solved: &'a Factorization<N>,
}

/// The conditions on one working set.
#[derive(Debug, Default)]
pub struct Conditions<const N: usize> {
    /// Free unknowns outside their bounds, and held ones whose multiplier points inwards.
    pub wrong: Vec<usize>,
    /// Inactive rows outside their bounds, and active ones whose multiplier points inwards.
    pub wrong_rows: Vec<usize>,
    /// Multiplier of each held unknown at the first level where it is not zero; positive at upper bounds if right.
    pub multipliers: Row<N>,
    /// The same of each active inequality row.
    pub row_multipliers: Vec<f64>,
    /// a·x of each row.
    pub values: Vec<f64>,
    /// Largest relative residual.
    pub residual: f64,
    /// Relative size below which a number is zero.
    rounding: f64,
    /// Bounds whose sign no level has decided yet; 1 for the unknowns whose sign is decided.
    undecided: usize,
    decided: Row<N>,
    row_decided: Vec<bool>,
    /// Multipliers of the rows for one level, with the sign of r = b − A x.
    w: Vec<f64>,
    /// Keeps w while it is computed for another right-hand side.
    kept_w: Vec<f64>,
    /// Size of the terms whose sum a multiplier is: of unknowns, and of rows times their length.
    sizes: Row<N>,
    row_sizes: Vec<f64>,
    scratch: Vec<f64>,
}

impl<const N: usize> Conditions<N> {
    /// Returns whether the working set is the right one.
    #[inline]
    pub fn are_met(&self) -> bool {
        self.wrong.is_empty() && self.wrong_rows.is_empty()
    }

    /// Evaluates the first condition (section 5): collects free unknowns and inactive rows outside their bounds.
    /// `rounding` is the relative size below which a number is zero.
    pub fn check_point(&mut self, trial: Trial<N>, rounding: f64) {
        self.rounding = rounding;
        self.wrong.clear();
        self.wrong_rows.clear();
        // Only inequality rows have bounds. Without them, the values are computed with the multipliers.
        if !trial.problem.inequalities.is_empty() {
            self.evaluate_rows(trial);
        }
        self.check_bounds(trial);
        self.check_rows(trial);
    }

    /// Evaluates the rest after [`Self::check_point`]: the multipliers and the certificate.
    pub fn check_levels(&mut self, trial: Trial<N>) {
        let Trial { problem, solved, .. } = trial;
        let speed = solved.peak_speed;
        self.start_levels(trial);
        for k in 0..problem.levels.len() {
            let (span, norm) = (solved.spans[k], problem.levels[k].norm);
            let mut farthest = 0.0;
            for row in &solved.rows[span.start..span.end] {
                let off = (row.target - self.values[row.index] - row.residual).abs();
                farthest = if off > farthest { off } else { farthest };
            }
            self.note_residual(farthest, span.target + norm * speed);
            if span.has_residual {
                // The rounding of the residual comes from the coordinates that the level sees.
                let seen = Row::<N>::from_slice(&solved.y.0[..span.rank_end()]).norm();
                self.check_level(trial, k, span.target + norm * (solved.base_norm + seen));
            }
        }
        if self.undecided > 0 || solved.rank() < solved.free.len() {
            self.check_level(trial, problem.levels.len(), speed);
        }
        // Where sizes overflow, nothing is certain.
        let mut levels = problem.levels.iter().zip(&solved.spans);
        if !levels.all(|(level, span)| level.square.is_finite() && span.target.is_finite()) || !speed.is_finite() {
            self.residual = f64::INFINITY;
        }
    }

    /// Sets a·x of each row.
    fn evaluate_rows(&mut self, Trial { problem, solved, .. }: Trial<N>) {
        refill(&mut self.values, problem.coefficients.iter().map(|row| solved.x.dot(row)));
    }

    /// Forgets the multipliers of the set before.
    fn start_levels(&mut self, trial: Trial<N>) {
        let Trial { problem, set, solved } = trial;
        if problem.inequalities.is_empty() {
            self.evaluate_rows(trial);
        }
        self.multipliers = Row::ZERO;
        let m = problem.rows.len();
        refill(&mut self.row_multipliers, std::iter::repeat_n(0.0, m));
        // A pinned unknown stays, whatever its multiplier is.
        let loose = solved.held.iter().filter(|&&j| !problem.is_pinned(j)).count();
        self.undecided = loose + problem.inequalities.iter().filter(|&&row| set.rows[row].is_some()).count();
        if !solved.held.is_empty() || self.undecided > 0 {
            self.decided = Row::ZERO;
            refill(&mut self.row_decided, std::iter::repeat_n(false, m));
        }
    }

    /// Collects free unknowns outside their bounds by more than rounding.
    fn check_bounds(&mut self, Trial { problem, solved, .. }: Trial<N>) {
        let (speed, rounding) = (solved.peak_speed, self.rounding * solved.peak_speed);
        let inside = solved.x.clamp(&problem.lower, &problem.upper);
        let outside = solved.x.minus(&inside);
        let farthest = outside.amax();
        if farthest > rounding {
            self.wrong.reserve(problem.unknowns);
            self.wrong.extend(solved.free.iter().filter(|&&j| outside.0[j].abs() > rounding));
        }
        // The answer is moved to its bounds, which counts as an error.
        self.residual = if farthest > 0.0 { farthest / speed } else { 0.0 };
    }

    /// Collects inactive rows outside their bounds.
    fn check_rows(&mut self, Trial { problem, set, solved }: Trial<N>) {
        for &row in problem.inequalities.iter().filter(|&&row| set.rows[row].is_none()) {
            let (value, norm) = (self.values[row], problem.rows[row].square.sqrt());
            let missing = (value - problem.rows[row].upper).max(problem.rows[row].lower - value);
            self.note_residual(missing, norm * solved.peak_speed);
            if missing > self.rounding * solved.peak_speed * norm {
                self.wrong_rows.push(row);
            }
        }
    }

    /// Evaluates stationarity and multipliers of level k, or of the last objective min ‖x − ζ‖² (k = number of levels).
    fn check_level(&mut self, trial: Trial<N>, k: usize, size: f64) {
        let Trial { problem, solved, .. } = trial;
        let multipliers = self.multipliers_of(problem, solved, k, None);
        let LevelMultipliers { h, length, amount, norm } = multipliers;
        if !solved.held.is_empty() || self.undecided > 0 {
            self.sizes = Row([amount; N]);
            refill(&mut self.row_sizes, std::iter::repeat_n(amount, problem.rows.len()));
            if self.undecided > 0 && length > 0.0 {
                self.add_residual_sizes(trial, k, size, &multipliers);
            }
            self.decide(trial, &h);
        }
        let stationarity = h.times(&solved.is_free).amax();
        self.note_residual(stationarity, amount.max(size * norm));
    }

    /// Adds the part of the rounding that comes from the level's residual r, which is known up to the rounding of `size`.
    ///
    /// r has one degree of freedom for each dependent row, and h = Σ_d r_d e_d. The size of an error in h_j is therefore
    /// `size` · Σ_d |e_dj|: with one dependent row no sign is in doubt. With more, a coarse bound is enough for most signs.
    fn add_residual_sizes(&mut self, trial: Trial<N>, k: usize, size: f64, multipliers: &LevelMultipliers<N>) {
        let (Trial { problem, set, solved }, &LevelMultipliers { h, length, amount, .. }) = (trial, multipliers);
        let dependent = solved.spans.get(k).map_or(0, |span| span.end - span.pivots_end);
        if dependent == 1 {
            return;
        }
        let coarse = amount * (1.0 + size / length);
        let doubtful = |value: f64| value > self.rounding * amount && value <= self.rounding * coarse;
        let mut active_rows = problem.inequalities.iter().filter(|&&row| set.rows[row].is_some());
        let is_doubtful = solved.held.iter().any(|&j| self.decided.0[j] == 0.0 && doubtful(h.0[j].abs()))
            || active_rows
                .any(|&row| !self.row_decided[row] && doubtful(self.w[row].abs() * problem.rows[row].square.sqrt()));
        if dependent == 0 || !is_doubtful {
            self.sizes = Row([coarse; N]);
            self.row_sizes.fill(coarse);
            return;
        }
        std::mem::swap(&mut self.w, &mut self.kept_w);
        for d in 0..dependent {
            let e = self.multipliers_of(problem, solved, k, Some(d)).h;
            self.sizes.add_scaled(size, &Row(e.0.map(f64::abs)));
            for (row, row_size) in self.row_sizes.iter_mut().enumerate() {
                *row_size += size * self.w[row].abs() * problem.rows[row].square.sqrt();
            }
        }
        std::mem::swap(&mut self.w, &mut self.kept_w);
    }

    /// Computes the gradient h = Σ w_i a_i of level k with the shortest multipliers w of all higher levels; leaves w. The
    /// level's own w are its residual, or those of one dependent row alone.
    fn multipliers_of(
        &mut self,
        problem: &ProblemRows<N>,
        solved: &Factorization<N>,
        k: usize,
        dependent: Option<usize>,
    ) -> LevelMultipliers<N> {
        refill(&mut self.w, std::iter::repeat_n(0.0, problem.rows.len()));
        let w = &mut self.w;
        let (mut h, mut g, norm, length, end);
        if k == problem.levels.len() {
            h = problem.reference.minus(&solved.x);
            g = solved.reference.minus(&solved.y);
            (norm, length, end) = (1.0, h.norm(), solved.rows.len());
        } else {
            let start = solved.spans[k].start;
            (h, g, norm, end) = (Row::ZERO, Row::ZERO, problem.levels[k].norm, solved.spans[k].end);
            if let Some(dependent) = dependent {
                solved.dependent[k].write_left_null_vector(solved.level(k), dependent, w);
            } else {
                solved.rows[start..end].iter().for_each(|row| w[row.index] = row.residual);
            }
            let mut square = 0.0;
            for row in &solved.rows[start..end] {
                square += w[row.index] * w[row.index];
                g.add_scaled(w[row.index], &row.coordinates);
            }
            length = square.sqrt();
        }
        let mut amount = length * norm;
        for level in (0..k).rev() {
            let (pivots, dependents) = solved.level(level);
            let first = solved.spans[level].first;
            let mut sum = 0.0;
            for (place, row) in pivots.iter().enumerate().rev() {
                let multiplier = -g.0[first + place] * row.inverse;
                w[row.index] = multiplier;
                g.add_scaled(multiplier, &row.coordinates);
                sum += multiplier.abs();
            }
            if !dependents.is_empty() {
                solved.dependent[level].shorten_multipliers((pivots, dependents), w, &mut g, &mut self.scratch);
                sum = pivots.iter().chain(dependents).map(|row| w[row.index].abs()).sum();
            }
            amount += sum * problem.levels[level].norm;
        }
        for row in &solved.rows[..end] {
            h.add_scaled(w[row.index], &problem.coefficients[row.index]);
        }
        LevelMultipliers { h, length, amount, norm }
    }

    /// Decides the sign of every bound whose multiplier is not zero here and was zero at all higher levels.
    fn decide(&mut self, Trial { problem, set, solved }: Trial<N>, h: &Row<N>) {
        for &j in &solved.held {
            if self.decided.0[j] != 0.0 {
                continue;
            }
            let points_inwards =
                set.unknowns[j].is_some_and(|side| side.sign() * h.0[j] < 0.0) && !problem.is_pinned(j);
            if points_inwards {
                self.note_residual(h.0[j].abs(), self.sizes.0[j]);
            }
            if h.0[j].abs() <= self.rounding * self.sizes.0[j] {
                continue;
            }
            self.decided.0[j] = 1.0;
            self.multipliers.0[j] = h.0[j];
            if !problem.is_pinned(j) {
                self.undecided -= 1;
                self.wrong.extend(points_inwards.then_some(j));
            }
        }
        if self.undecided == 0 {
            return;
        }
        for &row in problem.inequalities {
            let (Some(side), false) = (set.rows[row], self.row_decided[row]) else { continue };
            let multiplier = -self.w[row];
            let force = multiplier.abs() * problem.rows[row].square.sqrt();
            let points_inwards = side.sign() * multiplier < 0.0;
            if points_inwards {
                self.note_residual(force, self.row_sizes[row]);
            }
            if !(force > self.rounding * self.row_sizes[row]) {
                continue;
            }
            self.row_decided[row] = true;
            self.undecided -= 1;
            self.row_multipliers[row] = multiplier;
            self.wrong_rows.extend(points_inwards.then_some(row));
        }
    }

    /// Keeps the largest residual.
    #[inline]
    fn note_residual(&mut self, size: f64, scale: f64) {
        if size > self.residual * scale {
            self.residual = if scale > 0.0 { size / scale } else { f64::INFINITY };
        }
    }

    /// Returns the multipliers of one level: of the rows (sign of b − A x) and of the unknowns.
    pub fn level_multipliers(
        &mut self,
        problem: &ProblemRows<N>,
        solved: &Factorization<N>,
        k: usize,
    ) -> (&[f64], Row<N>) {
        let h = self.multipliers_of(problem, solved, k, None).h;
        (&self.w, h)
    }
}

/// The gradient of one level and its sizes.
struct LevelMultipliers<const N: usize> {
    /// Σ w_i a_i, plus ζ − x for the last objective.
    h: Row<N>,
    /// ‖r_k‖, or ‖ζ − x‖.
    length: f64,
    /// Σ |w_i| ‖A_level(i)‖.
    amount: f64,
    /// ‖A_k‖, or 1.
    norm: f64,
}

#[cfg(test)]
mod tests;

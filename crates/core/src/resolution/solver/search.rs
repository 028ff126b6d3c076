//! A search for the working set by a dual active-set method (Goldfarb and Idnani).
//!
//! Weights that grow by a large factor from level to level stand in for the order of the levels. They make the problem
//! strictly convex, and its inverse Hessian K is known from the factorisation without active bounds. The search takes about
//! one sweep of K per bound that becomes active. Its result is a proposal: the conditions on that set decide.

use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use crate::linalg::Row;
use crate::resolution::level::{Side, WorkingSet, refill};

/// Fraction of a diagonal entry of K at the start below which nothing but rounding is left of it.
const LOST_PIVOT: f64 = 1e-13;

/// The smallest weight of a level relative to the last objective.
const MIN_WEIGHT: f64 = 1e-40;

/// The tableau: constraints are the unknowns, then the inequality rows.
#[derive(Debug, Default)]
pub struct Search<const N: usize> {
    /// Entries per row of `table`, a multiple of N and of 8.
    stride: usize,
    /// K, later swept: how values and multipliers fall with each multiplier.
    table: Vec<f64>,
    /// Diagonal of K at the start.
    diagonal: Vec<f64>,
    /// Values of inactive constraints, multipliers of active ones.
    state: Vec<f64>,
    active: Vec<Option<Side>>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// A copy of one row of the tableau.
    row: Vec<f64>,
    /// The columns of G over the unknowns.
    generator: Vec<Row<N>>,
    /// The columns of G over all constraints, `stride` entries each, and 1/weight of each.
    columns: Vec<f64>,
    scales: Vec<f64>,
}

impl<const N: usize> Search<N> {
    /// Proposes a working set, from a factorisation without active rows of inequalities; `false` if rounding stopped it. Unknowns
    /// that it holds stay held.
    ///
    /// `spacing`: ratio of the weights of adjacent levels, below 1.
    pub fn propose(
        &mut self,
        problem: &ProblemRows<N>,
        solved: &Factorization<N>,
        spacing: f64,
        set: &mut WorkingSet,
    ) -> bool {
        self.load(problem, solved);
        // The weights of many levels must not vanish.
        let spacing = spacing.max(MIN_WEIGHT.powf(1.0 / problem.levels.len() as f64));
        self.tabulate(problem, solved, spacing);
        let finished = self.run();
        let n = problem.unknowns;
        for &j in &solved.free {
            set.unknowns[j] = self.active[j];
        }
        for (place, &row) in problem.inequalities.iter().enumerate() {
            set.rows[row] = self.active[n + place];
        }
        finished
    }

    /// Sets values and bounds of the constraints; held unknowns have none.
    fn load(&mut self, problem: &ProblemRows<N>, solved: &Factorization<N>) {
        let n = problem.unknowns;
        let rows = || problem.inequalities.iter().copied();
        let count = n + problem.inequalities.len();
        self.stride = count.next_multiple_of(N.max(8));
        let bound = |j: usize, bound: f64, none: f64| if solved.is_free.0[j] == 0.0 { none } else { bound };
        let lower = (0..n).map(|j| bound(j, problem.lower.0[j], f64::NEG_INFINITY));
        refill(&mut self.lower, lower.chain(rows().map(|row| problem.rows[row].lower)));
        let upper = (0..n).map(|j| bound(j, problem.upper.0[j], f64::INFINITY));
        refill(&mut self.upper, upper.chain(rows().map(|row| problem.rows[row].upper)));
        let values =
            solved.x.0[..n].iter().copied().chain(rows().map(|row| problem.rows[row].coefficients.dot(&solved.x)));
        refill(&mut self.state, values);
        self.state.resize(self.stride, 0.0);
        refill(&mut self.active, std::iter::repeat_n(None, count));
    }

    /// Writes K = G diag(1/weight) Gᵀ, with a row and a column for each constraint (section 6).
    ///
    /// The columns of G change one coordinate alone, or none: P = Q T⁻¹, and the last columns of Q. The slack of an inequality
    /// row adds 1/weight of its level to the diagonal.
    fn tabulate(&mut self, problem: &ProblemRows<N>, solved: &Factorization<N>, spacing: f64) {
        let (n, stride) = (problem.unknowns, self.stride);
        let exponent = |k: usize| i32::try_from(problem.levels.len() - k).unwrap_or(i32::MAX);
        let inverse_weight = |k: usize| spacing.powi(exponent(k)) * problem.levels[k].square;
        self.write_generator(problem, solved);
        refill(&mut self.columns, std::iter::repeat_n(0.0, self.generator.len() * stride));
        for (entries, column) in self.columns.chunks_exact_mut(stride).zip(&self.generator) {
            entries[..N].copy_from_slice(&column.0);
            for (entry, &row) in entries[n..].iter_mut().zip(&problem.inequalities) {
                *entry = problem.rows[row].coefficients.dot(column);
            }
        }
        self.scales.clear();
        for (k, span) in solved.spans.iter().enumerate() {
            self.scales.resize(span.rank_end(), inverse_weight(k));
        }
        self.scales.resize(self.generator.len(), 1.0);
        self.multiply_columns();
        for (place, &row) in problem.inequalities.iter().enumerate() {
            let level = problem.levels.iter().take_while(|level| level.end <= row).count();
            self.table[(n + place) * (stride + 1)] += inverse_weight(level);
        }
        let diagonal = (0..self.active.len()).map(|i| self.table[i * (stride + 1)]);
        refill(&mut self.diagonal, diagonal);
    }

    /// Writes G diag(1/weight) Gᵀ, eight entries of a row at a time.
    fn multiply_columns(&mut self) {
        let Self { table, columns, scales, stride, active, .. } = self;
        table.resize(active.len() * *stride, 0.0);
        for (i, entries) in table.chunks_exact_mut(*stride).enumerate() {
            for (block, entries) in entries.as_chunks_mut::<8>().0.iter_mut().enumerate() {
                let mut sums = [0.0; 8];
                for (column, scale) in columns.chunks_exact(*stride).zip(&*scales) {
                    let factor = scale * column[i];
                    for (sum, entry) in sums.iter_mut().zip(&column.as_chunks::<8>().0[block]) {
                        *sum += factor * entry;
                    }
                }
                *entries = sums;
            }
        }
    }

    /// Writes the columns of G.
    fn write_generator(&mut self, problem: &ProblemRows<N>, solved: &Factorization<N>) {
        let columns = &mut self.generator;
        columns.clear();
        // A = T Qᵀ gives the columns of Q one after the other, nearly orthogonal. A proposal needs no more.
        for row in solved.triangle() {
            let mut column = problem.rows[row.index].coefficients.times(&solved.is_free);
            for (other, factor) in columns.iter().zip(&row.coordinates.0) {
                column.add_scaled(-factor, other);
            }
            columns.push(column.scaled(row.inverse));
        }
        // P T = Q.
        for (c, row) in solved.triangle().enumerate().rev() {
            let (before, from) = columns.split_at_mut(c);
            from[0] = from[0].scaled(row.inverse);
            for (column, factor) in before.iter_mut().zip(&row.coordinates.0) {
                column.add_scaled(-factor, &from[0]);
            }
        }
        columns.extend((solved.rank()..solved.free.len()).map(|c| solved.q_column(c)));
    }

    /// Activates the bound that is broken most until none is; returns whether it arrived.
    fn run(&mut self) -> bool {
        for _ in 0..3 * self.active.len() + 10 {
            let Some((entering, side)) = self.most_broken() else { return true };
            if !self.enter(entering, side) {
                return false;
            }
        }
        false
    }

    /// Returns the inactive constraint with the largest (violation)²/K_ii, and the bound that it violates.
    fn most_broken(&self) -> Option<(usize, Side)> {
        let (mut worst, mut most) = (None, 0.0);
        let bounds = self.lower.iter().zip(&self.upper).zip(&self.active);
        for (i, (value, ((lower, upper), active))) in self.state.iter().zip(bounds).enumerate() {
            let (above, below) = (value - upper, lower - value);
            let excess = if above > below { above } else { below };
            if excess > 0.0 && active.is_none() {
                let diagonal = self.table[i * (self.stride + 1)];
                if excess * excess > most * diagonal {
                    let side = if above > below { Side::Upper } else { Side::Lower };
                    (worst, most) = (Some((i, side)), excess * excess / diagonal);
                }
            }
        }
        worst
    }

    /// Raises the multiplier of a broken constraint until it meets its bound; active constraints whose multipliers vanish on
    /// the way leave. Returns `false` if its pivot is lost to rounding.
    fn enter(&mut self, entering: usize, side: Side) -> bool {
        let bound = self.bound(entering, side);
        let mut multiplier = 0.0;
        for _ in 0..=self.active.len() {
            self.row.clear();
            self.row.extend_from_slice(&self.table[entering * self.stride..(entering + 1) * self.stride]);
            let pivot = self.row[entering];
            if !(pivot > LOST_PIVOT * self.diagonal[entering]) {
                return false;
            }
            let mut step = ((self.state[entering] - bound) / pivot).abs();
            let mut leaving = None;
            for (j, active) in self.active.iter().enumerate() {
                let Some(active) = active else { continue };
                let slope = self.row[j] * side.sign() * active.sign();
                if slope > 0.0 && (self.state[j] * active.sign()).max(0.0) < step * slope {
                    (step, leaving) = ((self.state[j] * active.sign()).max(0.0) / slope, Some((j, *active)));
                }
            }
            multiplier += side.sign() * step;
            add_scaled::<N>(&mut self.state, -side.sign() * step, &self.row);
            let Some((leaving, its_side)) = leaving else {
                self.sweep(entering, 1.0);
                self.active[entering] = Some(side);
                self.state[entering] = multiplier;
                return true;
            };
            self.sweep(leaving, -1.0);
            self.active[leaving] = None;
            self.state[leaving] = self.bound(leaving, its_side);
        }
        false
    }

    fn bound(&self, constraint: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[constraint],
            Side::Upper => self.upper[constraint],
        }
    }

    /// Exchanges value and multiplier of a constraint: `direction` 1 activates it, −1 releases it.
    fn sweep(&mut self, k: usize, direction: f64) {
        let stride = self.stride;
        self.row.clear();
        self.row.extend_from_slice(&self.table[k * stride..(k + 1) * stride]);
        let inverse = 1.0 / self.row[k];
        self.row.iter_mut().for_each(|entry| *entry *= inverse);
        for (_, entries) in self.table.chunks_exact_mut(stride).enumerate().filter(|(j, _)| *j != k) {
            let entry = entries[k];
            if entry != 0.0 {
                add_scaled::<N>(entries, -entry, &self.row);
                entries[k] = direction * entry * inverse;
            }
        }
        self.row.iter_mut().for_each(|entry| *entry *= direction);
        self.row[k] = -inverse;
        self.table[k * stride..(k + 1) * stride].copy_from_slice(&self.row);
    }
}

/// Adds `factor` · `other`; both have the same length, a multiple of N.
#[inline]
fn add_scaled<const N: usize>(entries: &mut [f64], factor: f64, other: &[f64]) {
    for (entries, other) in entries.as_chunks_mut::<N>().0.iter_mut().zip(other.as_chunks::<N>().0) {
        for (entry, other) in entries.iter_mut().zip(other) {
            *entry += factor * other;
        }
    }
}

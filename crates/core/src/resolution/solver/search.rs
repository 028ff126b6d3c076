//! A search for the working set by a dual active-set method (Goldfarb and Idnani).
//!
//! Weights that grow by a large factor from level to level stand in for the order of the levels. They make the problem
//! strictly convex, and its inverse Hessian K is known from the factorisation without active bounds. The search needs the
//! rows of K that belong to active bounds only, and writes each one when its bound becomes active. Its result is a proposal:
//! the conditions on that set decide.

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
    /// The columns of G over the unknowns, and 1/weight of each: K = G diag(1/weight) Gᵀ.
    generator: Vec<Row<N>>,
    scales: Vec<f64>,
    /// Entries per row of the tableau, a multiple of N.
    stride: usize,
    /// The constraints that are active, and the row of each in K after sweeps: how values and multipliers fall with each
    /// multiplier.
    held: Vec<usize>,
    table: Vec<f64>,
    /// Diagonal of K at the start, and after the sweeps.
    diagonal: Vec<f64>,
    swept_diagonal: Vec<f64>,
    /// Values of inactive constraints, multipliers of active ones.
    state: Vec<f64>,
    active: Vec<Option<Side>>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    /// What the slack of an inequality row adds to its entry of the diagonal: 1/weight of its level.
    slacks: Vec<f64>,
    /// The row of the constraint that enters, and one that is swept.
    row: Vec<f64>,
    pivot_row: Vec<f64>,
    factors: Vec<f64>,
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
        self.weigh(problem, solved, spacing);
        let finished = self.run(problem);
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
        let rows = || problem.inequalities.iter().map(|&row| &problem.rows[row]);
        let count = n + problem.inequalities.len();
        self.stride = count.next_multiple_of(N);
        refill(&mut self.lower, problem.lower.0[..n].iter().copied().chain(rows().map(|row| row.lower)));
        refill(&mut self.upper, problem.upper.0[..n].iter().copied().chain(rows().map(|row| row.upper)));
        for &j in &solved.held {
            (self.lower[j], self.upper[j]) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let values = rows().map(|row| row.coefficients.dot(&solved.x));
        refill(&mut self.state, solved.x.0[..n].iter().copied().chain(values));
        self.state.resize(self.stride, 0.0);
        refill(&mut self.active, std::iter::repeat_n(None, count));
        self.held.clear();
        self.table.clear();
    }

    /// Sets G, the weights, and the diagonal of K (section 6).
    ///
    /// The columns of G change one coordinate alone, or none: P = Q T⁻¹, and the last columns of Q. The slack of an inequality
    /// row adds 1/weight of its level to the diagonal.
    fn weigh(&mut self, problem: &ProblemRows<N>, solved: &Factorization<N>, spacing: f64) {
        let exponent = |k: usize| i32::try_from(problem.levels.len() - k).unwrap_or(i32::MAX);
        let inverse_weight = |k: usize| spacing.powi(exponent(k)) * problem.levels[k].square;
        self.write_generator(problem, solved);
        self.scales.clear();
        for (k, span) in solved.spans.iter().enumerate() {
            self.scales.resize(span.rank_end(), inverse_weight(k));
        }
        self.scales.resize(self.generator.len(), 1.0);
        let mut squares = Row::<N>::ZERO;
        for (column, &scale) in self.generator.iter().zip(&self.scales) {
            squares.add_scaled(scale, &column.times(column));
        }
        refill(&mut self.diagonal, squares.0[..problem.unknowns].iter().copied());
        self.slacks.clear();
        for &row in &problem.inequalities {
            let level = problem.levels.iter().take_while(|level| level.end <= row).count();
            let coefficients = &problem.rows[row].coefficients;
            let parts = self.generator.iter().zip(&self.scales);
            let square = parts.map(|(column, scale)| scale * coefficients.dot(column).powi(2)).sum::<f64>();
            self.slacks.push(inverse_weight(level));
            self.diagonal.push(square + inverse_weight(level));
        }
        self.diagonal.resize(self.stride, 0.0);
        self.swept_diagonal.clone_from(&self.diagonal);
    }

    /// Writes the row of an inactive constraint: that of K, swept by all active constraints.
    fn write_row(&mut self, problem: &ProblemRows<N>, constraint: usize) {
        let Self { generator, scales, held, table, slacks, row, factors, .. } = self;
        let n = problem.unknowns;
        let mut fall = Row::<N>::ZERO;
        let of_row = constraint.checked_sub(n).map(|place| &problem.rows[problem.inequalities[place]].coefficients);
        for (column, scale) in generator.iter().zip(scales) {
            let entry = of_row.map_or_else(|| column.0[constraint], |row| row.dot(column));
            fall.add_scaled(*scale * entry, column);
        }
        row.clear();
        row.extend_from_slice(&fall.0);
        row.resize(self.stride, 0.0);
        for (entry, &index) in row[n..].iter_mut().zip(&problem.inequalities) {
            *entry = problem.rows[index].coefficients.dot(&fall);
        }
        if let Some(place) = constraint.checked_sub(n) {
            row[constraint] += slacks[place];
        }
        refill(factors, held.iter().map(|&other| std::mem::take(&mut row[other])));
        for (factor, swept) in factors.iter().zip(table.chunks_exact(self.stride)) {
            add_scaled::<N>(row, -factor, swept);
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
    fn run(&mut self, problem: &ProblemRows<N>) -> bool {
        for _ in 0..3 * self.active.len() + 10 {
            let Some((entering, side)) = self.most_broken() else { return true };
            self.write_row(problem, entering);
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
                let diagonal = self.swept_diagonal[i];
                if excess * excess > most * diagonal {
                    let side = if above > below { Side::Upper } else { Side::Lower };
                    (worst, most) = (Some((i, side)), excess * excess / diagonal);
                }
            }
        }
        worst
    }

    /// Raises the multiplier of a broken constraint, whose row is written, until it meets its bound; active constraints whose
    /// multipliers vanish on the way leave. Returns `false` if its pivot is lost to rounding.
    fn enter(&mut self, entering: usize, side: Side) -> bool {
        let bound = self.bound(entering, side);
        let mut multiplier = 0.0;
        for _ in 0..=self.active.len() {
            let pivot = self.row[entering];
            if !(pivot > LOST_PIVOT * self.diagonal[entering]) {
                return false;
            }
            let mut step = ((self.state[entering] - bound) / pivot).abs();
            let mut leaving = None;
            for (place, &j) in self.held.iter().enumerate() {
                let Some(active) = self.active[j] else { continue };
                let slope = self.row[j] * side.sign() * active.sign();
                if slope > 0.0 && (self.state[j] * active.sign()).max(0.0) < step * slope {
                    (step, leaving) = ((self.state[j] * active.sign()).max(0.0) / slope, Some((place, j, active)));
                }
            }
            multiplier += side.sign() * step;
            add_scaled::<N>(&mut self.state, -side.sign() * step, &self.row);
            let Some((place, leaving, its_side)) = leaving else {
                self.activate(entering);
                self.active[entering] = Some(side);
                self.state[entering] = multiplier;
                return true;
            };
            self.release(place, leaving);
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

    /// Sweeps the tableau by a constraint whose row is written, and keeps that row.
    fn activate(&mut self, k: usize) {
        let Self { row, table, swept_diagonal, stride, held, .. } = self;
        let inverse = 1.0 / row[k];
        subtract_squares::<N>(swept_diagonal, inverse, row);
        row.iter_mut().for_each(|entry| *entry *= inverse);
        table.chunks_exact_mut(*stride).for_each(|entries| sweep::<N>(entries, k, row, inverse));
        row[k] = -inverse;
        table.extend_from_slice(row);
        held.push(k);
    }

    /// Sweeps the tableau and the row that enters back by the active constraint k, which has this place in the table.
    fn release(&mut self, place: usize, k: usize) {
        let Self { row, pivot_row, table, swept_diagonal, stride, held, .. } = self;
        let range = place * *stride..(place + 1) * *stride;
        pivot_row.clear();
        pivot_row.extend_from_slice(&table[range.clone()]);
        table.drain(range);
        held.remove(place);
        let inverse = 1.0 / pivot_row[k];
        subtract_squares::<N>(swept_diagonal, inverse, pivot_row);
        swept_diagonal[k] = -inverse;
        pivot_row.iter_mut().for_each(|entry| *entry *= inverse);
        for entries in table.chunks_exact_mut(*stride).chain([row.as_mut_slice()]) {
            sweep::<N>(entries, k, pivot_row, -inverse);
        }
    }
}

/// Exchanges value and multiplier of the constraint k in a row, with the row of k divided by its pivot; `inverse` is that of the
/// pivot, with the opposite sign where k leaves.
#[inline]
fn sweep<const N: usize>(entries: &mut [f64], k: usize, pivot_row: &[f64], inverse: f64) {
    let entry = entries[k];
    add_scaled::<N>(entries, -entry, pivot_row);
    entries[k] = entry * inverse;
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

/// Subtracts `factor` times the squares of `other`; both have the same length, a multiple of N.
#[inline]
fn subtract_squares<const N: usize>(entries: &mut [f64], factor: f64, other: &[f64]) {
    for (entries, other) in entries.as_chunks_mut::<N>().0.iter_mut().zip(other.as_chunks::<N>().0) {
        for (entry, other) in entries.iter_mut().zip(other) {
            *entry -= factor * other * other;
        }
    }
}

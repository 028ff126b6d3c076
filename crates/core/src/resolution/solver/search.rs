//! A search for the working set by a dual active-set method (Goldfarb and Idnani).
//!
//! Weights that grow by a large factor from level to level stand in for the order of the levels. They make the problem
//! strictly convex, and its inverse Hessian K is known from the factorisation without active bounds. The search needs few rows
//! of K: it writes one when its bound becomes active, and repeats on it what other bounds have changed. Its result is a
//! proposal: the conditions on that set decide.

use super::factorization::Factorization;
use super::problem_rows::ProblemRows;
use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::solution::{WorkingSet, refill};
use crate::tolerances::TOLERANCES;

/// Returns how many constraints may become active in a search, before it stops.
fn most_entering(constraints: usize) -> usize {
    3 * constraints + 10
}

/// Returns the largest number of changes of the active set in a search: no more constraints leave than become active.
fn most_changes(constraints: usize) -> usize {
    2 * most_entering(constraints)
}

/// The tableau: constraints are the unknowns, then the inequality rows.
#[derive(Debug, Default)]
pub struct Search<const N: usize> {
    /// The columns of G over the unknowns.
    generator: Vec<Row<N>>,
    /// The columns of G over all constraints, `stride` entries each, and 1/weight of each: K = G diag(1/weight) Gᵀ.
    columns: Vec<f64>,
    scales: Vec<f64>,
    /// Entries per row of the tableau, a multiple of N.
    stride: usize,
    /// The changes of the active set, and the pivot row of each divided by its pivot, `stride` entries.
    sweeps: Vec<Sweep>,
    pivot_rows: Vec<f64>,
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
    /// The row of the constraint that enters in the tableau, K after all sweeps: how values and multipliers fall with its
    /// multiplier. The row of one that leaves.
    row: Vec<f64>,
    leaving_row: Vec<f64>,
}

/// An exchange of value and multiplier of the constraint k.
#[derive(Debug, Clone, Copy)]
struct Sweep {
    k: usize,
    /// 1 where k becomes active, −1 where it leaves.
    direction: f64,
    /// 1/|pivot|.
    inverse: f64,
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
        let levels = i32::try_from(problem.levels.len()).unwrap_or(i32::MAX);
        let is_narrow = spacing.powi(levels) >= TOLERANCES.search_least_weight;
        let spacing = if is_narrow { spacing } else { TOLERANCES.search_least_weight.powf(1.0 / f64::from(levels)) };
        self.weigh(problem, solved, spacing);
        let finished = self.run(problem.unknowns);
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
        let values = problem.inequalities.iter().map(|&row| solved.x.dot(&problem.coefficients[row]));
        refill(&mut self.state, solved.x.0[..n].iter().copied().chain(values));
        self.state.resize(self.stride, 0.0);
        refill(&mut self.active, std::iter::repeat_n(None, count));
        self.sweeps.clear();
        self.pivot_rows.clear();
        self.sweeps.reserve(most_changes(count));
        self.pivot_rows.reserve(most_changes(count) * self.stride);
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
        refill(&mut self.columns, std::iter::repeat_n(0.0, self.generator.len() * self.stride));
        refill(&mut self.diagonal, std::iter::repeat_n(0.0, self.stride));
        let columns = self.columns.chunks_exact_mut(self.stride).zip(&self.generator);
        for ((entries, column), scale) in columns.zip(&self.scales) {
            entries[..N].copy_from_slice(&column.0);
            for (entry, &row) in entries[problem.unknowns..].iter_mut().zip(problem.inequalities) {
                *entry = column.dot(&problem.coefficients[row]);
            }
            for (sum, entry) in self.diagonal.iter_mut().zip(entries) {
                *sum += scale * *entry * *entry;
            }
        }
        self.slacks.clear();
        for (place, &row) in problem.inequalities.iter().enumerate() {
            let level = problem.levels.iter().take_while(|level| level.end <= row).count();
            self.slacks.push(inverse_weight(level));
            self.diagonal[problem.unknowns + place] += inverse_weight(level);
        }
        self.swept_diagonal.clone_from(&self.diagonal);
    }

    /// Writes the row of a constraint in the tableau.
    fn write_row(&self, unknowns: usize, constraint: usize, row: &mut Vec<f64>) {
        row.clear();
        for block in 0..self.stride / N {
            let mut sums = Row::<N>::ZERO;
            for (column, scale) in self.columns.chunks_exact(self.stride).zip(&self.scales) {
                sums.add_scaled(scale * column[constraint], &Row(column.as_chunks().0[block]));
            }
            row.extend_from_slice(&sums.0);
        }
        if let Some(place) = constraint.checked_sub(unknowns) {
            row[constraint] += self.slacks[place];
        }
        for (&sweep, pivot_row) in self.sweeps.iter().zip(self.pivot_rows.chunks_exact(self.stride)) {
            if sweep.k == constraint {
                row.iter_mut().zip(pivot_row).for_each(|(entry, pivot)| *entry = sweep.direction * pivot);
                row[constraint] = -sweep.direction * sweep.inverse;
            } else {
                sweep.apply::<N>(row, pivot_row);
            }
        }
    }

    /// Writes the columns of G.
    fn write_generator(&mut self, problem: &ProblemRows<N>, solved: &Factorization<N>) {
        let columns = &mut self.generator;
        columns.clear();
        // A = T Qᵀ gives the columns of Q one after the other, nearly orthogonal. A proposal needs no more.
        for row in solved.triangle() {
            let mut column = solved.is_free.times(&problem.coefficients[row.index]);
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
    fn run(&mut self, unknowns: usize) -> bool {
        for _ in 0..most_entering(self.active.len()) {
            let Some((entering, side)) = self.most_broken() else { return true };
            if !self.enter(unknowns, entering, side) {
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

    /// Raises the multiplier of a broken constraint until it meets its bound; active constraints whose multipliers vanish on
    /// the way leave. Returns `false` if its pivot is lost to rounding.
    fn enter(&mut self, unknowns: usize, entering: usize, side: Side) -> bool {
        let bound = self.bound(entering, side);
        let mut multiplier = 0.0;
        let mut row = std::mem::take(&mut self.row);
        self.write_row(unknowns, entering, &mut row);
        let mut arrived = false;
        for _ in 0..=self.active.len() {
            let pivot = row[entering];
            if !(pivot > TOLERANCES.search_lost_pivot * self.diagonal[entering]) {
                break;
            }
            let (step, leaving) = self.longest_step(&row, side, ((self.state[entering] - bound) / pivot).abs());
            multiplier += side.sign() * step;
            add_scaled::<N>(&mut self.state, -side.sign() * step, &row);
            let Some((leaving, its_side)) = leaving else {
                self.sweep(entering, 1.0, &row);
                self.active[entering] = Some(side);
                self.state[entering] = multiplier;
                arrived = true;
                break;
            };
            let mut leaving_row = std::mem::take(&mut self.leaving_row);
            self.write_row(unknowns, leaving, &mut leaving_row);
            self.sweep(leaving, -1.0, &leaving_row);
            self.leaving_row = leaving_row;
            let (sweep, pivot_row) = (self.sweeps.len() - 1, self.pivot_rows.len() - self.stride);
            self.sweeps[sweep].apply::<N>(&mut row, &self.pivot_rows[pivot_row..]);
            self.active[leaving] = None;
            self.state[leaving] = self.bound(leaving, its_side);
        }
        self.row = row;
        arrived
    }

    /// Returns how far the multiplier of the entering constraint rises, `most` at most, and the active constraint whose
    /// multiplier vanishes there.
    fn longest_step(&self, row: &[f64], side: Side, most: f64) -> (f64, Option<(usize, Side)>) {
        let (mut step, mut leaving) = (most, None);
        for (j, active) in self.active.iter().enumerate() {
            let Some(active) = *active else { continue };
            let slope = row[j] * side.sign() * active.sign();
            if slope > 0.0 && (self.state[j] * active.sign()).max(0.0) < step * slope {
                (step, leaving) = ((self.state[j] * active.sign()).max(0.0) / slope, Some((j, active)));
            }
        }
        (step, leaving)
    }

    fn bound(&self, constraint: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[constraint],
            Side::Upper => self.upper[constraint],
        }
    }

    /// Exchanges value and multiplier of a constraint with this row: `direction` 1 activates it, −1 releases it.
    fn sweep(&mut self, k: usize, direction: f64, row: &[f64]) {
        let inverse = 1.0 / row[k];
        let start = self.pivot_rows.len();
        self.pivot_rows.extend(row.iter().map(|entry| entry * inverse));
        self.sweeps.push(Sweep { k, direction, inverse: direction * inverse });
        let pivot_row = &self.pivot_rows[start..];
        for (diagonal, (entry, pivot)) in self.swept_diagonal.iter_mut().zip(row.iter().zip(pivot_row)) {
            *diagonal -= entry * pivot;
        }
        self.swept_diagonal[k] = -inverse;
    }
}

impl Sweep {
    /// Sweeps the row of another constraint.
    #[inline]
    fn apply<const N: usize>(self, row: &mut [f64], pivot_row: &[f64]) {
        let entry = row[self.k];
        add_scaled::<N>(row, -entry, pivot_row);
        row[self.k] = entry * self.inverse;
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

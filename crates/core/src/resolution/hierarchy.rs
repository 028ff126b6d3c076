//! The data of a hierarchical problem: levels of rows within a box.

use std::ops::Range;

use revprio_problem::{BoundId, MAX_UNKNOWNS, Side};

use super::solution::{Solution, refill};
use crate::linalg::{Matrix, Row, dot};
use crate::tolerances::TOLERANCES;

/// Levels of rows within a box, highest level first.
///
/// Level k minimises the squared slack of its rows inside the box, without changing what higher levels achieved. A row
/// asks `lower` ≤ a·x ≤ `upper`; its slack is what is missing, and an equation has two equal bounds. The last objective is
/// min ‖x − `reference`‖², so the answer is unique.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hierarchy {
    /// n, the number of unknowns.
    pub unknowns: usize,
    /// The number of entries of a row in memory; see [`row_width`].
    pub width: usize,
    /// Lower bounds of the unknowns, n; −∞ is allowed, and follows up to the width.
    pub lower: Vec<f64>,
    /// Upper bounds of the unknowns, n; ∞ is allowed, and follows up to the width. No bound is below its lower bound.
    pub upper: Vec<f64>,
    /// ζ, n, followed by zeros up to the width.
    pub reference: Vec<f64>,
    /// The demands of the rows of all levels one after the other.
    pub rows: Vec<Demand>,
    /// The coefficients of the rows one after the other, n entries each, followed by zeros up to the width.
    pub coefficients: Vec<f64>,
    /// The rows that are no equations.
    pub inequalities: Vec<usize>,
    /// The levels, highest first.
    pub levels: Vec<Level>,
}

/// The place and the size of one level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Level {
    /// First row.
    pub start: usize,
    /// One after the last row.
    pub end: usize,
    /// ‖A_k‖², Frobenius.
    pub square: f64,
    /// ‖A_k‖.
    pub norm: f64,
}

impl Level {
    /// Returns the indices of the rows.
    pub fn rows(&self) -> Range<usize> {
        self.start..self.end
    }
}

/// What a row asks: `lower` ≤ a·x ≤ `upper`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// −∞ is allowed.
    pub lower: f64,
    /// ∞ is allowed.
    pub upper: f64,
    /// ‖a‖², set when the row is added.
    pub square: f64,
    /// What the row means; `None` for an auxiliary row, such as one of damping.
    pub origin: Option<BoundId>,
}

impl Demand {
    /// Asks for a value between two bounds.
    #[inline]
    pub fn between(lower: f64, upper: f64, origin: Option<BoundId>) -> Self {
        Self { lower, upper, square: 0.0, origin }
    }

    /// Asks for one value.
    #[inline]
    pub fn equal(target: f64, origin: Option<BoundId>) -> Self {
        Self::between(target, target, origin)
    }

    /// Returns whether the row is an equation. A row whose target is not a number is one, so that the answer fails.
    #[inline]
    pub fn is_equation(&self) -> bool {
        !(self.lower < self.upper)
    }

    /// Returns the bound of a side.
    #[inline]
    pub fn bound(&self, side: Side) -> f64 {
        if side == Side::Lower { self.lower } else { self.upper }
    }
}

impl Hierarchy {
    /// Removes levels and bounds; the problem then has n unknowns without bounds and the reference `reference` (n).
    pub fn clear(&mut self, reference: &[f64]) {
        (self.unknowns, self.width) = (reference.len(), row_width(reference.len()));
        refill(&mut self.lower, std::iter::repeat_n(f64::NEG_INFINITY, self.width));
        refill(&mut self.upper, std::iter::repeat_n(f64::INFINITY, self.width));
        refill(&mut self.reference, reference.iter().copied());
        self.reference.resize(self.width, 0.0);
        self.rows.clear();
        self.coefficients.clear();
        self.inequalities.clear();
        self.levels.clear();
    }

    /// Adds an unknown with the reference 0 to a problem without rows.
    pub fn push_unknown(&mut self, lower: f64, upper: f64) {
        self.resize(self.unknowns + 1, row_width(self.unknowns + 1));
        (self.lower[self.unknowns - 1], self.upper[self.unknowns - 1]) = (lower, upper);
    }

    /// Sets the width of a problem without rows.
    #[cfg(test)]
    pub fn set_width(&mut self, width: usize) {
        self.resize(self.unknowns, width);
    }

    fn resize(&mut self, unknowns: usize, width: usize) {
        (self.unknowns, self.width) = (unknowns, width);
        self.lower.resize(self.width, f64::NEG_INFINITY);
        self.upper.resize(self.width, f64::INFINITY);
        self.reference.resize(self.width, 0.0);
    }

    /// Adds a row to the level that [`Self::end_level`] ends. Missing coefficients are zero.
    pub fn push_row(&mut self, coefficients: impl IntoIterator<Item = f64>, demand: Demand) {
        let start = self.coefficients.len();
        self.coefficients.extend(coefficients);
        self.coefficients.resize(start + self.width, 0.0);
        let row = &self.coefficients[start..];
        self.push_demand(demand, dot(row, row));
    }

    /// Adds an auxiliary row a·x = `target`.
    pub fn push_equation(&mut self, coefficients: impl IntoIterator<Item = f64>, target: f64) {
        self.push_row(coefficients, Demand::equal(target, None));
    }

    /// Adds the rows of a matrix. Unknowns behind its columns get zeros.
    pub fn push_matrix(&mut self, matrix: &Matrix, demand: impl Fn(usize) -> Demand) {
        match self.width {
            4 => self.push_wide::<4>(matrix, demand),
            8 => self.push_wide::<8>(matrix, demand),
            16 => self.push_wide::<16>(matrix, demand),
            24 => self.push_wide::<24>(matrix, demand),
            32 => self.push_wide::<32>(matrix, demand),
            40 => self.push_wide::<40>(matrix, demand),
            72 => self.push_wide::<72>(matrix, demand),
            _ => self.push_wide::<136>(matrix, demand),
        }
    }

    /// The same with the width, which the compiler knows.
    fn push_wide<const N: usize>(&mut self, matrix: &Matrix, demand: impl Fn(usize) -> Demand) {
        let (count, entries) = (matrix.nrows(), matrix.as_slice());
        self.coefficients.reserve(count * N);
        self.rows.reserve(count);
        for i in 0..count {
            let mut row = Row::<N>::ZERO;
            // Columns are contiguous.
            for (place, column) in row.0.iter_mut().zip(entries.chunks_exact(count)) {
                *place = column[i];
            }
            self.coefficients.extend_from_slice(&row.0);
            self.push_demand(demand(i), row.dot(&row));
        }
    }

    fn push_demand(&mut self, demand: Demand, square: f64) {
        if !demand.is_equation() {
            self.inequalities.push(self.rows.len());
        }
        self.rows.push(Demand { square, ..demand });
    }

    /// Adds the auxiliary rows A x = b, with b_i = `target(i)`.
    pub fn push_equations(&mut self, matrix: &Matrix, target: impl Fn(usize) -> f64) {
        self.push_matrix(matrix, |row| Demand::equal(target(row), None));
    }

    /// Adds the rows `factor` x = `factor` · `point`, for the first unknowns.
    pub fn push_near(&mut self, factor: f64, point: &[f64]) {
        for (i, x) in point.iter().enumerate() {
            self.push_equation((0..point.len()).map(|j| if i == j { factor } else { 0.0 }), factor * x);
        }
    }

    /// Ends a level. A level without rows is left out.
    pub fn end_level(&mut self) {
        let (start, end) = (self.levels.last().map_or(0, |level| level.end), self.rows.len());
        if end > start {
            let square = self.rows[start..].iter().map(|row| row.square).sum::<f64>();
            self.levels.push(Level { start, end, square, norm: square.sqrt() });
        }
    }

    /// Returns the coefficients of a row, n.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.coefficients[row * self.width..][..self.unknowns]
    }

    /// Returns a·x of a row.
    pub fn value(&self, row: usize, x: &[f64]) -> f64 {
        self.row(row).iter().zip(x).map(|(a, x)| a * x).sum()
    }

    /// Returns the size of the numbers whose differences are the residuals of a level. A bound that is far away is none of them.
    fn size(&self, level: &Level, solution: &Solution) -> f64 {
        let length = |entries: &[f64]| dot(entries, entries).sqrt();
        let values = self.rows[level.rows()].iter().zip(&solution.row_values[level.rows()]);
        let square: f64 = values.map(|(row, value)| value.max(row.lower).min(row.upper).powi(2)).sum();
        level.norm * (length(&solution.x) + length(&self.reference)) + square.sqrt()
    }

    /// Returns the rows of a level that a solution misses by more than rounding, and by how much.
    pub fn missing_rows(&self, solution: &Solution, level: &Level) -> impl Iterator<Item = (usize, f64)> {
        let rounding = TOLERANCES.proof_weight * self.size(level, solution);
        let missing = |row: usize| {
            let (value, demand) = (solution.row_values[row], &self.rows[row]);
            (row, (value - demand.upper).max(demand.lower - value))
        };
        level.rows().map(missing).filter(move |(_, missing)| *missing > rounding)
    }

    /// Returns the Frobenius norm of the equations.
    pub fn equation_norm(&self) -> f64 {
        self.rows.iter().filter(|row| row.is_equation()).map(|row| row.square).sum::<f64>().sqrt()
    }

    /// Returns the lower and the upper bound of each unknown.
    pub fn bounds(&self) -> impl Iterator<Item = (f64, f64)> {
        self.lower.iter().copied().zip(self.upper.iter().copied()).take(self.unknowns)
    }

    /// Makes an average of solutions consistent: x inside the box, the values of the rows, and the multipliers of `other` where
    /// the solution has none. A bound that the average does not reach, beyond the rounding of its row, holds nothing back.
    pub fn settle(&self, solution: &mut Solution, other: &Solution) {
        for (x, (lower, upper)) in solution.x.iter_mut().zip(self.bounds()) {
            // Not a number stays one: the answer is then refused.
            *x = x.clamp(lower, upper);
        }
        let reaches = |multiplier: f64, value: f64, lower: f64, upper: f64| {
            if multiplier < 0.0 { value <= lower } else { multiplier > 0.0 && value >= upper }
        };
        for (j, multiplier) in solution.multipliers.iter_mut().enumerate() {
            let reaches = |it: &f64| reaches(*it, solution.x[j], self.lower[j], self.upper[j]);
            *multiplier = [*multiplier, other.multipliers[j]].into_iter().find(reaches).unwrap_or(0.0);
        }
        let speed = solution.x.iter().map(|x| x * x).sum::<f64>().sqrt();
        for (index, (row, multiplier)) in self.rows.iter().zip(&mut solution.row_multipliers).enumerate() {
            let value = self.value(index, &solution.x);
            solution.row_values[index] = value;
            let rounding = TOLERANCES.rounding * row.square.sqrt() * speed;
            if !row.is_equation() && !reaches(*multiplier, value, row.lower + rounding, row.upper - rounding) {
                *multiplier = 0.0;
            }
        }
    }
}

/// Returns the number of entries that a row of n coefficients has in memory.
fn row_width(n: usize) -> usize {
    match n {
        0..=4 => 4,
        5..=8 => 8,
        9..=16 => 16,
        17..=24 => 24,
        25..=32 => 32,
        33..=40 => 40,
        41..=72 => 72,
        73..=MAX_UNKNOWNS => 136,
        _ => panic!("{n} unknowns; problems are checked for at most {MAX_UNKNOWNS}"),
    }
}

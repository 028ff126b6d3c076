//! The data of a hierarchical problem: levels of rows within a box, a working set, a solution.

use revprio_problem::{ActiveSet, BoundId, Side};

use crate::linalg::Matrix;

/// The numbers of entries that a row can have in memory; a row of n coefficients takes the first one that is at least n.
pub const ROW_WIDTHS: [usize; 7] = [4, 8, 16, 24, 40, 72, 136];

/// Levels of rows within a box, highest level first.
///
/// Level k minimises the squared slack of its rows inside the box, without changing what higher levels achieved. A row
/// asks `row_lower` ≤ a·x ≤ `row_upper`; its slack is what is missing, and an equation has two equal bounds. The last
/// objective is min ‖x − `reference`‖², so the answer is unique.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hierarchy {
    /// n, the number of unknowns.
    pub unknowns: usize,
    /// Lower bounds of the unknowns, n; −∞ is allowed.
    pub lower: Vec<f64>,
    /// Upper bounds of the unknowns, n; ∞ is allowed, and no bound is below its lower bound.
    pub upper: Vec<f64>,
    /// ζ, n.
    pub reference: Vec<f64>,
    /// The rows of all levels one after the other, n entries each, followed by zeros up to the width.
    pub rows: Vec<f64>,
    /// Entries of a row in `rows`: one of [`ROW_WIDTHS`].
    pub width: usize,
    /// Lower bounds of the rows.
    pub row_lower: Vec<f64>,
    /// Upper bounds of the rows.
    pub row_upper: Vec<f64>,
    /// The number of rows in this level and all higher ones, per level.
    pub level_ends: Vec<usize>,
}

impl Hierarchy {
    /// Removes levels and bounds; the problem then has n unknowns without bounds and the reference `reference` (n).
    pub fn clear(&mut self, reference: &[f64]) {
        let n = reference.len();
        self.unknowns = n;
        self.width = row_width(n);
        refill(&mut self.lower, std::iter::repeat_n(f64::NEG_INFINITY, n));
        refill(&mut self.upper, std::iter::repeat_n(f64::INFINITY, n));
        refill(&mut self.reference, reference.iter().copied());
        self.rows.clear();
        self.row_lower.clear();
        self.row_upper.clear();
        self.level_ends.clear();
    }

    /// Adds an unknown with the reference 0 to a problem without rows; returns its index.
    pub fn push_unknown(&mut self, lower: f64, upper: f64) -> usize {
        self.unknowns += 1;
        self.width = row_width(self.unknowns);
        self.lower.push(lower);
        self.upper.push(upper);
        self.reference.push(0.0);
        self.unknowns - 1
    }

    /// Adds a row to the level that [`Self::end_level`] ends. Missing coefficients are zero.
    pub fn push_row(&mut self, coefficients: impl IntoIterator<Item = f64>, lower: f64, upper: f64) {
        let end = self.rows.len() + self.width;
        self.rows.extend(coefficients);
        self.rows.resize(end, 0.0);
        self.row_lower.push(lower);
        self.row_upper.push(upper);
    }

    /// Adds the rows of a matrix, with one bound of each kind per row. Unknowns behind its columns get zeros.
    pub fn push_matrix(&mut self, matrix: &Matrix, lower: impl Fn(usize) -> f64, upper: impl Fn(usize) -> f64) {
        self.push_coefficients(matrix);
        self.row_lower.extend((0..matrix.nrows()).map(lower));
        self.row_upper.extend((0..matrix.nrows()).map(upper));
    }

    /// Adds the rows of A x = b, with one target for each row of A.
    pub fn push_equations(&mut self, matrix: &Matrix, targets: &[f64]) {
        self.push_coefficients(matrix);
        self.row_lower.extend_from_slice(targets);
        self.row_upper.extend_from_slice(targets);
    }

    fn push_coefficients(&mut self, matrix: &Matrix) {
        let (start, rows) = (self.rows.len(), matrix.nrows());
        self.rows.resize(start + rows * self.width, 0.0);
        let (entries, width) = (&mut self.rows[start..], self.width);
        // Columns are contiguous.
        for (mut place, column) in matrix.as_slice().chunks_exact(rows).enumerate() {
            for entry in column {
                entries[place] = *entry;
                place += width;
            }
        }
    }

    /// Ends a level. A level without rows is left out.
    pub fn end_level(&mut self) {
        if self.row_count() > self.level_start(self.level_ends.len()) {
            self.level_ends.push(self.row_count());
        }
    }

    /// Makes an average of solutions consistent: x inside the box, the values of the rows, and the multipliers of `other` where
    /// the solution has none. A bound that the average does not reach holds nothing back.
    pub fn settle(&self, solution: &mut Solution, other: &Solution) {
        for (x, (lower, upper)) in solution.x.iter_mut().zip(self.lower.iter().zip(&self.upper)) {
            // Not a number stays one: the answer is then refused.
            *x = if *x < *lower {
                *lower
            } else if *x > *upper {
                *upper
            } else {
                *x
            };
        }
        let reaches = |multiplier: f64, value: f64, lower: f64, upper: f64| {
            if multiplier < 0.0 { value <= lower } else { multiplier > 0.0 && value >= upper }
        };
        for (j, multiplier) in solution.multipliers.iter_mut().enumerate() {
            let reaches = |it: &f64| reaches(*it, solution.x[j], self.lower[j], self.upper[j]);
            *multiplier = [*multiplier, other.multipliers[j]].into_iter().find(reaches).unwrap_or(0.0);
        }
        for (row, multiplier) in solution.row_multipliers.iter_mut().enumerate() {
            let value: f64 = self.row(row).iter().zip(&solution.x).map(|(a, x)| a * x).sum();
            solution.row_values[row] = value;
            if !self.is_equation(row) && !reaches(*multiplier, value, self.row_lower[row], self.row_upper[row]) {
                *multiplier = 0.0;
            }
        }
    }

    /// Returns the number of rows of all levels.
    pub fn row_count(&self) -> usize {
        self.row_lower.len()
    }

    /// Returns the first row of a level.
    pub fn level_start(&self, level: usize) -> usize {
        if level == 0 { 0 } else { self.level_ends[level - 1] }
    }

    /// Returns the coefficients of a row, n.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.rows[row * self.width..][..self.unknowns]
    }

    /// Returns whether a row is an equation. A row whose target is not a number is one, so that the answer fails.
    pub fn is_equation(&self, row: usize) -> bool {
        !(self.row_lower[row] < self.row_upper[row])
    }
}

fn row_width(unknowns: usize) -> usize {
    ROW_WIDTHS.into_iter().find(|width| unknowns <= *width).unwrap_or(unknowns)
}

/// The active bounds: those of unknowns, and those of inequality rows. Equations are always active and not listed.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WorkingSet {
    /// Active bound of each unknown, n.
    pub unknowns: Vec<Option<Side>>,
    /// Active bound of each row.
    pub rows: Vec<Option<Side>>,
}

impl WorkingSet {
    /// Removes all active bounds and resizes.
    pub fn clear(&mut self, unknowns: usize, rows: usize) {
        refill(&mut self.unknowns, std::iter::repeat_n(None, unknowns));
        refill(&mut self.rows, std::iter::repeat_n(None, rows));
    }

    /// Adds the active limits of joints.
    pub fn hold(&mut self, active: &[ActiveSet]) {
        for bound in active.iter().flatten() {
            if let BoundId::Joint(joint) = bound.id
                && let Some(place) = self.unknowns.get_mut(joint)
            {
                *place = Some(bound.side);
            }
        }
    }

    /// Returns whether no bound is active.
    pub fn is_empty(&self) -> bool {
        self.unknowns.iter().all(Option::is_none) && self.rows.iter().all(Option::is_none)
    }
}

/// Where the search for a working set begins.
#[derive(Debug, Clone, Copy)]
pub enum Start<'a> {
    /// Without active bounds.
    Empty,
    /// With a guess.
    Guess(&'a WorkingSet),
    /// The problem is the one that was factorised last, without its limits: without active bounds if that is already the
    /// answer, otherwise with a guess.
    Factorized(&'a WorkingSet),
}

/// The solution of a [`Hierarchy`] with its optimality conditions evaluated.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Solution {
    /// x, n, inside the box.
    pub x: Vec<f64>,
    /// a·x of each row.
    pub row_values: Vec<f64>,
    /// The working set that x was computed on.
    pub working_set: WorkingSet,
    /// Multiplier of each unknown's active bound at the first level where it is not zero; positive at upper bounds, negative
    /// at lower bounds if the bound holds x back.
    pub multipliers: Vec<f64>,
    /// The same for each active inequality row.
    pub row_multipliers: Vec<f64>,
    /// Rank of each level, given the levels above it, on the working set.
    pub level_ranks: Vec<usize>,
    /// Whether the optimality conditions hold.
    pub is_optimal: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    /// Largest relative residual of the optimality conditions.
    pub kkt_residual: f64,
    /// Working sets that were tried.
    pub working_sets: u32,
    /// Whether the last resort found the working set.
    pub is_last_resort: bool,
}

impl Solution {
    /// Copies another solution without giving up the memory of this one.
    pub fn copy_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.row_values.clone_from(&other.row_values);
        self.working_set.unknowns.clone_from(&other.working_set.unknowns);
        self.working_set.rows.clone_from(&other.working_set.rows);
        self.multipliers.clone_from(&other.multipliers);
        self.row_multipliers.clone_from(&other.row_multipliers);
        self.level_ranks.clone_from(&other.level_ranks);
        let Self { is_optimal, rank_uncertain, kkt_residual, working_sets, is_last_resort, .. } = *other;
        self.is_last_resort = is_last_resort;
        (self.is_optimal, self.rank_uncertain) = (is_optimal, rank_uncertain);
        (self.kkt_residual, self.working_sets) = (kkt_residual, working_sets);
    }
}

impl Solution {
    /// Returns whether a bound holds x back.
    pub fn is_held_back(&self) -> bool {
        self.multipliers.iter().chain(&self.row_multipliers).any(|multiplier| *multiplier != 0.0)
    }

    /// Adds the uncertainties of a solution that this one is computed from.
    pub fn doubt(&mut self, other: &Self) {
        self.is_optimal &= other.is_optimal;
        self.kkt_residual = self.kkt_residual.max(other.kkt_residual);
        self.working_sets += other.working_sets;
        self.rank_uncertain |= other.rank_uncertain;
    }
}

/// Overwrites a list without giving up its memory.
pub fn refill<T>(list: &mut Vec<T>, entries: impl IntoIterator<Item = T>) {
    list.clear();
    list.extend(entries);
}

//! A problem in padded rows, with the sizes that do not depend on the working set.

use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::level::{Hierarchy, WorkingSet, refill};

/// The sizes of one level.
#[derive(Debug, Clone, Copy, Default)]
pub struct LevelSize {
    /// First row.
    pub start: usize,
    /// One after the last row.
    pub end: usize,
    /// ‖A_k‖², Frobenius.
    pub square: f64,
    /// ‖A_k‖.
    pub norm: f64,
}

/// A row of a problem: lower ≤ a·x ≤ upper.
#[derive(Debug, Clone, Copy)]
pub struct ProblemRow<const N: usize> {
    /// a.
    pub coefficients: Row<N>,
    /// ‖a‖².
    pub square: f64,
    pub lower: f64,
    pub upper: f64,
}

/// A [`Hierarchy`] in rows of N numbers.
#[derive(Debug, Default)]
pub struct ProblemRows<const N: usize> {
    /// n.
    pub unknowns: usize,
    pub lower: Row<N>,
    pub upper: Row<N>,
    pub reference: Row<N>,
    /// All rows, highest level first.
    pub rows: Vec<ProblemRow<N>>,
    /// Whether bounds of an unknown coincide.
    pub has_pinned: bool,
    /// The rows that are no equations.
    pub inequalities: Vec<usize>,
    pub levels: Vec<LevelSize>,
}

impl<const N: usize> ProblemRows<N> {
    /// Copies a problem whose rows have the width N; returns whether it differs from the problem before in its bounds at most.
    pub fn load(&mut self, problem: &Hierarchy) -> bool {
        debug_assert_eq!(problem.width, N);
        self.set_box(&problem.lower, &problem.upper);
        if self.has_rows_of(problem) {
            return true;
        }
        self.unknowns = problem.unknowns;
        self.reference = Row::from_slice(&problem.reference);
        let bounds = problem.row_lower.iter().zip(&problem.row_upper);
        let rows = problem.rows.as_chunks().0.iter().zip(bounds).map(|(coefficients, (&lower, &upper))| {
            let coefficients = Row(*coefficients);
            ProblemRow { coefficients, square: coefficients.dot(&coefficients), lower, upper }
        });
        refill(&mut self.rows, rows);
        let is_inequality = |(index, row): (usize, &ProblemRow<N>)| (row.lower < row.upper).then_some(index);
        refill(&mut self.inequalities, self.rows.iter().enumerate().filter_map(is_inequality));
        self.levels.clear();
        for &end in &problem.level_ends {
            self.end_level(end);
        }
        false
    }

    /// Sets the bounds of the unknowns.
    pub fn set_box(&mut self, lower: &[f64], upper: &[f64]) {
        (self.lower, self.upper) = (Row::from_slice(lower), Row::from_slice(upper));
        self.has_pinned = lower.iter().zip(upper).any(|(lower, upper)| lower >= upper);
    }

    /// Removes the bounds of the unknowns.
    pub fn open_box(&mut self) {
        (self.lower, self.upper) = (Row([f64::NEG_INFINITY; N]), Row([f64::INFINITY; N]));
        self.has_pinned = false;
    }

    fn end_level(&mut self, end: usize) {
        let start = self.levels.last().map_or(0, |level| level.end);
        let square = self.rows[start..end].iter().map(|row| row.square).sum::<f64>();
        self.levels.push(LevelSize { start, end, square, norm: square.sqrt() });
    }

    /// Returns whether levels, rows and reference are those of a problem.
    pub fn has_rows_of(&self, problem: &Hierarchy) -> bool {
        let n = problem.unknowns;
        let bounds = problem.row_lower.iter().zip(&problem.row_upper);
        let mut rows = self.rows.iter().zip(problem.rows.as_chunks().0.iter().zip(bounds));
        self.unknowns == n
            && self.rows.len() == problem.row_count()
            && self.levels.iter().map(|level| level.end).eq(problem.level_ends.iter().copied())
            && self.reference.0[..n] == problem.reference
            && rows.all(|(row, (coefficients, (lower, upper)))| {
                row.lower == *lower && row.upper == *upper && row.coefficients.0 == *coefficients
            })
    }

    /// Returns the bound that an active row is held at; equations have one.
    #[inline]
    pub fn target(&self, set: &WorkingSet, row: usize) -> f64 {
        match set.rows[row] {
            Some(Side::Upper) => self.rows[row].upper,
            _ => self.rows[row].lower,
        }
    }

    /// Returns whether a row takes part in least squares on a working set.
    #[inline]
    pub fn is_active(&self, set: &WorkingSet, row: usize) -> bool {
        set.rows[row].is_some() || !(self.rows[row].lower < self.rows[row].upper)
    }

    /// Returns whether the bounds of an unknown coincide.
    #[inline]
    pub fn is_pinned(&self, unknown: usize) -> bool {
        self.lower.0[unknown] >= self.upper.0[unknown]
    }
}

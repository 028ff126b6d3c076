//! A problem in padded rows, with the sizes that do not depend on the working set.

use crate::linalg::Row;
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

/// A [`Hierarchy`] in rows of N numbers.
#[derive(Debug, Default)]
pub struct ProblemRows<const N: usize> {
    /// n.
    pub unknowns: usize,
    pub lower: Row<N>,
    pub upper: Row<N>,
    pub reference: Row<N>,
    /// All rows, highest level first.
    pub rows: Vec<Row<N>>,
    pub row_lower: Vec<f64>,
    pub row_upper: Vec<f64>,
    /// ‖a_i‖² of each row.
    pub squares: Vec<f64>,
    /// The rows that are no equations.
    pub inequalities: Vec<usize>,
    pub levels: Vec<LevelSize>,
}

impl<const N: usize> ProblemRows<N> {
    /// Copies a problem whose rows have the width N; returns whether it differs from the problem before in its bounds at most.
    pub fn load(&mut self, problem: &Hierarchy) -> bool {
        debug_assert_eq!(problem.width, N);
        self.lower = Row::from_slice(&problem.lower);
        self.upper = Row::from_slice(&problem.upper);
        if self.has_rows_of(problem) {
            return true;
        }
        self.unknowns = problem.unknowns;
        self.reference = Row::from_slice(&problem.reference);
        refill(&mut self.rows, problem.rows.as_chunks().0.iter().map(|row| Row(*row)));
        self.row_lower.clone_from(&problem.row_lower);
        self.row_upper.clone_from(&problem.row_upper);
        refill(&mut self.squares, self.rows.iter().map(|row| row.dot(row)));
        refill(&mut self.inequalities, (0..self.rows.len()).filter(|&row| !problem.is_equation(row)));
        self.levels.clear();
        let mut start = 0;
        for &end in &problem.level_ends {
            let square = self.squares[start..end].iter().sum::<f64>();
            self.levels.push(LevelSize { start, end, square, norm: square.sqrt() });
            start = end;
        }
        false
    }

    /// Returns whether levels, rows and reference are those of a problem.
    fn has_rows_of(&self, problem: &Hierarchy) -> bool {
        let n = problem.unknowns;
        self.unknowns == n
            && self.rows.len() == problem.row_count()
            && self.row_lower == problem.row_lower
            && self.row_upper == problem.row_upper
            && self.levels.iter().map(|level| level.end).eq(problem.level_ends.iter().copied())
            && self.reference.0[..n] == problem.reference
            && self.rows.iter().zip(problem.rows.as_chunks().0).all(|(row, entries)| row.0 == *entries)
    }

    /// Returns the bound that an active row is held at; equations have one.
    #[inline]
    pub fn target(&self, set: &WorkingSet, row: usize) -> f64 {
        match set.rows[row] {
            Some(crate::resolution::level::Side::Upper) => self.row_upper[row],
            _ => self.row_lower[row],
        }
    }

    /// Returns whether a row takes part in least squares on a working set.
    #[inline]
    pub fn is_active(&self, set: &WorkingSet, row: usize) -> bool {
        set.rows[row].is_some() || !(self.row_lower[row] < self.row_upper[row])
    }

    /// Returns whether the bounds of an unknown coincide.
    #[inline]
    pub fn is_pinned(&self, unknown: usize) -> bool {
        self.lower.0[unknown] >= self.upper.0[unknown]
    }
}

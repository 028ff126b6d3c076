//! A problem in rows of N numbers.

use crate::linalg::Row;
use crate::resolution::Side;
use crate::resolution::hierarchy::{Demand, Hierarchy, Level};
use crate::resolution::solution::WorkingSet;

/// A [`Hierarchy`] whose rows have the width N.
#[derive(Debug, Clone, Copy)]
pub struct ProblemRows<'a, const N: usize> {
    /// n.
    pub unknowns: usize,
    pub lower: Row<N>,
    pub upper: Row<N>,
    pub reference: Row<N>,
    /// Whether bounds of an unknown coincide.
    pub has_pinned: bool,
    /// What each row asks, highest level first.
    pub rows: &'a [Demand],
    /// a of each row.
    pub coefficients: &'a [[f64; N]],
    /// The rows that are no equations.
    pub inequalities: &'a [usize],
    pub levels: &'a [Level],
}

impl<'a, const N: usize> ProblemRows<'a, N> {
    /// Returns the rows of a problem.
    pub fn new(problem: &'a Hierarchy) -> Self {
        let [lower, upper] = [&problem.lower, &problem.upper].map(|list| Row(list.as_chunks().0[0]));
        // A count has no branches.
        let has_pinned = lower.iter().zip(upper.iter()).filter(|(lower, upper)| lower >= upper).count() > 0;
        Self { lower, upper, has_pinned, ..Self::without_box(problem) }
    }

    /// Returns the rows of a problem, without bounds of the unknowns.
    pub fn without_box(problem: &'a Hierarchy) -> Self {
        Self {
            unknowns: problem.unknowns,
            lower: Row([f64::NEG_INFINITY; N]),
            upper: Row([f64::INFINITY; N]),
            reference: Row(problem.reference.as_chunks().0[0]),
            has_pinned: false,
            rows: &problem.rows,
            coefficients: problem.coefficients.as_chunks().0,
            inequalities: &problem.inequalities,
            levels: &problem.levels,
        }
    }

    /// Returns the bound that an active row is held at; equations have one.
    #[inline]
    pub fn target(&self, set: &WorkingSet, row: usize) -> f64 {
        self.rows[row].bound(set.rows[row].unwrap_or(Side::Lower))
    }

    /// Returns whether a row takes part in least squares on a working set.
    #[inline]
    pub fn is_active(&self, set: &WorkingSet, row: usize) -> bool {
        set.rows[row].is_some() || self.rows[row].is_equation()
    }

    /// Returns whether the bounds of an unknown coincide.
    #[inline]
    pub fn is_pinned(&self, unknown: usize) -> bool {
        self.lower.0[unknown] >= self.upper.0[unknown]
    }
}

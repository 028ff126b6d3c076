//! Lexicographic least squares on one working set, by reflections.
//!
//! The rows of all levels are turned into a lower triangle by Householder reflections from the right, level by level, the
//! longest remaining row of a level first: A = L Qᵀ. A coordinate is an entry of y = Qᵀ (x − base). Section numbers refer to
//! `docs/solver.md`.

use super::dependent_rows::DependentRows;
use super::factor_row::{FactorRow, bring_longest, remove_coordinate};
use super::problem_rows::ProblemRows;
use crate::linalg::{Row, SingularValues};
use crate::resolution::Side;
use crate::resolution::solution::{WorkingSet, refill};
use crate::tolerances::TOLERANCES;

/// The rows of one level: first its pivots, then the rows that depend on them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Span {
    pub start: usize,
    pub pivots_end: usize,
    pub end: usize,
    /// First coordinate of the level.
    pub first: usize,
    /// Whether the level leaves a residual.
    pub has_residual: bool,
    /// ‖b_k‖ of the active rows.
    pub target: f64,
}

impl Span {
    /// Returns the number of coordinates of the level.
    pub fn rank(&self) -> usize {
        self.pivots_end - self.start
    }

    /// Returns one after the level's last coordinate.
    pub fn rank_end(&self) -> usize {
        self.first + self.rank()
    }
}

/// Squared lengths of the pivots of a level.
struct Pivots {
    smallest: f64,
    /// That of a row that was too short; 0 without one.
    refused: f64,
}

/// The factorisation on a working set and its least-squares solution.
#[derive(Debug, Default)]
pub struct Factorization<const N: usize> {
    /// Unknowns that no bound holds, ascending. Coordinate c occupies the place `free[c]`.
    pub free: Vec<usize>,
    /// Unknowns at a bound, ascending.
    pub held: Vec<usize>,
    /// 1 for free unknowns, 0 for held ones.
    pub is_free: Row<N>,
    /// Bounds on held unknowns, zero on free ones.
    pub base: Row<N>,
    /// Coordinates of the reference, Qᵀ ζ over the free unknowns.
    pub reference: Row<N>,
    /// The active rows, level by level, pivots first.
    pub rows: Vec<FactorRow<N>>,
    pub spans: Vec<Span>,
    /// The place in `rows` that each coordinate was taken from.
    pub pivots: Vec<usize>,
    /// Coordinates of x − base.
    pub y: Row<N>,
    /// The solution.
    pub x: Row<N>,
    /// Singular values of a level below this fraction of ‖A_k‖ count as zero.
    pub rank_tolerance: f64,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    /// ‖base‖.
    pub base_norm: f64,
    /// The largest speed on the way to the solution, ‖base‖ + ‖y‖: the size of the terms whose difference x is.
    pub peak_speed: f64,
    /// The largest rank that singular values allow each level; empty until they have lowered one.
    max_rank: Vec<usize>,
    /// Per level; those of levels with pivots and dependent rows are factorised.
    pub dependent: Vec<DependentRows<N>>,
    /// Of a level's pivots over its own coordinates.
    singular: SingularValues,
}

impl<const N: usize> Factorization<N> {
    /// Returns the number of coordinates.
    #[inline]
    pub fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// Returns the rows of the triangle, one per coordinate.
    pub fn triangle(&self) -> impl DoubleEndedIterator<Item = &FactorRow<N>> + ExactSizeIterator + Clone {
        self.pivots.iter().map(|&place| &self.rows[place])
    }

    /// Returns the pivots of a level, and the rows that depend on them.
    #[inline]
    pub fn level(&self, k: usize) -> (&[FactorRow<N>], &[FactorRow<N>]) {
        let Span { start, pivots_end, end, .. } = self.spans[k];
        self.rows[start..end].split_at(pivots_end - start)
    }

    /// Returns the smallest singular value of the triangle.
    #[cold]
    pub fn smallest_singular_value(&mut self) -> f64 {
        let rank = self.rank();
        let triangle = self.pivots.iter().flat_map(|&place| &self.rows[place].coordinates.0[..rank]);
        self.singular.decompose(rank, triangle.copied());
        self.singular.smallest()
    }

    /// Factorises the active rows over the free unknowns and solves (section 4).
    pub fn solve(&mut self, problem: &ProblemRows<N>, set: &WorkingSet) {
        self.rank_uncertain = false;
        self.max_rank.clear();
        loop {
            self.start(problem, set);
            if self.factorize(problem) {
                break;
            }
        }
        self.place_reference(problem);
        self.peak_speed = self.peak_speed.max(self.base_norm + self.y.norm());
        self.x = self.base.plus(&self.apply_q(&self.y));
    }

    /// Sets the coordinates that no row sees to those of the reference. The rows do not see the reference at all, so that a
    /// large one costs them no digits.
    fn place_reference(&mut self, problem: &ProblemRows<N>) {
        self.reference = Row::ZERO;
        if problem.reference == Row::ZERO {
            return;
        }
        let mut zeta = problem.reference.times(&self.is_free);
        self.triangle().for_each(|row| row.reflect(&mut zeta));
        let rank = self.rank();
        for (c, &place) in self.free.iter().enumerate() {
            self.reference.0[c] = zeta.0[place];
            if c >= rank {
                self.y.0[c] = zeta.0[place];
            }
        }
    }

    /// Writes the active rows over the free unknowns, and what held unknowns leave of their targets.
    fn start(&mut self, problem: &ProblemRows<N>, set: &WorkingSet) {
        self.split_unknowns(problem, set);
        self.spans.clear();
        self.pivots.clear();
        self.y = Row::ZERO;
        let has_inequalities = !problem.inequalities.is_empty();
        self.dependent.resize_with(problem.levels.len().max(self.dependent.len()), DependentRows::default);
        // Written in place: the rows are as many as in the call before.
        self.rows.resize_with(problem.rows.len(), FactorRow::default);
        let (mut free_rows, mut end) = (self.rows.iter_mut(), 0);
        for level in problem.levels {
            let start = end;
            let mut target_square = 0.0;
            for index in level.start..level.end {
                if has_inequalities && !problem.is_active(set, index) {
                    continue;
                }
                let Some(row) = free_rows.next() else { break };
                let target = if has_inequalities { problem.target(set, index) } else { problem.rows[index].lower };
                target_square += target * target;
                end += 1;
                row.coordinates = Row::ZERO;
                (row.rest, row.square) = (Row(problem.coefficients[index]), problem.rows[index].square);
                (row.index, row.target, row.residual) = (index, target, target);
                if !self.held.is_empty() {
                    row.residual -= row.rest.dot(&self.base);
                    row.rest = row.rest.times(&self.is_free);
                    row.square = row.rest.dot(&row.rest);
                }
                row.summed_square = row.square;
            }
            let target = target_square.sqrt();
            self.spans.push(Span { start, end, target, ..Span::default() });
        }
        self.rows.truncate(end);
    }

    /// Sorts the unknowns into free and held ones.
    fn split_unknowns(&mut self, problem: &ProblemRows<N>, set: &WorkingSet) {
        if !problem.has_pinned && set.unknowns.iter().all(Option::is_none) {
            self.free_all(problem.unknowns);
            return;
        }
        self.free.clear();
        self.held.clear();
        self.base = Row::ZERO;
        self.is_free = Row([1.0; N]);
        for (j, side) in set.unknowns.iter().enumerate() {
            let bound = match side {
                _ if problem.is_pinned(j) => problem.lower.0[j],
                None => {
                    self.free.push(j);
                    continue;
                }
                Some(Side::Lower) => problem.lower.0[j],
                Some(Side::Upper) => problem.upper.0[j],
            };
            self.held.push(j);
            self.base.0[j] = bound;
            self.is_free.0[j] = 0.0;
        }
        self.base_norm = self.base.norm();
        self.peak_speed = self.base_norm;
    }

    /// Makes all unknowns free.
    fn free_all(&mut self, unknowns: usize) {
        refill(&mut self.free, 0..unknowns);
        self.held.clear();
        (self.base, self.is_free) = (Row::ZERO, Row([1.0; N]));
        (self.base_norm, self.peak_speed) = (0.0, 0.0);
    }

    /// Factorises and solves level by level; `false` where singular values allow a level less than its pivots, so that the
    /// factorisation has to start again with that rank.
    fn factorize(&mut self, problem: &ProblemRows<N>) -> bool {
        // The smallest pivot of the levels above, relative to its level: what depends on it carries that much more error.
        let mut weakest = 1.0_f64;
        for (k, level) in problem.levels.iter().enumerate() {
            let square = level.square;
            let tolerance = self.rank_tolerance.max(TOLERANCES.reflection_error / weakest);
            let Pivots { smallest, refused } = self.take_pivots(k, tolerance * tolerance * square);
            let suspicious = TOLERANCES.suspicious_pivot * TOLERANCES.suspicious_pivot * square;
            if (smallest < suspicious || refused > TOLERANCES.rounding * TOLERANCES.rounding * square)
                && !self.confirm_rank(k, tolerance * square.sqrt(), square.sqrt(), refused)
            {
                return false;
            }
            if smallest < suspicious {
                weakest = weakest.min((smallest / square).sqrt());
            }
            if self.spans[k].pivots_end < self.spans[k].end {
                self.solve_dependent_rows(problem, k);
            }
        }
        true
    }

    /// Takes rows of a level as coordinates, the longest first, while their squared length exceeds `least`.
    fn take_pivots(&mut self, k: usize, least: f64) -> Pivots {
        // A row whose square is subnormal counts as zero: its inverse overflows.
        let least = least.max(f64::MIN_POSITIVE / f64::EPSILON);
        let most = self.max_rank(k);
        let Self { spans, rows, free, pivots, y, .. } = self;
        let (span, first) = (&mut spans[k], pivots.len());
        let mut taken = Pivots { smallest: f64::INFINITY, refused: 0.0 };
        let (mut place, mut c) = (span.start, first);
        let end = free.len().min(first + most.min(span.end - span.start));
        while c < end {
            let (head, open) = (free[c], &mut rows[place..]);
            let square = bring_longest(&mut open[..span.end - place], least);
            if !(square > least) {
                taken.refused = square;
                break;
            }
            let Some((pivot, later)) = open.split_first_mut() else { break };
            y.0[c] = remove_coordinate(pivot, later, square, (c, head));
            taken.smallest = if square < taken.smallest { square } else { taken.smallest };
            (place, c) = (place + 1, c + 1);
        }
        pivots.extend(span.start..place);
        (span.first, span.pivots_end) = (first, place);
        taken
    }

    fn max_rank(&self, k: usize) -> usize {
        self.max_rank.get(k).copied().unwrap_or(usize::MAX)
    }

    /// Returns whether the levels above leave nothing of a level, or whether its pivots are all of its rows or of the unknowns that are left,
    /// and have no singular value below `least`.
    pub fn is_regular(&mut self, k: usize, least: f64) -> bool {
        let span = self.decompose(k);
        let is_full = span.pivots_end == span.end || span.rank_end() == self.free.len();
        span.rank() == 0 || (is_full && self.singular.is_above(least))
    }

    /// Decomposes the pivots of a level over its own coordinates.
    fn decompose(&mut self, k: usize) -> Span {
        let span = self.spans[k];
        let pivots = &self.rows[span.start..span.pivots_end];
        let own = pivots.iter().flat_map(|row| &row.coordinates.0[span.first..span.rank_end()]);
        self.singular.decompose(span.rank(), own.copied());
        span
    }

    /// Compares a level's rank with its singular values: all of its pivots, or the number that `max_rank` then holds.
    #[cold]
    fn confirm_rank(&mut self, k: usize, tolerance: f64, norm: f64, refused: f64) -> bool {
        let span = self.decompose(k);
        let (small, certain) = (TOLERANCES.rounding * norm, TOLERANCES.certain_rank * norm);
        self.rank_uncertain |= self.singular.count_from(small) > self.singular.count_from(certain)
            || (small < refused.sqrt() && refused.sqrt() < certain);
        let rank = self.singular.count_from(tolerance);
        let is_confirmed = rank == span.rank();
        if !is_confirmed {
            self.max_rank.resize(self.spans.len(), usize::MAX);
            self.max_rank[k] = rank;
        }
        is_confirmed
    }

    /// Solves least squares of a level whose last rows depend on its pivots and on higher levels.
    fn solve_dependent_rows(&mut self, problem: &ProblemRows<N>, k: usize) {
        let Span { start, pivots_end, end, first, target, .. } = self.spans[k];
        let (rows, lower_rows) = self.rows.split_at_mut(end);
        let (pivots, dependents) = rows[start..].split_at_mut(pivots_end - start);
        if !pivots.is_empty() {
            self.dependent[k].factorize(pivots, dependents, first);
        }
        let rounding = TOLERANCES.rounding * (target + problem.levels[k].norm * (self.base_norm + self.y.norm()));
        if dependents.iter().all(|row| row.residual.abs() <= rounding) {
            for row in dependents {
                row.residual = 0.0;
            }
            return;
        }
        self.spans[k].has_residual = true;
        if pivots.is_empty() {
            return;
        }
        let change = self.dependent[k].solve(pivots, dependents);
        // Targets that contradict each other cancel in the change, and leave their rounding.
        let asked = target / problem.levels[k].norm;
        self.peak_speed = self.peak_speed.max(self.base_norm + self.y.norm() + change.norm()).max(asked);
        self.y = self.y.plus(&change);
        for row in lower_rows {
            row.residual -= row.coordinates.dot(&change);
        }
    }

    /// Returns Q u for coordinates u; coordinates beyond the rank stand for directions that no row sees.
    fn apply_q(&self, coordinates: &Row<N>) -> Row<N> {
        let mut u = Row::ZERO;
        for (c, &place) in self.free.iter().enumerate() {
            u.0[place] = coordinates.0[c];
        }
        self.triangle().rev().for_each(|row| row.reflect(&mut u));
        u
    }

    /// Returns a column of Q, the direction of one coordinate. Reflections after the c-th leave e_c unchanged.
    pub fn q_column(&self, c: usize) -> Row<N> {
        let mut unit = Row::ZERO;
        unit.0[self.free[c]] = 1.0;
        self.triangle().take(c + 1).rev().for_each(|row| row.reflect(&mut unit));
        unit
    }
}

#[cfg(test)]
mod tests;

//! The solver for a problem of any size: one instance for each width of rows.

use super::active_set::ActiveSetSolver;
use super::problem_rows::ProblemRows;
use super::rungs::Rungs;
use crate::linalg::{Row, SingularValues, smallest_from_inverse, write_inverse};
use crate::resolution::hierarchy::Hierarchy;
use crate::resolution::solution::{Solution, Start, refill};

/// A solver, whatever its width is, and what its last factorisation can tell.
pub trait SizedSolver {
    /// Solves a problem.
    fn solve(&mut self, problem: &Hierarchy, start: Start, solution: &mut Solution);

    /// Factorises the equations of a problem, without its limits and without active inequality rows.
    fn factorize(&mut self, problem: &Hierarchy);

    /// Returns how often each way to a working set was needed so far.
    fn rungs(&self) -> Rungs;

    /// Returns whether the active rows of the last factorisation are independent, and at least one.
    fn has_independent_rows(&self) -> bool;

    /// Returns whether rounding may have decided a rank of the last factorisation.
    fn rank_uncertain(&self) -> bool;

    /// Returns a lower bound of σ_min of the last triangle of all rows, whose Frobenius norm is `norm`: the one of its determinant if that is at least `sure`;
    /// otherwise 1/‖L⁻¹‖_F if that is at least `needed`; otherwise σ_min itself.
    fn bound_smallest(&mut self, norm: f64, sure: f64, needed: f64) -> f64;

    /// Returns the product of the singular values of the last triangle.
    fn pivot_product(&self) -> f64;

    /// Returns the smallest singular value of a level of the last problem, restricted to what higher levels leave free.
    fn smallest_of_level(&mut self, level: usize) -> f64;

    /// Writes the multipliers of one level of the problem that was solved last: of the rows (sign of b − A x), and of the
    /// unknowns.
    fn write_level_multipliers(
        &mut self,
        problem: &Hierarchy,
        level: usize,
        rows: &mut Vec<f64>,
        unknowns: &mut Vec<f64>,
    );
}

/// The solver for rows of N numbers.
#[derive(Default)]
struct OfWidth<const N: usize> {
    solver: ActiveSetSolver<N>,
    /// Scratch: the inverse triangle and its Gram matrix, and singular values.
    inverse: Vec<Row<N>>,
    gram: Vec<Row<N>>,
    singular: SingularValues,
}

impl<const N: usize> SizedSolver for OfWidth<N> {
    fn solve(&mut self, problem: &Hierarchy, start: Start, solution: &mut Solution) {
        self.solver.solve(&ProblemRows::new(problem), start, solution);
    }

    fn factorize(&mut self, problem: &Hierarchy) {
        self.solver.factorize(&ProblemRows::without_box(problem));
    }

    fn rungs(&self) -> Rungs {
        self.solver.rungs
    }

    fn has_independent_rows(&self) -> bool {
        let solved = &self.solver.solved;
        solved.rank() == solved.rows.len() && solved.rank() > 0
    }

    fn rank_uncertain(&self) -> bool {
        self.solver.solved.rank_uncertain
    }

    fn bound_smallest(&mut self, norm: f64, sure: f64, needed: f64) -> f64 {
        let solved = &self.solver.solved;
        // The geometric mean of the squares of the other singular values is at most their mean, at most ‖L‖²/(n − 1).
        let others = solved.rank().saturating_sub(1);
        let power = i32::try_from(others).unwrap_or(i32::MAX);
        let bound = self.pivot_product() * ((others as f64).sqrt() / norm).powi(power);
        if bound >= sure {
            return bound;
        }
        let rows = solved.triangle().map(|row| (&row.coordinates, row.inverse));
        let size = write_inverse(rows, &mut self.inverse);
        if size * needed <= 1.0 { 1.0 / size } else { smallest_from_inverse(&self.inverse, size, &mut self.gram) }
    }

    fn pivot_product(&self) -> f64 {
        self.solver.solved.triangle().map(|row| 1.0 / row.inverse.abs()).product()
    }

    fn smallest_of_level(&mut self, level: usize) -> f64 {
        let solved = &self.solver.solved;
        let span = solved.spans[level];
        let (rows, columns) = (span.end - span.start, solved.free.len() - span.first);
        let rank = span.rank();
        if rank < rows.min(columns) {
            return 0.0;
        }
        // The block has `rank` columns that are not zero; singular values are taken on its shorter side.
        let entry = |row: usize, column: usize| solved.rows[span.start + row].coordinates.0[span.first + column];
        let (count, width) = (rows.min(rank), rows.max(rank));
        let at = |i: usize, j: usize| if rows <= rank { entry(i, j) } else { entry(j, i) };
        self.singular.decompose(width, (0..count).flat_map(|i| (0..width).map(move |j| at(i, j))));
        self.singular.smallest()
    }

    fn write_level_multipliers(
        &mut self,
        problem: &Hierarchy,
        level: usize,
        rows: &mut Vec<f64>,
        unknowns: &mut Vec<f64>,
    ) {
        let ActiveSetSolver { solved, conditions, .. } = &mut self.solver;
        let (w, h) = conditions.level_multipliers(&ProblemRows::new(problem), solved, level);
        refill(rows, w.iter().copied());
        refill(unknowns, h.0[..problem.unknowns].iter().copied());
    }
}

/// Solvers for all sizes, each made when it is first needed.
#[derive(Default)]
pub struct HierarchicalSolver {
    solvers: [Option<Box<dyn SizedSolver + Send>>; 7],
}

impl HierarchicalSolver {
    /// Returns how often each way to a working set was needed so far.
    pub fn rungs(&self) -> Rungs {
        self.solvers.iter().flatten().fold(Rungs::default(), |sum, solver| sum + solver.rungs())
    }

    /// Returns the solver for a problem.
    pub fn of_width(&mut self, problem: &Hierarchy) -> &mut (dyn SizedSolver + Send) {
        let (place, make): (usize, fn() -> Box<dyn SizedSolver + Send>) = match problem.width {
            4 => (0, || Box::<OfWidth<4>>::default()),
            8 => (1, || Box::<OfWidth<8>>::default()),
            16 => (2, || Box::<OfWidth<16>>::default()),
            24 => (3, || Box::<OfWidth<24>>::default()),
            40 => (4, || Box::<OfWidth<40>>::default()),
            72 => (5, || Box::<OfWidth<72>>::default()),
            _ => (6, || Box::<OfWidth<136>>::default()),
        };
        &mut **self.solvers[place].get_or_insert_with(make)
    }
}

#[cfg(test)]
mod tests;

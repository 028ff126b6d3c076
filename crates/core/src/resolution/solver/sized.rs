//! The solver for a problem of any size: one instance for each width of rows.

use super::active_set::ActiveSetSolver;
use super::problem_rows::ProblemRows;
use super::rungs::Rungs;
use crate::linalg::write_inverse;
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

    /// Returns whether rounding may have decided a rank of the last factorisation.
    fn rank_uncertain(&self) -> bool;

    /// Returns a lower bound of σ_min of all rows of the last factorisation, whose Frobenius norm is `norm`: the one of the
    /// determinant of their triangle if that is at least `sure`; otherwise 1/‖L⁻¹‖_F if that is at least `needed`, or
    /// shows that σ_min is not; otherwise σ_min itself. It is not a number where there are no rows, or where they depend on each other.
    fn bound_smallest(&mut self, norm: f64, sure: f64, needed: f64) -> f64;

    /// Returns the solution of the last factorisation if no singular value of a level, on what the levels above leave, is below `least`.
    /// Rows beyond the unknowns that are left do not count, and neither do levels of which nothing is left; also returns whether there are
    /// such levels. `None` where rounding may have decided a rank.
    fn regular_solution(&mut self, least: f64) -> Option<(&[f64], bool)>;

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

impl<const N: usize> SizedSolver for ActiveSetSolver<N> {
    fn solve(&mut self, problem: &Hierarchy, start: Start, solution: &mut Solution) {
        self.solve_rows(&ProblemRows::new(problem), start, solution);
    }

    fn factorize(&mut self, problem: &Hierarchy) {
        self.factorize_rows(&ProblemRows::without_box(problem));
    }

    fn rungs(&self) -> Rungs {
        self.rungs
    }

    fn rank_uncertain(&self) -> bool {
        self.solved.rank_uncertain
    }

    fn bound_smallest(&mut self, norm: f64, sure: f64, needed: f64) -> f64 {
        let solved = &self.solved;
        let rank = solved.rank();
        if rank != solved.rows.len() || rank == 0 {
            return f64::NAN;
        }
        // The geometric mean of the other squared singular values is at most their arithmetic mean.
        let others = rank - 1;
        let power = i32::try_from(others).unwrap_or(i32::MAX);
        let product: f64 = solved.triangle().map(|row| 1.0 / row.inverse.abs()).product();
        let bound = product * ((others as f64).sqrt() / norm).powi(power);
        if bound >= sure {
            return bound;
        }
        let size = write_inverse(solved.triangle().map(|row| (&row.coordinates, row.inverse)), &mut self.inverse);
        // σ_min lies between 1/‖L⁻¹‖_F and √r/‖L⁻¹‖_F.
        let decides = size * needed <= 1.0 || size * needed > (rank as f64).sqrt();
        if decides { 1.0 / size } else { self.solved.smallest_singular_value() }
    }

    fn regular_solution(&mut self, least: f64) -> Option<(&[f64], bool)> {
        let solved = &mut self.solved;
        let is_regular = !solved.rank_uncertain && (0..solved.spans.len()).all(|k| solved.is_regular(k, least));
        is_regular.then(|| (&solved.x.0[..], solved.spans.iter().any(|span| span.rank() == 0 && span.start < span.end)))
    }

    fn write_level_multipliers(
        &mut self,
        problem: &Hierarchy,
        level: usize,
        rows: &mut Vec<f64>,
        unknowns: &mut Vec<f64>,
    ) {
        let (w, h) = self.conditions.level_multipliers(&ProblemRows::new(problem), &self.solved, level);
        refill(rows, w.iter().copied());
        refill(unknowns, h.0[..problem.unknowns].iter().copied());
    }
}

/// Solvers for all sizes, each made when it is first needed.
#[derive(Default)]
pub struct HierarchicalSolver {
    solvers: [Option<Box<dyn SizedSolver + Send>>; 8],
}

impl HierarchicalSolver {
    /// Returns how often each way to a working set was needed so far.
    pub fn rungs(&self) -> Rungs {
        self.solvers.iter().flatten().fold(Rungs::default(), |sum, solver| sum + solver.rungs())
    }

    /// Returns the solver for a problem.
    pub fn of_width(&mut self, problem: &Hierarchy) -> &mut (dyn SizedSolver + Send) {
        let (place, make): (usize, fn() -> Box<dyn SizedSolver + Send>) = match problem.width {
            4 => (0, || Box::<ActiveSetSolver<4>>::default()),
            8 => (1, || Box::<ActiveSetSolver<8>>::default()),
            16 => (2, || Box::<ActiveSetSolver<16>>::default()),
            24 => (3, || Box::<ActiveSetSolver<24>>::default()),
            32 => (4, || Box::<ActiveSetSolver<32>>::default()),
            40 => (5, || Box::<ActiveSetSolver<40>>::default()),
            72 => (6, || Box::<ActiveSetSolver<72>>::default()),
            _ => (7, || Box::<ActiveSetSolver<136>>::default()),
        };
        &mut **self.solvers[place].get_or_insert_with(make)
    }
}

#[cfg(test)]
mod tests;

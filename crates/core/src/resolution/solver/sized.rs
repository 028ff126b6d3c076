//! The solver for a problem of any size: one instance for each width of rows.

use super::ActiveSetSolver;
use crate::linalg::{Row, Triangle, smallest_singular_value_bound, write_inverse, write_singular_values};
use crate::resolution::level::{Hierarchy, Solution, WorkingSet, refill};

/// The largest number of unknowns.
pub const MAX_UNKNOWNS: usize = 136;

/// A solver of hierarchical problems: a problem in, a solution with its optimality conditions out.
pub trait LevelSolver {
    /// Solves a problem of up to [`MAX_UNKNOWNS`] unknowns; `guess` is the working set to start from.
    fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, solution: &mut Solution);
}

/// What the last factorisation of a solver can tell, whatever its width is.
trait SizedSolver: LevelSolver {
    fn solve_without_bounds(&mut self, problem: &Hierarchy, solution: &mut Solution);
    fn certify(&mut self, solution: &mut Solution);
    fn exceeds(&mut self, threshold: f64) -> bool;
    fn write_triangle(&self, triangle: &mut Triangle);
    fn pivot_product(&self) -> f64;
    fn smallest_of_level(&mut self, level: usize) -> f64;
    fn write_level_multipliers(&mut self, level: usize, rows: &mut Vec<f64>, unknowns: &mut Vec<f64>);
    fn write_null_space(&self, basis: &mut Vec<f64>);
}

/// A solver of one width with room for the examination of its triangle.
#[derive(Default)]
struct Sized<const N: usize> {
    solver: ActiveSetSolver<N>,
    inverse: Vec<Row<N>>,
    block: Vec<f64>,
    sigma: Vec<f64>,
}

impl<const N: usize> LevelSolver for Sized<N> {
    fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, solution: &mut Solution) {
        self.solver.solve(problem, guess, solution);
    }
}

impl<const N: usize> SizedSolver for Sized<N> {
    fn solve_without_bounds(&mut self, problem: &Hierarchy, solution: &mut Solution) {
        self.solver.solve_without_bounds(problem, solution);
    }

    fn certify(&mut self, solution: &mut Solution) {
        self.solver.certify(solution);
    }

    fn exceeds(&mut self, threshold: f64) -> bool {
        let rows = self.solver.solved.triangle().map(|row| (&row.coordinates, row.inverse));
        smallest_singular_value_bound(rows.clone()) >= threshold
            || write_inverse(rows, &mut self.inverse) * threshold <= 1.0
    }

    fn write_triangle(&self, triangle: &mut Triangle) {
        triangle.set(self.solver.solved.triangle().map(|row| &row.coordinates));
    }

    fn pivot_product(&self) -> f64 {
        self.solver.solved.triangle().map(|row| 1.0 / row.inverse.abs()).product()
    }

    fn smallest_of_level(&mut self, level: usize) -> f64 {
        let solved = &self.solver.solved;
        let span = solved.spans[level];
        let (rows, columns) = (span.end - span.start, solved.free.len() - span.first);
        let rank = span.rank_end - span.first;
        if rank < rows.min(columns) {
            return 0.0;
        }
        // The block has `rank` columns that are not zero; singular values are taken on its shorter side.
        let entry = |row: usize, column: usize| solved.rows[span.start + row].coordinates.0[span.first + column];
        let (count, width) = (rows.min(rank), rows.max(rank));
        let at = |i: usize, j: usize| if rows <= rank { entry(i, j) } else { entry(j, i) };
        refill(&mut self.block, (0..count).flat_map(|i| (0..width).map(move |j| at(i, j))));
        write_singular_values(&mut self.block, width, &mut self.sigma);
        self.sigma.last().copied().unwrap_or(0.0)
    }

    fn write_level_multipliers(&mut self, level: usize, rows: &mut Vec<f64>, unknowns: &mut Vec<f64>) {
        let ActiveSetSolver { problem, solved, conditions, .. } = &mut self.solver;
        let (w, h) = conditions.write_level_multipliers(problem, solved, level);
        refill(rows, w.iter().copied());
        refill(unknowns, h.0[..problem.unknowns].iter().copied());
    }

    fn write_null_space(&self, basis: &mut Vec<f64>) {
        let ActiveSetSolver { problem, solved, .. } = &self.solver;
        basis.clear();
        for c in solved.rank()..solved.free.len() {
            basis.extend_from_slice(&solved.q_column(c).0[..problem.unknowns]);
        }
    }
}

/// Solvers for all sizes, each made when it is first needed.
#[derive(Default)]
pub struct HierarchicalSolver {
    solvers: [Option<Box<dyn SizedSolver + Send>>; 7],
    last: usize,
}

impl LevelSolver for HierarchicalSolver {
    fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, solution: &mut Solution) {
        self.of_width(problem.unknowns).solve(problem, guess, solution);
    }
}

impl HierarchicalSolver {
    /// Returns the solver whose rows hold n numbers.
    fn of_width(&mut self, n: usize) -> &mut (dyn SizedSolver + Send) {
        let (place, make): (usize, fn() -> Box<dyn SizedSolver + Send>) = match n {
            0..=4 => (0, || Box::<Sized<4>>::default()),
            5..=8 => (1, || Box::<Sized<8>>::default()),
            9..=16 => (2, || Box::<Sized<16>>::default()),
            17..=24 => (3, || Box::<Sized<24>>::default()),
            25..=40 => (4, || Box::<Sized<40>>::default()),
            41..=72 => (5, || Box::<Sized<72>>::default()),
            73..=MAX_UNKNOWNS => (6, || Box::<Sized<136>>::default()),
            _ => panic!("{n} unknowns; problems are checked for at most {MAX_UNKNOWNS}"),
        };
        self.last = place;
        &mut **self.solvers[place].get_or_insert_with(make)
    }

    fn last(&mut self) -> &mut (dyn SizedSolver + Send) {
        &mut **self.solvers[self.last].as_mut().expect("a problem was solved before")
    }

    /// Solves a problem of equations without bounds and does not evaluate the optimality conditions. Only x, the ranks and
    /// whether they are uncertain are set.
    pub fn solve_without_bounds(&mut self, problem: &Hierarchy, solution: &mut Solution) {
        self.of_width(problem.unknowns).solve_without_bounds(problem, solution);
    }

    /// Evaluates the optimality conditions of the last [`Self::solve_without_bounds`] and sets the rest of the solution.
    pub fn certify(&mut self, solution: &mut Solution) {
        self.last().certify(solution);
    }

    /// Returns whether all singular values of the last triangle certainly exceed `threshold`.
    pub fn exceeds(&mut self, threshold: f64) -> bool {
        self.last().exceeds(threshold)
    }

    /// Copies the last triangle.
    pub fn write_triangle(&mut self, triangle: &mut Triangle) {
        self.last().write_triangle(triangle);
    }

    /// Returns the product of the singular values of the last triangle.
    pub fn pivot_product(&mut self) -> f64 {
        self.last().pivot_product()
    }

    /// Returns the smallest singular value of a level of the last problem, restricted to what higher levels leave free.
    pub fn smallest_of_level(&mut self, level: usize) -> f64 {
        self.last().smallest_of_level(level)
    }

    /// Writes the multipliers of one level of the last problem: of the rows (sign of b − A x), and of the unknowns.
    pub fn write_level_multipliers(&mut self, level: usize, rows: &mut Vec<f64>, unknowns: &mut Vec<f64>) {
        self.last().write_level_multipliers(level, rows, unknowns);
    }

    /// Writes an orthonormal basis of what the active rows of the last problem leave free, column by column.
    pub fn write_null_space(&mut self, basis: &mut Vec<f64>) {
        self.last().write_null_space(basis);
    }
}

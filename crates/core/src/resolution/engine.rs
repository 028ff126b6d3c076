//! Solving planned problems, and what can be asked about a solved one.

use super::certified::Record;
use super::hierarchy::Hierarchy;
use super::solution::{Solution, Start};
use super::solver::{HierarchicalSolver, Rungs, SizedSolver};

/// The hierarchical solver, with a record for certificates.
#[derive(Default)]
pub struct Engine {
    solver: HierarchicalSolver,
    /// How many problems since [`Self::start`] needed the last resort.
    pub last_resorts: u32,
    /// The problems since then, where a certificate is wanted.
    pub record: Option<Record>,
}

/// The solver of a problem, which knows its factorisation on the last working set.
pub struct Solved<'e> {
    engine: &'e mut Engine,
}

impl Engine {
    /// Begins the problems of one answer.
    pub fn start(&mut self, is_recorded: bool) {
        self.last_resorts = 0;
        self.record = is_recorded.then(Record::default);
    }

    /// Returns how often each way to a working set was needed so far.
    pub fn rungs(&self) -> Rungs {
        self.solver.rungs()
    }

    /// Factorises the equations of a problem, without its limits and without active inequality rows.
    pub fn factorize(&mut self, levels: &Hierarchy) -> &mut dyn SizedSolver {
        let solver = self.solver.of_width(levels);
        solver.factorize(levels);
        solver
    }

    /// Returns the solver of the problem that [`Self::factorize`] got last, if no other problem was solved since.
    pub fn factorized(&mut self, levels: &Hierarchy) -> &mut dyn SizedSolver {
        self.solver.of_width(levels)
    }

    /// Solves a problem.
    pub fn solve(&mut self, levels: &Hierarchy, start: Start, solution: &mut Solution) -> Solved<'_> {
        let solver = self.solver.of_width(levels);
        solver.solve(levels, start, solution);
        self.last_resorts += u32::from(solution.is_last_resort);
        if let Some(record) = &mut self.record {
            record.push(levels, &solution.x, solver);
        }
        Solved { engine: self }
    }
}

impl<'e> Solved<'e> {
    /// Solves another problem instead.
    pub fn again(self, levels: &Hierarchy, start: Start, solution: &mut Solution) -> Self {
        let engine: &'e mut Engine = self.engine;
        engine.solve(levels, start, solution)
    }

    /// Writes the multipliers of one level of the solved problem: of the rows (sign of b − A x), and of the unknowns.
    pub fn write_level_multipliers(
        &mut self,
        levels: &Hierarchy,
        level: usize,
        rows: &mut Vec<f64>,
        unknowns: &mut Vec<f64>,
    ) {
        self.engine.solver.of_width(levels).write_level_multipliers(levels, level, rows, unknowns);
    }
}

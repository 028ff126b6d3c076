//! Solving planned problems, and what can be asked about a solved one.

use revprio_problem::BoundId;

use super::certified::Record;
use super::level::{Hierarchy, Solution, Start};
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
    unknowns: usize,
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
        let solver = self.solver.of_width(levels.unknowns);
        solver.factorize(levels);
        solver
    }

    /// Solves a problem whose rows mean `origins` (empty: they are auxiliary).
    pub fn solve(
        &mut self,
        levels: &Hierarchy,
        origins: &[Option<BoundId>],
        start: Start,
        solution: &mut Solution,
    ) -> Solved<'_> {
        let unknowns = levels.unknowns;
        let solver = self.solver.of_width(unknowns);
        solver.solve(levels, start, solution);
        self.last_resorts += u32::from(solution.is_last_resort);
        if let Some(record) = &mut self.record {
            record.push(levels, origins, &solution.x, solver);
        }
        Solved { engine: self, unknowns }
    }
}

impl<'e> Solved<'e> {
    /// Solves another problem instead.
    pub fn again(self, levels: &Hierarchy, origins: &[Option<BoundId>], start: Start, solution: &mut Solution) -> Self {
        let engine: &'e mut Engine = self.engine;
        engine.solve(levels, origins, start, solution)
    }

    /// Writes the multipliers of one level: of the rows (sign of b − A x), and of the unknowns.
    pub fn write_level_multipliers(&mut self, level: usize, rows: &mut Vec<f64>, unknowns: &mut Vec<f64>) {
        self.engine.solver.of_width(self.unknowns).write_level_multipliers(level, rows, unknowns);
    }
}

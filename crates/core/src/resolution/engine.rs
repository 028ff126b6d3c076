//! The solver of hierarchical problems, and the record of what it solved.

use revprio_problem::BoundId;

use super::certified::Record;
use super::level::{Hierarchy, Solution, WorkingSet};
use super::solver::HierarchicalSolver;
use crate::limits::VelocityBox;

/// The hierarchical solver with its record.
#[derive(Default)]
pub struct Engine {
    exact: HierarchicalSolver,
    /// Problems that needed the last resort since [`Self::start`].
    pub last_resorts: u32,
    /// The problems that were solved since [`Self::start`], if they are recorded.
    pub record: Option<Record>,
}

impl Engine {
    /// Forgets the last answer; `is_recorded`: records the problems of the next one.
    pub fn start(&mut self, is_recorded: bool) {
        self.last_resorts = 0;
        self.record = is_recorded.then(Record::default);
    }

    /// Returns the hierarchical solver.
    pub fn exact(&mut self) -> &mut HierarchicalSolver {
        &mut self.exact
    }

    /// Solves a problem whose rows mean `origins` (empty: they are auxiliary); `guess` is the working set to start from.
    pub fn solve(
        &mut self,
        problem: &Hierarchy,
        origins: &[Option<BoundId>],
        guess: Option<&WorkingSet>,
        solution: &mut Solution,
    ) {
        let exact = self.exact.of_width(problem.unknowns);
        exact.solve(problem, guess, solution);
        self.last_resorts += u32::from(solution.is_last_resort);
        if let Some(record) = &mut self.record {
            record.push(problem, origins, &solution.x, self.exact.last());
        }
    }

    /// Solves the equations that the hierarchical solver knows within a box, with the levels from `own_levels` on joined into one.
    pub fn solve_within(
        &mut self,
        limits: &VelocityBox,
        own_levels: usize,
        guess: &WorkingSet,
        solution: &mut Solution,
    ) {
        let exact = self.exact.last();
        exact.join_levels(own_levels);
        let bounds = (limits.lower().as_slice(), limits.upper().as_slice());
        exact.solve_within(bounds, Some(guess), solution);
        self.last_resorts += u32::from(solution.is_last_resort);
    }
}

//! The solver of hierarchical problems, its last resort, and the record of what it solved.

use super::certified::Record;
use super::clarabel::ClarabelLevels;
use super::level::{Hierarchy, Solution, WorkingSet};
use super::plan::Origin;
use super::solver::HierarchicalSolver;
use crate::limits::VelocityBox;

/// Working sets after which the last resort is tried. Few problems need more than ten, and those that do have many levels of
/// inequality rows, for which Clarabel is faster.
const MAX_SETS_BEFORE_LAST_RESORT: u32 = 60;

/// The hierarchical solver, with Clarabel's working set as the last resort.
#[derive(Default)]
pub struct Engine {
    exact: HierarchicalSolver,
    clarabel: ClarabelLevels,
    /// Problems for which the last resort was tried since [`Self::start`].
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
        origins: &[Origin],
        guess: Option<&WorkingSet>,
        solution: &mut Solution,
    ) {
        let exact = self.exact.of_width(problem.unknowns);
        exact.solve(problem, guess, MAX_SETS_BEFORE_LAST_RESORT, solution);
        if !solution.is_optimal {
            self.try_harder(problem, solution);
        }
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
        exact.solve_within(bounds, Some(guess), MAX_SETS_BEFORE_LAST_RESORT, solution);
    }

    /// Solves a problem from Clarabel's working set, and from nothing with all working sets that it may take. Where rounding
    /// may have decided a rank, the second one comes first: Clarabel's set may be of another rank.
    #[cold]
    fn try_harder(&mut self, problem: &Hierarchy, solution: &mut Solution) {
        for is_clarabel in [!solution.rank_uncertain, solution.rank_uncertain] {
            let tried = solution.working_sets;
            if is_clarabel {
                self.last_resorts += 1;
                self.clarabel.solve(problem, &mut self.exact, solution);
            } else {
                self.exact.solve(problem, None, solution);
            }
            solution.working_sets += tried;
            if solution.is_optimal {
                return;
            }
        }
    }
}

//! The two solvers of a hierarchical problem behind one interface.

use super::clarabel::{ClarabelCounts, ClarabelLevels};
use super::level::{Hierarchy, Solution, WorkingSet};
use super::problem::Solver;
use super::solver::HierarchicalSolver;
use crate::limits::VelocityBox;

/// Working sets after which Clarabel's working set is tried. Few problems need more than ten, and those that do have many
/// levels of inequality rows, for which Clarabel is faster.
const MAX_SETS_BEFORE_CLARABEL: u32 = 60;

/// The hierarchical solver, or Clarabel level by level in front of it.
#[derive(Default)]
pub struct Engine {
    exact: HierarchicalSolver,
    clarabel: ClarabelLevels,
    uses_clarabel: bool,
}

impl Engine {
    /// Chooses the solver of the next problems and sets the counts of Clarabel to zero.
    pub fn choose(&mut self, solver: Solver) {
        self.uses_clarabel = solver == Solver::Qp;
        self.clarabel.counts = ClarabelCounts::default();
    }

    /// Returns the hierarchical solver.
    pub fn exact(&mut self) -> &mut HierarchicalSolver {
        &mut self.exact
    }

    /// Returns whether Clarabel is in use, and its counts since [`Self::choose`].
    pub fn clarabel_counts(&self) -> Option<ClarabelCounts> {
        self.uses_clarabel.then_some(self.clarabel.counts)
    }

    /// Solves a problem; `guess` is the working set that the hierarchical solver starts from.
    pub fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, solution: &mut Solution) {
        if self.uses_clarabel {
            self.clarabel.solve(problem, &mut self.exact, solution);
            return;
        }
        let exact = self.exact.of_width(problem.unknowns);
        exact.solve(problem, guess, MAX_SETS_BEFORE_CLARABEL, solution);
        if !solution.is_optimal {
            self.try_harder(problem, solution);
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
        exact.solve_within(bounds, Some(guess), MAX_SETS_BEFORE_CLARABEL, solution);
    }

    /// Solves a problem from Clarabel's working set, and from nothing with all working sets that it may take. Where rounding
    /// may have decided a rank, the second one comes first: `auto` and `qp` then decide alike.
    #[cold]
    fn try_harder(&mut self, problem: &Hierarchy, solution: &mut Solution) {
        for is_clarabel in [!solution.rank_uncertain, solution.rank_uncertain] {
            let tried = solution.working_sets;
            if is_clarabel {
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

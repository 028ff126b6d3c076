//! The two solvers of a hierarchical problem behind one interface.

use super::clarabel::{ClarabelCounts, ClarabelLevels};
use super::level::{Hierarchy, Solution, WorkingSet};
use super::problem::Solver;
use super::solver::{HierarchicalSolver, LevelSolver};

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
}

impl Engine {
    /// Replaces a solution that is not certified by the one on Clarabel's working set, if that is certified.
    #[cold]
    fn ask_clarabel(&mut self, problem: &Hierarchy, solution: &mut Solution) {
        let mut other = Solution::default();
        self.clarabel.solve(problem, &mut self.exact, &mut other);
        if other.is_optimal {
            other.working_sets += solution.working_sets;
            *solution = other;
        }
    }
}

impl LevelSolver for Engine {
    fn solve(&mut self, problem: &Hierarchy, guess: Option<&WorkingSet>, solution: &mut Solution) {
        if self.uses_clarabel {
            self.clarabel.solve(problem, &mut self.exact, solution);
        } else {
            self.exact.solve(problem, guess, solution);
            if !solution.is_optimal {
                self.ask_clarabel(problem, solution);
            }
        }
    }
}

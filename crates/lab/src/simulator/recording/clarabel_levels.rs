//! What Clarabel did in a run with the solver `qp`, as its answers report it.

use revprio_api::wire::SolverLevel;
use serde::{Deserialize, Serialize};

/// Largest relative residual of a level that Clarabel solved precisely, before the polish.
///
/// Clarabel's tolerance for gap and feasibility is 1e-10. Its residual is larger where a bound is hardly active.
/// `docs/testing.md` has the measured shares.
pub const PRECISE: f64 = 1e-6;

/// The levels that Clarabel solved in a run, and how accurate its own answers were.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ClarabelLevels {
    /// Answers with at least one level that Clarabel solved.
    pub answers: u64,
    /// Levels that Clarabel solved or failed to solve. Levels that had nothing to decide do not count.
    pub count: u64,
    /// Its iterations over all levels.
    pub iterations: u64,
    /// Levels whose residual before the polish is above [`PRECISE`] or missing.
    pub imprecise: u64,
    /// Largest relative residual of the optimality conditions before the polish.
    pub largest_residual: f64,
    /// The same after the polish, one linear solve on Clarabel's active set.
    pub largest_polished: f64,
}

impl ClarabelLevels {
    /// Adds the levels of an answer.
    pub fn add(&mut self, levels: &[SolverLevel]) {
        let solved = || levels.iter().filter(|level| level.iterations > 0);
        self.answers += u64::from(solved().next().is_some());
        for level in solved() {
            self.count += 1;
            self.iterations += u64::from(level.iterations);
            self.imprecise += u64::from(!level.clarabel_residual.is_some_and(|residual| residual <= PRECISE));
            self.largest_residual = self.largest_residual.max(level.clarabel_residual.unwrap_or(0.0));
            self.largest_polished = self.largest_polished.max(level.residual.unwrap_or(0.0));
        }
    }

    /// Returns the levels of two runs together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            answers: self.answers + other.answers,
            count: self.count + other.count,
            iterations: self.iterations + other.iterations,
            imprecise: self.imprecise + other.imprecise,
            largest_residual: self.largest_residual.max(other.largest_residual),
            largest_polished: self.largest_polished.max(other.largest_polished),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(iterations: u32, clarabel_residual: f64, residual: f64) -> SolverLevel {
        SolverLevel { iterations, clarabel_residual: Some(clarabel_residual), residual: Some(residual) }
    }

    #[test]
    fn levels_with_nothing_to_decide_do_not_count() {
        let mut levels = ClarabelLevels::default();
        levels.add(&[]);
        levels.add(&[level(0, 0.0, 0.0)]);
        assert_eq!(levels, ClarabelLevels::default());
        levels.add(&[level(5, 1e-9, 1e-15), level(0, 0.0, 0.0), level(7, 2e-6, 1e-16)]);
        levels.add(&[SolverLevel { iterations: 50, clarabel_residual: None, residual: None }]);
        let expected = ClarabelLevels {
            answers: 2,
            count: 3,
            iterations: 62,
            imprecise: 2,
            largest_residual: 2e-6,
            largest_polished: 1e-15,
        };
        assert_eq!(levels, expected);
        assert_eq!(levels.and(ClarabelLevels::default()), levels);
        assert_eq!((levels.and(levels).count, levels.and(levels).largest_residual), (6, 2e-6));
    }
}

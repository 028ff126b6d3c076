//! What Clarabel did in a run with the solver `qp`, as its answers report it.

use revprio_api::wire::SolverLevel;
use serde::{Deserialize, Deserializer, Serialize};

/// Largest relative residual of a level that Clarabel solved precisely, before the polish.
///
/// Clarabel's tolerance for gap and feasibility is 1e-10. Its residual is larger where a bound is hardly active.
/// `docs/testing.md` has the measured shares.
pub const PRECISE: f64 = 1e-6;

/// The levels that Clarabel solved in a run, and how accurate its own answers were.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ClarabelLevels {
    /// Answers with at least one level that was given to Clarabel.
    pub answers: u64,
    /// Levels that Clarabel solved or failed to solve. Levels that were not given to it do not count.
    pub count: u64,
    /// Its iterations over all levels.
    pub iterations: u64,
    /// Levels whose residual before the polish is above [`PRECISE`] or missing.
    pub imprecise: u64,
    /// Largest relative residual of the optimality conditions before the polish; infinite if a level has no answer.
    #[serde(deserialize_with = "infinite_if_null")]
    pub largest_residual: f64,
    /// The same after the polish, one linear solve on Clarabel's active set.
    #[serde(deserialize_with = "infinite_if_null")]
    pub largest_polished: f64,
}

/// JSON has no infinite numbers; they are written as `null`.
fn infinite_if_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

impl ClarabelLevels {
    /// Adds the levels of an answer.
    pub fn add(&mut self, levels: &[SolverLevel]) {
        let posed = || levels.iter().filter(|level| is_posed(level));
        self.answers += u64::from(posed().next().is_some());
        for level in posed() {
            let [before, after] = [level.clarabel_residual, level.residual].map(|known| known.unwrap_or(f64::INFINITY));
            self.count += 1;
            self.iterations += u64::from(level.iterations);
            self.imprecise += u64::from(before > PRECISE);
            self.largest_residual = self.largest_residual.max(before);
            self.largest_polished = self.largest_polished.max(after);
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

/// Returns whether a level was given to Clarabel.
///
/// The answer of a level that the levels above have decided has no iterations and a residual of exactly 0. Clarabel also
/// ends without an iteration where its start is optimal, with a residual near rounding, or where it fails at once, without
/// a residual.
fn is_posed(level: &SolverLevel) -> bool {
    level.iterations > 0 || level.clarabel_residual != Some(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(iterations: u32, clarabel_residual: f64, residual: f64) -> SolverLevel {
        SolverLevel { iterations, clarabel_residual: Some(clarabel_residual), residual: Some(residual) }
    }

    #[test]
    fn levels_that_the_levels_above_have_decided_do_not_count() {
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
            largest_residual: f64::INFINITY,
            largest_polished: f64::INFINITY,
        };
        assert_eq!(levels, expected);
        assert_eq!(levels.and(ClarabelLevels::default()), levels);
        assert_eq!((levels.and(levels).count, levels.and(levels).imprecise), (6, 4));
    }

    #[test]
    fn levels_that_clarabel_ended_without_an_iteration_count() {
        let mut levels = ClarabelLevels::default();
        levels.add(&[level(0, 2.6e-18, 2.6e-18)]);
        assert_eq!((levels.answers, levels.count, levels.imprecise), (1, 1, 0));
        assert_eq!((levels.largest_residual, levels.largest_polished), (2.6e-18, 2.6e-18));
        levels.add(&[SolverLevel { iterations: 0, clarabel_residual: None, residual: None }]);
        assert_eq!((levels.answers, levels.count, levels.imprecise), (2, 2, 1));
        assert_eq!((levels.largest_residual, levels.largest_polished), (f64::INFINITY, f64::INFINITY));
        let stored = serde_json::to_string(&levels).unwrap();
        assert_eq!(serde_json::from_str::<ClarabelLevels>(&stored).unwrap(), levels, "{stored}");
    }
}

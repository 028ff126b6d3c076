//! Which runs are compared with each other, and when two runs count as the same.

use revprio_api::wire::{Method, Solver};

use super::run::Run;
use crate::metrics::largest_difference;
use crate::simulator::recording::Recording;

/// The method that the paper proposes.
pub const REVERSE_PRIORITY: Method = Method::ReversePriority;
/// The classical control that the paper compares it with.
pub const CLASSICAL: Method = Method::DampedLeastSquares;

/// Runs whose commands differ by at most this (rad/s) count as the same.
const COINCIDENCE: f64 = 1e-9;

/// The runs of the paper's two methods in one scenario.
#[derive(Debug, Clone, Copy)]
pub struct MethodPair<'a> {
    /// Reverse priority.
    pub reverse: &'a Run,
    /// The classical control.
    pub classical: &'a Run,
}

impl<'a> MethodPair<'a> {
    /// Selects the two runs; `None` if one of the methods was not run.
    #[must_use]
    pub fn from_runs(runs: &'a [Run]) -> Option<Self> {
        let of_method = |method| {
            let runs = runs.iter().filter(|run| run.recording.method == method);
            runs.min_by_key(|run| solver_preference(&run.recording))
        };
        Some(Self { reverse: of_method(REVERSE_PRIORITY)?, classical: of_method(CLASSICAL)? })
    }

    /// Returns whether both runs are those of a built-in scenario or of its beginning.
    #[must_use]
    pub fn is_built_in(&self) -> bool {
        self.reverse.is_built_in() && self.classical.is_built_in()
    }

    /// Returns the largest difference of the commands (rad/s).
    #[must_use]
    pub fn difference(&self) -> f64 {
        largest_difference(&self.reverse.recording, &self.classical.recording)
    }

    /// Returns whether both runs have the same commands.
    #[must_use]
    pub fn coincide(&self) -> bool {
        self.difference() <= COINCIDENCE
    }
}

/// Sorts the run that represents a method first: the closed form, if it was run.
#[must_use]
pub fn solver_preference(recording: &Recording) -> bool {
    recording.solver != Solver::ClosedForm
}

/// Groups runs with the same commands, in the order of the first run of each group.
#[must_use]
pub fn group_coinciding<'a>(runs: &[&'a Recording]) -> Vec<Vec<&'a Recording>> {
    let mut groups: Vec<Vec<&Recording>> = Vec::new();
    for run in runs {
        match groups.iter_mut().find(|group| largest_difference(group[0], run) <= COINCIDENCE) {
            Some(group) => group.push(run),
            None => groups.push(vec![run]),
        }
    }
    groups
}

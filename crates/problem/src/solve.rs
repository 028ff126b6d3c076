//! The trait of all solvers.

use crate::{ActiveSet, Problem, ProblemError, Resolution};

/// A solver of prioritised problems. It may keep memory from call to call; its answers must not depend on that memory.
pub trait Solve: Send {
    /// Solves a problem and overwrites `answer`; `guess` are the active limits of the period before (empty: none).
    ///
    /// A numerical failure is not an error but an answer with a status: the control loop needs a safe command either way.
    fn solve(&mut self, problem: &Problem, guess: &[ActiveSet], answer: &mut Resolution) -> Result<(), ProblemError>;

    /// Returns whether answers keep the limits. If not, do not move an arm with them.
    fn keeps_limits(&self) -> bool;
}

//! Why stability margins are missing.

use super::spectrum::EigenvalueError;

/// The reason why margins are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StabilityError {
    /// The eigenvalues of the loop cannot be computed.
    #[error(transparent)]
    Eigenvalues(#[from] EigenvalueError),
    /// The caller stopped the computation.
    #[error("the computation was stopped")]
    Stopped,
}

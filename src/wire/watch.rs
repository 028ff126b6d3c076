//! `GET /v1/controllers/{id}/watch`: what passes through a session.

use serde::{Deserialize, Serialize};

use super::{State, StepAnswer};

/// One control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WatchedStep {
    /// What was measured.
    pub state: State,
    /// What was answered.
    pub answer: StepAnswer,
}

//! `GET /v1/controllers/{id}/watch`: what passes through a session.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{State, StepAnswer};

/// One control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WatchedStep {
    /// What was measured.
    pub state: State,
    /// What was answered.
    pub answer: StepAnswer,
}

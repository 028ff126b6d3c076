//! `GET /v1/controllers/{id}/watch`: what passes through a session.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{ArmView, State, StepAnswer};

/// One control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct WatchedStep {
    /// What was measured.
    pub state: State,
    /// What was answered.
    pub answer: StepAnswer,
    /// The arm at that state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm: Option<ArmView>,
}

//! `POST /v1/resolve/batch`: many stateless questions at once.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{Problem, ResolveAnswer, ResolveRequest};

/// Problems that have nothing to do with each other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BatchRequest {
    /// The problems, 10 000 at most.
    #[serde(deserialize_with = "object::list")]
    pub items: Vec<ResolveRequest>,
}

/// What became of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct BatchAnswer {
    /// One answer or problem for each, in the order of the request.
    pub items: Vec<BatchItem>,
}

/// What became of one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(untagged)]
pub enum BatchItem {
    /// As `POST /v1/resolve` answers.
    Answer(Box<ResolveAnswer>),
    /// As `POST /v1/resolve` refuses; the pointer is one into the whole batch.
    Problem(Problem),
}

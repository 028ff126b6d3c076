//! One function per route: it reads the request, makes one call, and converts the result.

pub mod analysis;
pub mod control;
pub mod docs;
pub mod operation;
pub mod page;
pub mod resolve;
pub mod robots;
pub mod simulation;

use std::sync::Arc;

use axum::extract::{FromRequestParts, Path, State};
use axum::http::request::Parts;

use super::error::ApiError;
use super::state::AppState;

/// Extracts the state that all handlers share.
type Shared = State<Arc<AppState>>;

/// Extracts the variable part of a path, `{…}` in the route. An error is a problem instead of axum's rejection.
pub struct Segment(pub String);

impl<S: Send + Sync> FromRequestParts<S> for Segment {
    type Rejection = ApiError;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        match Path::from_request_parts(parts, state).await {
            Ok(Path(text)) => Ok(Self(text)),
            Err(_) => Err(ApiError::not_found("the path is not UTF-8; no robot or controller has such a name")),
        }
    }
}

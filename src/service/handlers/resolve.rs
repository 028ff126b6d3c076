//! One problem, or many.

use axum::extract::State;
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, Body, LargeAnswer, LargeBody};
use crate::service::error::ApiError;
use crate::service::resolve;

/// Resolves one problem.
///
/// Joint velocities for prioritised tasks at one posture, without any memory.
#[utoipa::path(
    post,
    path = "/v1/resolve",
    tag = "resolve",
    request_body = wire::ResolveRequest,
    responses(
        (status = 200, body = wire::ResolveAnswer, description = "Joint velocities and why they are what they are.")
    )
)]
pub async fn resolve(
    State(app): Shared,
    Body(request): Body<wire::ResolveRequest>,
) -> Result<Answer<wire::ResolveAnswer>, ApiError> {
    resolve::one(&request, &app).map(Answer)
}

/// Resolves many problems.
///
/// Up to 10 000 problems that have nothing to do with each other; each is answered or refused for itself, in order.
#[utoipa::path(
    post,
    path = "/v1/resolve/batch",
    tag = "resolve",
    request_body = wire::BatchRequest,
    responses(
        (
            status = 200,
            body = wire::BatchAnswer,
            description = "One answer or problem for each item, in the order of the request."
        )
    )
)]
pub async fn resolve_batch(
    State(app): Shared,
    body: LargeBody<wire::BatchRequest>,
) -> Result<LargeAnswer<wire::BatchAnswer>, ApiError> {
    resolve::batch(body, &app).await.map(LargeAnswer)
}

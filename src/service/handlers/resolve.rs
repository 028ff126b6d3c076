//! Stateless resolution of one problem or a batch.

use axum::extract::State;
use revprio_api::wire;

use super::Shared;
use crate::service::body::{Answer, LargeAnswer, LargeBody};
use crate::service::error::ApiError;
use crate::service::format::RawBody;
use crate::service::resolve;

/// Resolves one problem.
///
/// Joint velocities for prioritised tasks at one posture, without memory.
#[utoipa::path(
    post,
    path = "/v1/resolve",
    tag = "resolve",
    request_body = wire::ResolveRequest,
    responses(
        (status = 200, body = wire::ResolveAnswer, description = "Joint velocities, with tasks, limits and solver report.")
    )
)]
pub async fn resolve(State(app): Shared, body: RawBody) -> Result<Answer<wire::ResolveAnswer>, ApiError> {
    resolve::single(body, &app).await.map(Answer)
}

/// Resolves a batch of problems.
///
/// Up to 10 000 independent problems. Each item is answered or refused on its own, in order.
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

//! What operators ask.

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;

use super::Shared;
use crate::service::error::ApiError;

/// Says that the service lives.
///
/// For supervisors that start it again when it does not; always answered, without a token.
#[utoipa::path(
    get,
    path = "/healthz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ok`."))
)]
pub async fn alive() -> &'static str {
    "ok"
}

/// Says that the service takes requests.
///
/// For load balancers; always answered, without a token. Not ready once the service is about to end.
#[utoipa::path(
    get,
    path = "/readyz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ready`."))
)]
pub async fn ready(State(app): Shared) -> Result<&'static str, ApiError> {
    if app.drain.is_announced() { Err(ApiError::draining()) } else { Ok("ready") }
}

/// Shows the metrics.
///
/// For Prometheus: requests, refusals, solver paths, sessions, connections.
#[utoipa::path(
    get,
    path = "/metrics",
    tag = "operation",
    responses((status = 200, body = String, content_type = "application/openmetrics-text", description = "OpenMetrics."))
)]
pub async fn metrics(State(app): Shared) -> impl IntoResponse {
    let media_type = "application/openmetrics-text; version=1.0.0; charset=utf-8";
    ([(header::CONTENT_TYPE, media_type)], app.metrics.text(app.sessions.count(), app.connections.count()))
}

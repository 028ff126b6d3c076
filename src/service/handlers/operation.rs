//! Routes for operators: probes and metrics.

use axum::extract::State;
use axum::http::header;
use axum::response::IntoResponse;

use super::Shared;
use crate::service::error::ApiError;

/// Returns whether the service is alive.
///
/// For supervisors that restart the service. Answered under any load and without a token. While the thread of the requests
/// is stuck, another thread answers new connections with 503: `stuck`.
#[utoipa::path(
    get,
    path = "/healthz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ok`."))
)]
pub async fn alive() -> &'static str {
    "ok"
}

/// Returns whether the service is ready for requests.
///
/// For load balancers. Answered under any load and without a token. Not ready while the service shuts down.
#[utoipa::path(
    get,
    path = "/readyz",
    tag = "operation",
    responses((status = 200, body = String, content_type = "text/plain", description = "`ready`."))
)]
pub async fn ready(State(app): Shared) -> Result<&'static str, ApiError> {
    if app.drain.is_announced() { Err(ApiError::draining()) } else { Ok("ready") }
}

/// Returns the metrics.
///
/// For Prometheus. All names begin with `revprio_`: `requests_total` and `request_duration_seconds` by route, `problems_total`,
/// `connection_faults_total`, `resolutions_total` by solver path and status, `last_resorts_total`, `clarabel_iterations_total`,
/// `clarabel_failures_total`, `missed_periods_total`, `panics_total`, `log_lines_dropped_total`, `sessions`, `connections`.
/// `revprio_last_resorts_total` counts problems for which the solver `auto` changed one active limit at a time.
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

//! The outermost layer: every request and every answer passes it.

use std::any::Any;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::FutureExt;

use super::error::ApiError;
use super::request_id::REQUEST_ID;
use super::state::AppState;
use super::{access, body};
use crate::dashboard;

/// Admits or refuses a request, gives it an ID, counts it and logs it.
///
/// A stream is admitted and counted once, at its start.
pub async fn gate(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    let arrived = Instant::now();
    let id = app.request_ids.for_request(request.headers());
    let route = app.metrics.route(request.extensions().get().map(MatchedPath::as_str));
    let is_logged = tracing::enabled!(tracing::Level::DEBUG);
    let logged = is_logged.then(|| (request.method().clone(), request.uri().clone()));
    let mut response = match admit(&app, &request, arrived) {
        Ok(()) => {
            let answer = AssertUnwindSafe(body::encode_answers(request, next)).catch_unwind().await;
            answer.unwrap_or_else(|panic| panic_answer(&app, &id, &*panic))
        }
        Err(error) => error.into_response(),
    };
    let id_text = id.to_str().unwrap_or_default();
    if let Some(error) = response.extensions_mut().remove::<ApiError>() {
        app.metrics.count_problem(error.kind());
        error.write(&mut response, id_text);
    }
    let duration = arrived.elapsed();
    app.metrics.count_answer(&route, response.status(), duration);
    if let Some((method, uri)) = logged {
        let status = response.status().as_u16();
        tracing::debug!(request_id = id_text, status, elapsed_us = duration.as_secs_f64() * 1e6, "{method} {uri}");
    }
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REQUEST_ID, id);
    response
}

/// Returns the answer for a handler that panicked. Other requests continue.
fn panic_answer(app: &AppState, id: &HeaderValue, panic: &(dyn Any + Send)) -> Response {
    app.metrics.panics.inc();
    let message = panic.downcast_ref::<String>().map(String::as_str);
    let message = message.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    tracing::error!(request_id = id.to_str().unwrap_or_default(), "a handler panicked: {message}");
    ApiError::internal().into_response()
}

/// Checks origin, token and load. Probes pass without any check, and metrics pass under any load.
fn admit(app: &AppState, request: &Request, arrived: Instant) -> Result<(), ApiError> {
    let path = request.uri().path();
    if matches!(path, "/healthz" | "/readyz") {
        return Ok(());
    }
    access::check_origin(&app.config, request.headers())?;
    if !dashboard::is_page(path) {
        access::check_token(&app.config, request.headers())?;
    }
    if path == "/metrics" || app.admission_queue.admits(arrived, app.config.max_lag) {
        Ok(())
    } else {
        Err(ApiError::overloaded())
    }
}

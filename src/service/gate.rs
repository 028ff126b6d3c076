//! The outermost layer: every request and every answer passes it.

use std::any::Any;
use std::net::{IpAddr, SocketAddr};
use std::panic::AssertUnwindSafe;
use std::sync::Arc;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::FutureExt;
use tokio::time::Instant;

use super::error::ApiError;
use super::request_id::REQUEST_ID;
use super::state::AppState;
use super::{access, body, host};
use crate::dashboard;

/// The address that accepted the connection of a request.
#[derive(Debug, Clone, Copy)]
pub struct LocalAddress(pub IpAddr);

/// The address of the client.
#[derive(Debug, Clone, Copy)]
pub struct PeerAddress(pub SocketAddr);

/// Checks the form of a request, gives it an ID, counts it and logs it. While the service shuts down, the answer asks the
/// client to connect elsewhere.
///
/// A stream is counted once, at its start.
pub async fn gate(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    let arrived = Instant::now();
    let id = app.request_ids.for_request(request.headers());
    let route = app.metrics.route(request.extensions().get().map(MatchedPath::as_str));
    let is_logged = tracing::enabled!(tracing::Level::DEBUG);
    let logged = is_logged.then(|| (request.method().clone(), request.uri().clone()));
    let mut response = match check_form(&app, &request) {
        Ok(()) => {
            let answer = AssertUnwindSafe(body::encode_answers(request, next)).catch_unwind().await;
            answer.unwrap_or_else(|panic| panic_answer(&app, &id, &*panic))
        }
        Err(error) => closing(error.into_response()),
    };
    if app.drain.is_announced() && response.status() != StatusCode::SWITCHING_PROTOCOLS {
        response = closing(response);
    }
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

/// Makes the answer the last one of its connection.
fn closing(mut response: Response) -> Response {
    response.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
    response
}

/// Checks host and encodings, on every route.
fn check_form(app: &AppState, request: &Request) -> Result<(), ApiError> {
    let local = request.extensions().get().map(|LocalAddress(address)| *address);
    host::check(request.headers(), request.uri(), local, &app.config.allowed_hosts)?;
    access::check_codings(request.headers())
}

/// Admits or refuses a request. A stream is admitted once, at its start.
pub async fn admission(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    match admit(&app, &request, Instant::now()) {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    }
}

/// Checks origin, token and load. Probes pass without any check, and metrics pass under any load.
fn admit(app: &AppState, request: &Request, arrived: Instant) -> Result<(), ApiError> {
    let path = request.uri().path();
    if matches!(path, "/healthz" | "/readyz") {
        return Ok(());
    }
    access::check_origin(&app.config, request.headers())?;
    if !dashboard::is_page(path) && !access::has_token(&app.config, request.headers()) {
        return Err(failure(app, request, arrived));
    }
    if path == "/metrics" || app.admission_queue.admits(arrived, app.config.max_lag) {
        Ok(())
    } else {
        Err(ApiError::overloaded())
    }
}

/// Logs a missing or wrong token, unless there were too many.
fn failure(app: &AppState, request: &Request, now: Instant) -> ApiError {
    let Some(suppressed) = app.failures.count(now) else { return ApiError::too_many_failures() };
    let peer = request.extensions().get().map(|PeerAddress(address)| address.to_string()).unwrap_or_default();
    let has_one = request.headers().contains_key(header::AUTHORIZATION);
    let cause = if has_one { "wrong token" } else { "no token" };
    tracing::info!(peer, suppressed, "refused, {cause}: {} {}", request.method(), request.uri().path());
    ApiError::unauthorized()
}

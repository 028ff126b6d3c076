//! What every request passes on its way in and every answer on its way out.

use std::any::Any;
use std::fmt;
use std::panic::AssertUnwindSafe;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::FutureExt;

use super::access;
use super::app::AppState;
use super::body;
use super::error::ApiError;
use crate::dashboard;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Longest name of a request that is taken over from the client.
const LONGEST_ID: usize = 64;

/// Names requests, so that answers, problems and log lines can be told together.
#[derive(Debug)]
pub struct RequestIds {
    /// Differs from process to process.
    prefix: String,
    next: AtomicU64,
}

impl Default for RequestIds {
    fn default() -> Self {
        let prefix = uuid::Uuid::new_v4().simple().to_string()[..8].to_owned();
        Self { prefix, next: AtomicU64::new(1) }
    }
}

impl RequestIds {
    /// The client's name if it is a short word, a new one otherwise.
    fn of(&self, headers: &HeaderMap) -> HeaderValue {
        let sane = |id: &&HeaderValue| {
            let word = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.:".contains(byte);
            (1..=LONGEST_ID).contains(&id.len()) && id.as_bytes().iter().all(word)
        };
        headers.get(REQUEST_ID).filter(sane).cloned().unwrap_or_else(|| {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            HeaderValue::try_from(format!("{}-{number}", self.prefix)).unwrap_or(HeaderValue::from_static("none"))
        })
    }
}

/// Lets a request in or refuses it; names, counts and logs it.
///
/// Streams are let in and counted once; how long they live does not matter here.
pub async fn gate(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    let arrived = Instant::now();
    let id = app.request_ids.of(request.headers());
    let route = app.metrics.route(request.extensions().get().map(MatchedPath::as_str));
    let call = tracing::enabled!(tracing::Level::DEBUG).then(|| Call::of(&request));
    let mut response = match admitted(&app, &request, arrived) {
        Ok(()) => {
            let answer = AssertUnwindSafe(body::written(request, next)).catch_unwind().await;
            answer.unwrap_or_else(|panic| panicked(&app, &id, &*panic))
        }
        Err(problem) => problem.into_response(),
    };
    let shown_id = id.to_str().unwrap_or_default();
    if let Some(problem) = response.extensions_mut().remove::<ApiError>() {
        app.metrics.refused(problem.kind());
        problem.write(&mut response, shown_id);
    }
    let duration = arrived.elapsed();
    app.metrics.answered(&route, response.status(), duration);
    if let Some(call) = call {
        let status = response.status().as_u16();
        tracing::debug!(request_id = shown_id, status, elapsed_us = duration.as_secs_f64() * 1e6, "{call}");
    }
    let headers = response.headers_mut();
    headers.insert(header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REQUEST_ID, id);
    response
}

/// The answer for a handler that panicked. What it shares with others is replaced whole, so it is still consistent.
fn panicked(app: &AppState, id: &HeaderValue, panic: &(dyn Any + Send)) -> Response {
    app.metrics.panics.inc();
    let words = panic.downcast_ref::<String>().map(String::as_str);
    let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without words");
    tracing::error!(request_id = id.to_str().unwrap_or_default(), "a handler panicked: {words}");
    ApiError::internal().into_response()
}

/// Probes are always answered and metrics even under load; everything else waits in line.
fn admitted(app: &AppState, request: &Request, arrived: Instant) -> Result<(), ApiError> {
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

/// What an access log says of a request.
struct Call(Method, Uri);

impl Call {
    fn of(request: &Request) -> Self {
        Self(request.method().clone(), request.uri().clone())
    }
}

impl fmt::Display for Call {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{} {}", self.0, self.1)
    }
}

//! The outermost layer: every request and every answer passes it.

use std::any::Any;
use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::panic::AssertUnwindSafe;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use axum::extract::{MatchedPath, Request, State};
use axum::http::{HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures_util::FutureExt;
use tokio::time::Instant;
use tower_layer::Layer;
use tower_service::Service;

use super::body::AnswerEncoding;
use super::error::ApiError;
use super::metrics::Route;
use super::request_id::REQUEST_ID;
use super::state::AppState;
use super::{access, host};
use crate::dashboard;

/// The address that accepted the connection of a request.
#[derive(Debug, Clone, Copy)]
pub struct LocalAddress(pub IpAddr);

/// The address of the client.
#[derive(Debug, Clone, Copy)]
pub struct PeerAddress(pub SocketAddr);

/// Puts the gate before every route.
#[derive(Clone)]
pub struct GateLayer {
    /// The state that all requests share.
    pub app: Arc<AppState>,
    /// Whether the gate admits requests. Otherwise a layer behind it does: see [`admission`].
    pub admits: bool,
}

/// The gate before one route. It is a service of its own instead of a function that axum wraps, because each wrapped
/// function clones the whole route behind it for every request.
#[derive(Clone)]
pub struct Gate<S> {
    layer: GateLayer,
    inner: S,
}

impl<S> Layer<S> for GateLayer {
    type Service = Gate<S>;

    fn layer(&self, inner: S) -> Gate<S> {
        Gate { layer: self.clone(), inner }
    }
}

impl<S> Service<Request> for Gate<S>
where
    S: Service<Request, Response = Response, Error = Infallible>,
    S::Future: Send + 'static,
{
    type Response = Response;
    type Error = Infallible;
    type Future = Pin<Box<dyn Future<Output = Result<Response, Infallible>> + Send>>;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        self.inner.poll_ready(context)
    }

    /// Checks the form of a request, gives it an ID, admits it, counts it and logs it. While the service shuts down, the
    /// answer asks the client to connect elsewhere.
    ///
    /// A stream is counted once, at its start.
    fn call(&mut self, request: Request) -> Self::Future {
        let visit = Visit::begin(&self.layer.app, &request);
        let answer = match self.layer.check(&request, visit.arrived) {
            Ok(()) => Ok(self.inner.call(request)),
            Err(refusal) => Err(refusal),
        };
        Box::pin(async move {
            let response = match answer {
                Ok(answer) => visit.answer(answer).await,
                Err(refusal) => refusal,
            };
            Ok(visit.end(response))
        })
    }
}

impl GateLayer {
    /// Returns the answer for a request that the gate refuses.
    #[expect(clippy::result_large_err, reason = "the answer of a refusal is rare and goes out at once")]
    fn check(&self, request: &Request, arrived: Instant) -> Result<(), Response> {
        check_form(&self.app, request).map_err(|error| closing(error.into_response()))?;
        if self.admits { admit(&self.app, request, arrived).map_err(IntoResponse::into_response) } else { Ok(()) }
    }
}

/// What the gate knows of a request between its arrival and its answer.
struct Visit {
    app: Arc<AppState>,
    arrived: Instant,
    id: HeaderValue,
    route: Arc<Route>,
    encoding: AnswerEncoding,
    /// Method and target, if the log wants them.
    logged: Option<(Method, Uri)>,
}

impl Visit {
    fn begin(app: &Arc<AppState>, request: &Request) -> Self {
        let is_logged = tracing::enabled!(tracing::Level::DEBUG);
        Self {
            app: Arc::clone(app),
            arrived: Instant::now(),
            id: app.request_ids.for_request(request.headers()),
            route: app.metrics.route(request.extensions().get().map(MatchedPath::as_str)),
            encoding: AnswerEncoding::of(request.headers()),
            logged: is_logged.then(|| (request.method().clone(), request.uri().clone())),
        }
    }

    /// Waits for the answer of the route and encodes it.
    async fn answer(&self, answer: impl Future<Output = Result<Response, Infallible>>) -> Response {
        let encoded = async {
            let Ok(response) = answer.await;
            self.encoding.encode(response).await
        };
        let answer = AssertUnwindSafe(encoded).catch_unwind().await;
        answer.unwrap_or_else(|panic| panic_answer(&self.app, &self.id, &*panic))
    }

    /// Counts and logs the answer, and gives it the headers of all answers.
    fn end(self, mut response: Response) -> Response {
        let Self { app, arrived, id, route, logged, .. } = self;
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

/// Admits or refuses a request behind another layer, which answers preflight requests: they have no token.
pub async fn admission(State(app): State<Arc<AppState>>, request: Request, next: Next) -> Response {
    match admit(&app, &request, Instant::now()) {
        Ok(()) => next.run(request).await,
        Err(error) => error.into_response(),
    }
}

/// Checks origin, token and load. A stream is admitted once, at its start. Probes pass without any check, and metrics pass under any load.
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

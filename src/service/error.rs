//! Errors as HTTP answers; the only place that knows both.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;

use super::openapi::KINDS;

/// Media type of RFC 9457.
const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");

/// What a connection gets for which there is no room: a whole answer, as its request is not read.
pub fn no_room() -> String {
    let body = r#"{"type":"/problems/overloaded","title":"The service has too much to do","status":503,"detail":"too many connections are open; close some"}"#;
    let head = "HTTP/1.1 503 Service Unavailable\r\ncontent-type: application/problem+json\r\nretry-after: 1";
    format!("{head}\r\nconnection: close\r\ncontent-length: {}\r\n\r\n{body}", body.len())
}

/// A name as a part of a JSON pointer (RFC 6901).
pub fn escaped(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

/// A request that cannot be answered, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApiError {
    status: StatusCode,
    /// Last part of the `type` reference.
    kind: &'static str,
    title: &'static str,
    detail: String,
    pointer: Option<String>,
}

impl ApiError {
    fn new(status: StatusCode, kind: &'static str, title: &'static str, detail: impl Into<String>) -> Self {
        debug_assert!(KINDS.iter().any(|(_, known, ..)| *known == kind), "{kind} is described nowhere");
        Self { status, kind, title, detail: detail.into(), pointer: None }
    }

    /// 400: the body is neither JSON nor MessagePack, or holds a number that is not finite.
    pub fn malformed(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::BAD_REQUEST, "malformed", "The body cannot be read", detail)
    }

    /// The same problem at a JSON pointer.
    pub fn at(self, pointer: impl Into<String>) -> Self {
        Self { pointer: Some(pointer.into()), ..self }
    }

    /// 422: well-formed, but wrong at `pointer` (a JSON pointer).
    #[expect(clippy::needless_pass_by_value, reason = "errors and texts alike are made for this call")]
    pub fn invalid(pointer: impl Into<String>, detail: impl ToString) -> Self {
        let kind = "invalid";
        let problem =
            Self::new(StatusCode::UNPROCESSABLE_ENTITY, kind, "A field of the body is wrong", detail.to_string());
        Self { pointer: Some(pointer.into()), ..problem }
    }

    /// 401: the token is missing or wrong.
    pub fn unauthorized() -> Self {
        let detail = "send the service's token as `Authorization: Bearer …`";
        Self::new(StatusCode::UNAUTHORIZED, "unauthorized", "The token is missing or wrong", detail)
    }

    /// 403: a web page of another site makes the request.
    pub fn foreign_origin(origin: &str) -> Self {
        let detail = format!("pages of `{origin}` may not call this service; allow them with --allow-origin");
        Self::new(StatusCode::FORBIDDEN, "foreign-origin", "The origin is not allowed", detail)
    }

    /// 403: what belongs to the service cannot be deleted.
    pub fn permanent(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::FORBIDDEN, "permanent", "This cannot be deleted", detail)
    }

    /// 404: no such resource.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::NOT_FOUND, "not-found", "There is nothing here", detail)
    }

    /// 404: no such session, or no longer.
    pub fn unknown_controller(id: &str) -> Self {
        let detail = format!(
            "there is no controller `{id}`; it was deleted, idle for too long, or the service was started anew; create \
             it again with POST /v1/controllers"
        );
        Self::new(StatusCode::NOT_FOUND, "unknown-controller", "There is no such controller", detail)
    }

    /// 405: the route exists, the method does not.
    pub fn method_not_allowed() -> Self {
        let detail = "this route does not take that method; see the interface description";
        Self::new(StatusCode::METHOD_NOT_ALLOWED, "method-not-allowed", "The method is not allowed here", detail)
    }

    /// 406: the client takes none of what there is.
    pub fn not_acceptable(offered: &str) -> Self {
        let detail = format!("this can be had as {offered}; say which with `Accept`");
        Self::new(StatusCode::NOT_ACCEPTABLE, "not-acceptable", "Nothing to your taste", detail)
    }

    /// 409: a simulation that has no trace.
    pub fn no_trace(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, "no-trace", "There is no trace", detail)
    }

    /// 409: a simulation that takes no orders.
    pub fn not_live(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::CONFLICT, "not-live", "The simulation takes no orders", detail)
    }

    /// 426: a stream is asked for by plain HTTP.
    pub fn upgrade_required() -> Self {
        let detail = "this route speaks WebSocket (RFC 6455, version 13); ask for it with a WebSocket client";
        Self::new(StatusCode::UPGRADE_REQUIRED, "upgrade-required", "A WebSocket is needed", detail)
    }

    /// 408: the body did not come in time.
    pub fn body_timeout() -> Self {
        let detail = "the body did not arrive in time; send it whole and at once";
        Self::new(StatusCode::REQUEST_TIMEOUT, "timeout", "The request took too long", detail)
    }

    /// 409: the name belongs to something else.
    pub fn name_taken(detail: impl Into<String>) -> Self {
        let problem = Self::new(StatusCode::CONFLICT, "name-taken", "The name is taken", detail);
        Self { pointer: Some("/name".to_owned()), ..problem }
    }

    /// 409: a sequence number that does not grow.
    pub fn sequence(detail: impl Into<String>) -> Self {
        let problem = Self::new(StatusCode::CONFLICT, "sequence", "The sequence number does not fit", detail);
        Self { pointer: Some("/sequence".to_owned()), ..problem }
    }

    /// 413: the body is too large.
    pub fn too_large(limit: usize) -> Self {
        let detail = format!("a body may have at most {limit} bytes");
        Self::new(StatusCode::PAYLOAD_TOO_LARGE, "too-large", "The body is too large", detail)
    }

    /// 415: neither JSON nor MessagePack.
    pub fn media_type() -> Self {
        let detail = "send `Content-Type: application/json`, or `application/msgpack`";
        Self::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, "media-type", "The media type is not supported", detail)
    }

    /// 503: too many sessions.
    pub fn too_many_sessions(limit: usize) -> Self {
        let detail = format!("{limit} controllers are open already; delete one, or wait until an idle one ends");
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "too-many-controllers", "No room for another controller", detail)
    }

    /// 503: too many registered robots.
    pub fn too_many_robots(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "too-many-robots", "No room for another robot", detail)
    }

    /// 503: as much long work as there is room for.
    pub fn busy(detail: impl Into<String>) -> Self {
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "busy", "The service is busy", detail)
    }

    /// 503: more requests wait than can be answered in time.
    pub fn overloaded() -> Self {
        let detail = "more requests wait than can be answered in time; send fewer, or start another server";
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "overloaded", "The service has too much to do", detail)
    }

    /// 503: many large bodies are being read.
    pub fn too_many_bodies() -> Self {
        let detail = "other large bodies are being read; try again, or send a smaller one";
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "overloaded", "The service has too much to do", detail)
    }

    /// 503: the service is about to end.
    pub fn draining() -> Self {
        let detail = "the service is about to end; call another one";
        Self::new(StatusCode::SERVICE_UNAVAILABLE, "draining", "The service is about to end", detail)
    }

    /// 500: a defect of the service.
    pub fn internal() -> Self {
        let detail = "a defect of the service, not of your request; the log has the details";
        Self::new(StatusCode::INTERNAL_SERVER_ERROR, "internal", "The service failed", detail)
    }

    /// The same problem, seen from a body in which the offending object stands at `prefix`.
    pub fn inside(self, prefix: &str) -> Self {
        Self { pointer: self.pointer.map(|pointer| format!("{prefix}{pointer}")), ..self }
    }

    /// Whether what the request speaks of does not exist.
    pub fn is_not_found(&self) -> bool {
        self.status == StatusCode::NOT_FOUND
    }

    /// Last part of the `type` reference.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// As a part of an answer that holds others, or as a message of a stream.
    pub fn into_wire(self) -> wire::Problem {
        wire::Problem {
            kind: format!("/problems/{}", self.kind),
            title: self.title.to_owned(),
            status: self.status.as_u16(),
            detail: self.detail,
            pointer: self.pointer,
            request_id: None,
        }
    }

    /// Writes the body of the answer to a request of that name.
    pub fn write(self, response: &mut Response, request_id: &str) {
        let body = wire::Problem { request_id: Some(request_id.to_owned()), ..self.into_wire() };
        // The layers below took the length of the body that it does not have yet.
        response.headers_mut().remove(header::CONTENT_LENGTH);
        *response.body_mut() = axum::Json(body).into_response().into_body();
    }
}

/// The head of the answer; the body, which names the request, is written at the gate.
impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let mut response = self.status.into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, PROBLEM_JSON);
        if self.status == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
        }
        if self.status == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        if self.status == StatusCode::UPGRADE_REQUIRED {
            headers.insert(header::UPGRADE, HeaderValue::from_static("websocket"));
        }
        response.extensions_mut().insert(self);
        response
    }
}

//! The error type of the service, and its form in HTTP answers.
//!
//! No other module sets the status code of an error or writes the body of a problem (RFC 9457).

#[cfg(feature = "axum")]
mod answer;
mod kinds;

use std::fmt;
use std::time::Duration;

use http::StatusCode;
use revprio_api::wire;

#[cfg(feature = "axum")]
pub use answer::{connection_refusal, stuck_refusal};
pub use kinds::{KINDS, Kind};

/// Escapes a name for use in a JSON pointer (RFC 6901).
pub fn escape_pointer(name: &str) -> String {
    name.replace('~', "~0").replace('/', "~1")
}

/// A refused request and the reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApiError {
    kind: &'static Kind,
    detail: String,
    /// JSON pointer to the wrong field.
    pointer: Option<String>,
    /// Possible values of the wrong field, best first.
    candidates: Vec<String>,
}

impl ApiError {
    /// Maximum number of candidates in an answer.
    const MAX_CANDIDATES: usize = 100;

    fn new(kind: &'static Kind, detail: impl Into<String>) -> Self {
        Self { kind, detail: detail.into(), pointer: None, candidates: Vec::new() }
    }

    /// Replaces the text that says what was wrong.
    #[must_use]
    pub fn map_detail(self, change: impl FnOnce(&str) -> &str) -> Self {
        Self { detail: change(&self.detail).to_owned(), ..self }
    }

    /// 400: the body is neither JSON nor MessagePack, or contains a number that is not finite.
    pub fn malformed(detail: impl Into<String>) -> Self {
        Self::new(&kinds::MALFORMED, detail)
    }

    /// 400: no `Host`, more than one, or one that is not a host.
    pub fn bad_host(detail: &str) -> Self {
        Self::new(&kinds::BAD_HOST, detail)
    }

    /// 401: the token is missing or wrong.
    pub fn unauthorized() -> Self {
        Self::new(&kinds::UNAUTHORIZED, "send the service's token as `Authorization: Bearer …`")
    }

    /// 403: `Host` is not a name of this service.
    pub fn foreign_host(host: &str) -> Self {
        let detail =
            format!("`{host:.80}` is not a name of this service; if it is, start it with --allow-host {host:.80}");
        Self::new(&kinds::FOREIGN_HOST, detail)
    }

    /// 403: a web page of another site makes the request.
    pub fn foreign_origin(origin: &str) -> Self {
        let detail = format!("pages of `{origin}` may not call this service; allow them with --allow-origin");
        Self::new(&kinds::FOREIGN_ORIGIN, detail)
    }

    /// 403: the resource belongs to the service and cannot be deleted.
    pub fn permanent(detail: impl Into<String>) -> Self {
        Self::new(&kinds::PERMANENT, detail)
    }

    /// 403: the session has another owner.
    pub fn not_owner() -> Self {
        let detail = "the session belongs to a client with another owner token; open a session of your own, or send the \
                      `Revprio-Owner` with which this session was opened";
        Self::new(&kinds::OWNER, detail)
    }

    /// 404: no such resource.
    pub fn not_found(detail: impl Into<String>) -> Self {
        Self::new(&kinds::NOT_FOUND, detail)
    }

    /// 404: no such session, or no longer.
    pub fn unknown_controller(id: &str) -> Self {
        let detail = format!(
            "there is no controller `{id}`; it was deleted, it was idle for too long, or the service was restarted; \
             create it again with POST /v1/controllers"
        );
        Self::new(&kinds::UNKNOWN_CONTROLLER, detail)
    }

    /// 405: the route exists, but not with this method.
    pub fn method_not_allowed() -> Self {
        Self::new(&kinds::METHOD_NOT_ALLOWED, "this route does not accept that method; see /openapi.json")
    }

    /// 406: the client accepts none of the offered media types.
    pub fn not_acceptable(offered: &str) -> Self {
        Self::new(&kinds::NOT_ACCEPTABLE, format!("available media types: {offered}; choose one with `Accept`"))
    }

    /// 408: the body did not arrive in time.
    pub fn body_timeout() -> Self {
        Self::new(&kinds::TIMEOUT, "the body did not arrive in time; send the whole body without pauses")
    }

    /// 409: another robot has the name.
    pub fn name_taken(detail: impl Into<String>) -> Self {
        Self::new(&kinds::NAME_TAKEN, detail).at("/name")
    }

    /// 409: the sequence number of a new state is not greater than the last one.
    pub fn sequence(detail: impl Into<String>) -> Self {
        Self::new(&kinds::SEQUENCE, detail).at("/sequence")
    }

    /// 409: the simulation has no trace.
    pub fn no_trace(detail: impl Into<String>) -> Self {
        Self::new(&kinds::NO_TRACE, detail)
    }

    /// 409: the simulation cannot be controlled.
    pub fn not_live(detail: impl Into<String>) -> Self {
        Self::new(&kinds::NOT_LIVE, detail)
    }

    /// 413: the body is too large.
    pub fn too_large(limit: usize) -> Self {
        Self::new(&kinds::TOO_LARGE, format!("a body may have at most {limit} bytes"))
    }

    /// 415: neither JSON nor MessagePack.
    pub fn media_type() -> Self {
        Self::new(&kinds::MEDIA_TYPE, "send `Content-Type: application/json` or `application/msgpack`")
    }

    /// 415: a compressed body.
    pub fn content_encoding() -> Self {
        Self::new(&kinds::CONTENT_ENCODING, "the service reads bodies without compression only")
    }

    /// 422: the body is well-formed, but the field at the JSON pointer `pointer` is wrong.
    #[expect(clippy::needless_pass_by_value, reason = "callers pass errors and strings that they no longer need")]
    pub fn invalid(pointer: impl Into<String>, detail: impl ToString) -> Self {
        Self::new(&kinds::INVALID, detail.to_string()).at(pointer)
    }

    /// 422: the state is beyond a bound of the controller's `state_checks`.
    pub fn implausible(pointer: &str, detail: impl Into<String>) -> Self {
        Self::new(&kinds::IMPLAUSIBLE, detail).at(pointer)
    }

    /// 422: the idempotency key belongs to another request.
    pub fn key_reused() -> Self {
        let detail = "this `Idempotency-Key` opened a session with another controller or owner; send a new key";
        Self::new(&kinds::KEY_REUSED, detail)
    }

    /// 426: the route accepts only WebSocket connections.
    pub fn upgrade_required() -> Self {
        Self::new(&kinds::UPGRADE_REQUIRED, "this route needs a WebSocket client (RFC 6455, version 13)")
    }

    /// 429: the token is missing or wrong, and so were many before.
    pub fn too_many_failures() -> Self {
        Self::new(&kinds::TOO_MANY_FAILURES, "many requests had a wrong token; send the service's token")
    }

    /// 501: an unknown transfer encoding.
    pub fn transfer_encoding() -> Self {
        let detail = "send the body with `Content-Length` or `Transfer-Encoding: chunked`";
        Self::new(&kinds::TRANSFER_ENCODING, detail)
    }

    /// 500: a defect of the service.
    pub fn internal() -> Self {
        Self::new(&kinds::INTERNAL, "a defect of the service, not of your request; the log has the details")
    }

    /// 503: too many sessions.
    pub fn too_many_sessions(limit: usize) -> Self {
        let detail = format!("{limit} controllers are open already; delete one, or wait until an idle one ends");
        Self::new(&kinds::TOO_MANY_CONTROLLERS, detail)
    }

    /// 503: too many registered robots.
    pub fn too_many_robots(detail: impl Into<String>) -> Self {
        Self::new(&kinds::TOO_MANY_ROBOTS, detail)
    }

    /// 503: the quota for long work is used up.
    pub fn busy(detail: impl Into<String>) -> Self {
        Self::new(&kinds::BUSY, detail)
    }

    /// 503: long work did not finish in time.
    pub fn deadline(timeout: Duration) -> Self {
        Self::new(&kinds::DEADLINE, format!("the work was abandoned after {} s", timeout.as_secs_f64()))
    }

    /// 503: more requests wait than can be answered in time.
    pub fn overloaded() -> Self {
        let detail = "more requests wait than can be answered in time; send fewer, or start another server";
        Self::new(&kinds::OVERLOADED, detail)
    }

    /// 503: the quota for large bodies is used up.
    pub fn too_many_bodies() -> Self {
        let detail = "the service is reading other large bodies; try again, or send a smaller one";
        Self::new(&kinds::OVERLOADED, detail)
    }

    /// 503: the service is about to end.
    pub fn draining() -> Self {
        Self::new(&kinds::DRAINING, "the service is about to end; call another instance")
    }

    /// Sets the JSON pointer of the wrong field.
    #[must_use]
    pub fn at(self, pointer: impl Into<String>) -> Self {
        Self { pointer: Some(pointer.into()), ..self }
    }

    /// Lists possible values of the wrong field, best first.
    #[must_use]
    pub fn with_candidates(self, candidates: &[String]) -> Self {
        Self { candidates: candidates.iter().take(Self::MAX_CANDIDATES).cloned().collect(), ..self }
    }

    /// Puts `prefix` before the JSON pointer: the place of the checked object in the whole body.
    #[must_use]
    pub fn inside(self, prefix: &str) -> Self {
        Self { pointer: self.pointer.map(|pointer| format!("{prefix}{pointer}")), ..self }
    }

    /// Returns whether the wrong field is the memory of a stateless step or a part of it.
    pub fn is_about_memory(&self) -> bool {
        self.pointer.as_deref().is_some_and(|pointer| pointer.starts_with("/memory"))
    }

    /// Returns whether the status is 404.
    pub fn is_not_found(&self) -> bool {
        self.kind.status == StatusCode::NOT_FOUND
    }

    /// Last part of the `type` reference.
    pub fn kind(&self) -> &'static str {
        self.kind.name
    }

    /// Converts the error to a problem object, for an item of a batch or a message of a stream.
    pub fn into_wire(self) -> wire::Problem {
        wire::Problem {
            kind: format!("/problems/{}", self.kind.name),
            title: self.kind.title.to_owned(),
            status: self.kind.status.as_u16(),
            detail: self.detail,
            pointer: self.pointer,
            candidates: self.candidates,
            request_id: None,
        }
    }
}

impl fmt::Display for ApiError {
    /// Writes the place of the mistake, if it is known, and what is wrong.
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match &self.pointer {
            Some(pointer) => write!(formatter, "{pointer}: {}", self.detail),
            None => formatter.write_str(&self.detail),
        }
    }
}

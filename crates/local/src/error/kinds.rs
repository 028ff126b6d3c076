//! The kinds of problems: the only table of their status codes, names and meanings.

use http::StatusCode;

/// A kind of problem: everything that does not depend on the request.
#[derive(Debug, PartialEq, Eq)]
pub struct Kind {
    /// HTTP status code.
    pub status: StatusCode,
    /// Last part of the `type` reference, `/problems/{name}`. Clients compare it, so it never changes.
    pub name: &'static str,
    /// `title` of the problem.
    pub title: &'static str,
    /// When the problem occurs, for the interface description.
    pub cause: &'static str,
    /// What the client can do, for the interface description.
    pub remedy: &'static str,
}

/// Defines one constant per kind, and the list of them all.
macro_rules! kinds {
    ($($kind:ident: $status:ident $name:literal, $title:literal, $cause:literal, $remedy:literal;)+) => {
        $(pub const $kind: Kind =
            Kind { status: StatusCode::$status, name: $name, title: $title, cause: $cause, remedy: $remedy };)+

        /// All kinds, by status.
        pub const KINDS: &[Kind] = &[$($kind),+];
    };
}

kinds! {
    MALFORMED: BAD_REQUEST "malformed", "The body cannot be read",
        "The body is neither JSON nor MessagePack, or it contains a number that is not finite.",
        "Correct the syntax of the body at the place that `detail` names.";
    BAD_HOST: BAD_REQUEST "bad-host", "The header `Host` is missing or wrong",
        "The request has no `Host`, more than one, or one that is not a host with an optional port.",
        "Send exactly one `Host`.";
    UNAUTHORIZED: UNAUTHORIZED "unauthorized", "The token is missing or wrong",
        "The service requires a token, and the request has no token or a wrong one.",
        "Send `Authorization: Bearer` with the service's token.";
    PERMANENT: FORBIDDEN "permanent", "This cannot be deleted",
        "The robot belongs to the service and cannot be deleted.",
        "Delete only registered robots.";
    FOREIGN_HOST: FORBIDDEN "foreign-host", "The host is not allowed",
        "The header `Host` names neither the address of the service, nor `localhost`, nor a configured name.",
        "Use the address of the service, or start it with `--allow-host` and the name.";
    FOREIGN_ORIGIN: FORBIDDEN "foreign-origin", "The origin is not allowed",
        "A web page of another site makes the request.",
        "Start the service with `--allow-origin` and the origin of that page.";
    OWNER: FORBIDDEN "owner", "The session has another owner",
        "The session was opened with an owner token, and the request has no token or another one.",
        "Step, replace and end only your own sessions. Send the same `Revprio-Owner` with which the session was opened.";
    NOT_FOUND: NOT_FOUND "not-found", "Not found",
        "There is no such route, robot, scenario or simulation.",
        "Use a name from a list or from the answer that created the resource.";
    UNKNOWN_CONTROLLER: NOT_FOUND "unknown-controller", "There is no such controller",
        "The session was deleted, was idle for too long, or the service was restarted.",
        "Open a new session.";
    METHOD_NOT_ALLOWED: METHOD_NOT_ALLOWED "method-not-allowed", "The method is not allowed here",
        "The route exists, but not with this method.",
        "Use a method that the header `Allow` lists.";
    NOT_ACCEPTABLE: NOT_ACCEPTABLE "not-acceptable", "Not acceptable",
        "The service cannot answer in any media type that `Accept` lists.",
        "Accept one of the media types that `detail` lists.";
    TIMEOUT: REQUEST_TIMEOUT "timeout", "The request took too long",
        "The body did not arrive in time.",
        "Send the whole body without pauses.";
    SEQUENCE: CONFLICT "sequence", "The sequence number is too low",
        "The sequence number of a new state is not greater than the last one.",
        "Increase the number with every new state. Repeat a number only to send the same state again.";
    NAME_TAKEN: CONFLICT "name-taken", "The name is taken",
        "Another robot has this name.",
        "Choose another name.";
    NO_TRACE: CONFLICT "no-trace", "There is no trace",
        "The simulation has not finished, was cancelled, or failed.",
        "Read the state of the simulation; wait until it is `finished`.";
    NOT_LIVE: CONFLICT "not-live", "The simulation cannot be controlled",
        "The simulation was not started as interactive, has not begun, or has ended.",
        "Start a simulation with `interactive`.";
    TOO_LARGE: PAYLOAD_TOO_LARGE "too-large", "The body is too large",
        "The body is larger than the limit.",
        "Send a smaller body; `detail` states the limit.";
    MEDIA_TYPE: UNSUPPORTED_MEDIA_TYPE "media-type", "The media type is not supported",
        "`Content-Type` is neither `application/json` nor `application/msgpack`.",
        "Send the media type of the body as `Content-Type`.";
    CONTENT_ENCODING: UNSUPPORTED_MEDIA_TYPE "content-encoding", "The encoding of the body is not supported",
        "`Content-Encoding` names a compression. The service reads bodies without compression only.",
        "Send the body without compression.";
    INVALID: UNPROCESSABLE_ENTITY "invalid", "A field of the body is wrong",
        "A field is unknown, missing, of the wrong type or size, out of range, or contradicts another field.",
        "Change the field at `pointer` as `detail` says.";
    IMPLAUSIBLE: UNPROCESSABLE_ENTITY "implausible", "The state is not plausible",
        "The state is beyond a bound of the controller's `state_checks`: a joint is far outside its range, or the wrench is \
         too large.",
        "Check units and sensors. If the state is right, set a larger bound in `state_checks`.";
    KEY_REUSED: UNPROCESSABLE_ENTITY "key-reused", "The idempotency key was used before",
        "Another request with the same `Idempotency-Key` opened a session with another controller or owner.",
        "Send a new key with every new request. Repeat a key only to send the same request again.";
    UPGRADE_REQUIRED: UPGRADE_REQUIRED "upgrade-required", "A WebSocket is required",
        "The route accepts only WebSocket connections.",
        "Use a WebSocket client.";
    TOO_MANY_FAILURES: TOO_MANY_REQUESTS "too-many-failures", "Too many requests with a wrong token",
        "The token is missing or wrong, and so were those of many requests before. A request with the token is answered.",
        "Send the service's token, or wait for the time in `Retry-After`.";
    INTERNAL: INTERNAL_SERVER_ERROR "internal", "The service failed",
        "The service has a defect. The request is not the cause.",
        "Read the service's log.";
    TRANSFER_ENCODING: NOT_IMPLEMENTED "transfer-encoding", "The transfer encoding is not implemented",
        "`Transfer-Encoding` names another coding than `chunked`.",
        "Send the body with `Content-Length` or `Transfer-Encoding: chunked`.";
    TOO_MANY_CONTROLLERS: SERVICE_UNAVAILABLE "too-many-controllers", "Too many controllers",
        "The maximum number of sessions is open.",
        "Delete a session, or wait until an idle one ends.";
    TOO_MANY_ROBOTS: SERVICE_UNAVAILABLE "too-many-robots", "Too many robots",
        "The maximum number of robots is registered.",
        "Delete a robot, or wait until an unused one ends.";
    BUSY: SERVICE_UNAVAILABLE "busy", "The service is busy",
        "The maximum number of long computations of this kind is running or waiting.",
        "Try again after the time in `Retry-After`.";
    DEADLINE: SERVICE_UNAVAILABLE "deadline", "The work took too long",
        "A long computation did not finish in time, waiting included.",
        "Send a smaller problem, or try again when the service is less busy.";
    STUCK: SERVICE_UNAVAILABLE "stuck", "The service is stuck",
        "The thread that answers requests has not been running for a while. The process ends if that continues.",
        "Send the request to another instance, or again after the restart.";
    OVERLOADED: SERVICE_UNAVAILABLE "overloaded", "The service is overloaded",
        "More requests wait than the service can answer in time.",
        "Send fewer requests, or start another server.";
    DRAINING: SERVICE_UNAVAILABLE "draining", "The service is shutting down",
        "The service is about to end.",
        "Send the request to another instance.";
}

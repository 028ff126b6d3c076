//! Access checks: the encodings of requests, the bearer token, and the origin of web pages.

use axum::http::{HeaderMap, header};

use super::config::ServiceConfig;
use super::error::ApiError;

/// Refuses requests that a web page of another site makes.
pub fn check_origin(config: &ServiceConfig, headers: &HeaderMap) -> Result<(), ApiError> {
    let Some(origin) = headers.get(header::ORIGIN) else { return Ok(()) };
    let origin = origin.to_str().unwrap_or_default();
    if config.allowed_origins.iter().any(|allowed| allowed == origin) || is_own(origin, headers) {
        Ok(())
    } else {
        Err(ApiError::foreign_origin(origin))
    }
}

/// Returns whether the request has the token, if the service has one.
pub fn has_token(config: &ServiceConfig, headers: &HeaderMap) -> bool {
    config.token.as_ref().is_none_or(|token| token.is_in(headers))
}

/// Refuses codings of the body that the service does not read.
///
/// A request whose last transfer coding is not `chunked` has a body without an end. The connection refuses it with 400,
/// as RFC 9112, section 6.3, demands. Here are the other codings before `chunked`.
pub fn check_codings(headers: &HeaderMap) -> Result<(), ApiError> {
    let is_only = |name, coding: &str| {
        headers
            .get_all(name)
            .iter()
            .all(|value| value.to_str().is_ok_and(|text| text.trim().eq_ignore_ascii_case(coding)))
    };
    if headers.get_all(header::TRANSFER_ENCODING).iter().count() > 1 || !is_only(header::TRANSFER_ENCODING, "chunked") {
        return Err(ApiError::transfer_encoding());
    }
    if is_only(header::CONTENT_ENCODING, "identity") { Ok(()) } else { Err(ApiError::content_encoding()) }
}

/// Returns whether the page came from this service: from the host that the request names. Every host was checked before.
fn is_own(origin: &str, headers: &HeaderMap) -> bool {
    let host = headers.get(header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
    let authority = origin.split_once("://").map_or("", |(_, authority)| authority);
    !host.is_empty() && authority.eq_ignore_ascii_case(host)
}

//! `GET /` and `GET /dashboard/{file}`: the page in the browser.

use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};

use super::Segment;
use crate::dashboard;
use crate::service::error::ApiError;

/// Allows only files of the service itself. `blob:` is for pictures that the page exports.
const ONLY_SELF: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
                         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// `GET /`
pub async fn home(headers: HeaderMap) -> Result<Response, ApiError> {
    answer("index.html", &headers)
}

/// `GET /dashboard/{file}`
pub async fn file(Segment(name): Segment, headers: HeaderMap) -> Result<Response, ApiError> {
    answer(&name, &headers)
}

fn answer(name: &str, headers: &HeaderMap) -> Result<Response, ApiError> {
    let file = dashboard::file(name);
    let (media_type, text) = file.ok_or_else(|| ApiError::not_found("there is no such page; the dashboard is at /"))?;
    let version = HeaderValue::from_str(&dashboard::VERSION).map_err(|_| ApiError::internal())?;
    let is_known = headers.get(header::IF_NONE_MATCH) == Some(&version);
    let head: [(HeaderName, HeaderValue); 5] = [
        (header::CONTENT_TYPE, HeaderValue::from_static(media_type)),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(ONLY_SELF)),
        (header::REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
        // Browsers check the version each time. The service sends the file only after an update.
        (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
        (header::ETAG, version),
    ];
    Ok(if is_known { (StatusCode::NOT_MODIFIED, head).into_response() } else { (head, text).into_response() })
}

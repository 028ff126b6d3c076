//! Interface descriptions as the service sends them: without spaces, compressed, and with a version.

use std::hash::{DefaultHasher, Hash, Hasher};

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use super::accept;
use super::body::compress_well;

/// A document that does not change while the service runs.
pub struct Published {
    json: Bytes,
    /// The same, compressed; `None` if the compression failed.
    gzip: Option<Bytes>,
    /// Weak, because it is the same for both forms.
    version: HeaderValue,
}

impl Published {
    /// Writes a document. This takes tens of milliseconds.
    pub fn new(document: &Value) -> Self {
        let json = document.to_string();
        let gzip = compress_well(json.as_bytes()).map(Bytes::from);
        let mut hasher = DefaultHasher::new();
        json.hash(&mut hasher);
        let version = HeaderValue::from_str(&format!("W/\"{:016x}\"", hasher.finish()));
        let version = version.unwrap_or_else(|_| HeaderValue::from_static("W/\"0\""));
        Self { json: json.into(), gzip, version }
    }

    /// Answers a request: compressed if the client accepts gzip, without body if the client knows this version.
    pub fn answer(&self, headers: &HeaderMap) -> Response {
        let head: [(HeaderName, HeaderValue); 4] = [
            (header::CONTENT_TYPE, HeaderValue::from_static("application/json")),
            (header::VARY, HeaderValue::from_static("accept-encoding")),
            // Clients check the version each time. The service sends the document only after an update.
            (header::CACHE_CONTROL, HeaderValue::from_static("no-cache")),
            (header::ETAG, self.version.clone()),
        ];
        if headers.get(header::IF_NONE_MATCH) == Some(&self.version) {
            return (StatusCode::NOT_MODIFIED, head).into_response();
        }
        match self.gzip.as_ref().filter(|_| accept::gzip(headers)) {
            Some(gzip) => (head, [(header::CONTENT_ENCODING, "gzip")], gzip.clone()).into_response(),
            None => (head, self.json.clone()).into_response(),
        }
    }
}

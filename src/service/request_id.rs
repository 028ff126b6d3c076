//! IDs of requests, so that an answer, a problem and a log line of the same request can be matched.

use std::sync::atomic::{AtomicU64, Ordering};

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use uuid::Uuid;

use super::platform::Platform;

/// The header with the ID.
pub const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// Maximum length of an ID that a client sends.
const MAX_LENGTH: usize = 64;

/// Creates the IDs of requests.
#[derive(Debug)]
pub struct RequestIds {
    /// Differs from process to process.
    prefix: String,
    next: AtomicU64,
}

impl RequestIds {
    /// Creates the IDs of one process.
    pub fn new(platform: &dyn Platform) -> Self {
        let prefix = Uuid::from_bytes(platform.random_bytes()).simple().to_string()[..8].to_owned();
        Self { prefix, next: AtomicU64::new(1) }
    }

    /// Returns the client's ID if it is a short word, otherwise a new ID.
    pub fn for_request(&self, headers: &HeaderMap) -> HeaderValue {
        let is_valid = |id: &&HeaderValue| {
            let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || b"-_.:".contains(byte);
            (1..=MAX_LENGTH).contains(&id.len()) && id.as_bytes().iter().all(is_word)
        };
        headers.get(REQUEST_ID).filter(is_valid).cloned().unwrap_or_else(|| {
            let number = self.next.fetch_add(1, Ordering::Relaxed);
            HeaderValue::try_from(format!("{}-{number}", self.prefix)).unwrap_or(HeaderValue::from_static("none"))
        })
    }
}

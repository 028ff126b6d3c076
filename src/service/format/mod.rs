//! The two formats of bodies, JSON and MessagePack. Both carry the same values.

mod message_pack;

use axum::http::{HeaderMap, header};
use revprio_local::json;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::accept;
use super::error::ApiError;

/// The format of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// JSON.
    Json,
    /// MessagePack; structs are maps with the names of their fields.
    MessagePack,
}

impl Format {
    /// Media type.
    pub fn media_type(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::MessagePack => "application/msgpack",
        }
    }

    /// Returns the format of the body with these headers, if the service can read it.
    pub fn from_content_type(headers: &HeaderMap) -> Option<Self> {
        let media_type = headers.get(header::CONTENT_TYPE)?.to_str().ok()?.split(';').next()?.trim();
        [Self::Json, Self::MessagePack].into_iter().find(|format| media_type.eq_ignore_ascii_case(format.media_type()))
    }

    /// Returns the format of the answer: the accepted format, otherwise the format of the request.
    pub fn from_accept(headers: &HeaderMap) -> Self {
        let formats = match Self::from_content_type(headers) {
            Some(Self::MessagePack) => [Self::MessagePack, Self::Json],
            Some(Self::Json) | None => [Self::Json, Self::MessagePack],
        };
        if !headers.contains_key(header::ACCEPT) {
            return formats[0];
        }
        accept::preferred(headers, &formats.map(|format| (format.media_type(), format))).unwrap_or(formats[0])
    }

    /// Reads an object. An error names the wrong field by its JSON pointer.
    pub fn read<T: DeserializeOwned>(self, bytes: &[u8]) -> Result<T, ApiError> {
        match self {
            Self::Json => json::read(bytes),
            Self::MessagePack => message_pack::read(bytes),
        }
    }

    /// Reads an object that may borrow from the bytes. Returns `None` on any error, and always for MessagePack, which
    /// has no raw values to borrow.
    pub fn read_borrowed<'a, T: Deserialize<'a>>(self, bytes: &'a [u8]) -> Option<T> {
        match self {
            Self::Json => json::read_borrowed(bytes),
            Self::MessagePack => None,
        }
    }

    /// Writes a value.
    pub fn write<T: Serialize + ?Sized>(self, value: &T) -> Result<Vec<u8>, ApiError> {
        let written = match self {
            Self::Json => json::write(value).map_err(|error| error.to_string()),
            Self::MessagePack => message_pack::write(value).map_err(|error| error.to_string()),
        };
        written.map_err(|error| {
            tracing::error!(error, "cannot encode an answer");
            ApiError::internal()
        })
    }
}

/// A body whose bytes have arrived but are not decoded yet.
pub struct RawBody {
    /// The format of the bytes.
    pub format: Format,
    /// The whole body.
    pub bytes: Vec<u8>,
}

/// Maximum size of a body, bytes, that the thread of the steps decodes: 16 states. Decoding takes some 100 µs.
const MAX_SMALL_BODY: usize = 16 << 10;

impl RawBody {
    /// Returns whether another thread must decode the body.
    pub fn is_large(&self) -> bool {
        self.bytes.len() > MAX_SMALL_BODY
    }

    /// Decodes the body.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, ApiError> {
        self.format.read(&self.bytes)
    }
}

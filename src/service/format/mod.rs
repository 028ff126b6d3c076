//! JSON and MessagePack: the same values in two notations.

mod json;
mod message_pack;

use axum::http::{HeaderMap, HeaderValue, header};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_path_to_error::Segment;

use super::accept;
use super::error::{ApiError, escaped};

/// How a body is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Text.
    Json,
    /// Binary, with the names of all fields.
    MessagePack,
}

impl Format {
    /// Media type.
    pub fn media_type(self) -> HeaderValue {
        HeaderValue::from_static(self.name())
    }

    fn name(self) -> &'static str {
        match self {
            Self::Json => "application/json",
            Self::MessagePack => "application/msgpack",
        }
    }

    /// The format of the body that comes with these headers, if it is one that can be read.
    pub fn of_body(headers: &HeaderMap) -> Option<Self> {
        let media_type = headers.get(header::CONTENT_TYPE)?.to_str().ok()?.split(';').next()?.trim();
        [Self::Json, Self::MessagePack].into_iter().find(|format| media_type.eq_ignore_ascii_case(format.name()))
    }

    /// The format to answer in: what the client accepts, otherwise the one it wrote in.
    pub fn of_answer(headers: &HeaderMap) -> Self {
        let formats = match Self::of_body(headers) {
            Some(Self::MessagePack) => [Self::MessagePack, Self::Json],
            Some(Self::Json) | None => [Self::Json, Self::MessagePack],
        };
        if !headers.contains_key(header::ACCEPT) {
            return formats[0];
        }
        accept::preferred(headers, &formats.map(|format| (format.name(), format))).unwrap_or(formats[0])
    }

    /// Reads an object; what is wrong is named by JSON pointer.
    pub fn read<T: DeserializeOwned>(self, bytes: &[u8]) -> Result<T, ApiError> {
        match self {
            Self::Json => json::read(bytes),
            Self::MessagePack => message_pack::read(bytes),
        }
    }

    /// Reads an object that may leave parts of the bytes unread, which JSON alone can; `None` if that fails.
    pub fn glance<'a, T: Deserialize<'a>>(self, bytes: &'a [u8]) -> Option<T> {
        match self {
            Self::Json => json::glance(bytes),
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
            tracing::error!(error, "an answer cannot be written");
            ApiError::internal()
        })
    }
}

/// JSON pointer (RFC 6901) of a path.
fn pointer(path: &serde_path_to_error::Path) -> String {
    let part = |segment: &Segment| match segment {
        Segment::Seq { index } => format!("/{index}"),
        Segment::Map { key } => format!("/{}", escaped(key)),
        Segment::Enum { .. } | Segment::Unknown => String::new(),
    };
    path.iter().map(part).collect()
}

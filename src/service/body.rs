//! Reading JSON bodies, with problems instead of axum's rejections.

use std::future::poll_fn;
use std::pin::Pin;
use std::sync::Arc;

use axum::body::HttpBody;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, header};
use serde::de::DeserializeOwned;
use serde_json::error::Category;
use serde_path_to_error::Segment;

use super::app::App;
use super::problem::{Problem, escaped};
use crate::wire::Object;

/// Bodies up to this many bytes are read without asking for room.
const SMALL: usize = 64 << 10;

/// Most bytes that are read of a body that is too large: most clients listen only after they have sent all of it, and
/// would see a broken connection instead of the refusal.
const FORGOTTEN_LIMIT: usize = 16 << 20;

/// A JSON body.
pub struct Body<T>(pub T);

impl<T: DeserializeOwned> FromRequest<Arc<App>> for Body<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &Arc<App>) -> Result<Self, Problem> {
        if !is_json(request.headers()) {
            return Err(Problem::media_type());
        }
        let bytes = tokio::time::timeout(app.config.body_timeout, read(request.into_body(), app));
        let bytes = bytes.await.map_err(|_| Problem::body_timeout())??;
        parse(&bytes).map(Self)
    }
}

/// `application/json`, with or without parameters.
fn is_json(headers: &HeaderMap) -> bool {
    let media_type = headers.get(header::CONTENT_TYPE).and_then(|value| value.to_str().ok());
    media_type.is_some_and(|text| {
        text.split(';').next().is_some_and(|kind| kind.trim().eq_ignore_ascii_case("application/json"))
    })
}

/// Reads a body up to the limit; what is too much is read and forgotten.
///
/// Only so many large ones at a time: together they could hold more memory than all connections.
async fn read(mut body: axum::body::Body, app: &App) -> Result<Vec<u8>, Problem> {
    let limit = app.config.max_body_bytes;
    let (mut bytes, mut size) = (Vec::new(), 0);
    let (mut room, mut refusal) = (None, None);
    while let Some(frame) = poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await {
        let frame = frame.map_err(|_| Problem::body_timeout())?;
        let data = frame.data_ref().map_or(&[][..], |data| data);
        size += data.len();
        if size > limit {
            refusal = Some(Problem::too_large(limit));
        } else if size > SMALL && room.is_none() && refusal.is_none() {
            room = app.large_bodies.try_acquire().ok();
            refusal = room.is_none().then(Problem::too_many_bodies);
        }
        if refusal.is_none() {
            bytes.extend_from_slice(data);
        } else if size > limit.max(FORGOTTEN_LIMIT) {
            break;
        }
    }
    refusal.map_or(Ok(bytes), Err)
}

fn parse<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    match serde_json::from_slice(bytes) {
        Ok(Object(value)) => Ok(value),
        Err(_) => explain(bytes),
    }
}

/// Reads once more, keeping track of where: what a good body need not pay for.
fn explain<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    let mut deserializer = serde_json::Deserializer::from_slice(bytes);
    let Object(value) = serde_path_to_error::deserialize(&mut deserializer).map_err(|error| {
        let (place, cause) = (pointer(error.path()), error.into_inner());
        match cause.classify() {
            Category::Data => Problem::invalid(place, cause),
            _ if is_well_formed(bytes) => Problem::invalid(place, cause),
            Category::Syntax | Category::Eof | Category::Io => Problem::malformed(cause.to_string()),
        }
    })?;
    deserializer.end().map_err(|error| Problem::malformed(error.to_string()))?;
    Ok(value)
}

/// Whether it is JSON of finite numbers: a value of another type than the expected one can look like wrong syntax.
fn is_well_formed(bytes: &[u8]) -> bool {
    serde_json::from_slice::<serde_json::Value>(bytes).is_ok()
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

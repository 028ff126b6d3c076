//! Bodies in and out, in the format that the client chose, with problems instead of axum's rejections.
//!
//! Handlers take a [`Body`] and return an [`Answer`], values both; [`written`] makes bytes of answers. What
//! takes longer than some control periods to read or write is a [`LargeBody`] or a [`LargeAnswer`] and handled in another
//! thread, so that the steps of others do not wait.

use std::future::poll_fn;
use std::io::Write as _;
use std::marker::PhantomData;
use std::pin::Pin;
use std::sync::Arc;

use axum::body::HttpBody;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderValue, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::sync::SemaphorePermit;

use super::accept;
use super::app::AppState;
use super::background::background;
use super::error::ApiError;
use super::format::Format;

/// Bodies up to this many bytes are read without asking for room.
const SMALL: usize = 64 << 10;

/// Larger ones take a place for every so many bytes.
const PLACE: usize = 1 << 20;

/// Most bytes beyond the limit that are read of a body that is too large: most clients listen only after they have sent
/// all of it, and would see a broken connection instead of the refusal.
const FORGOTTEN_LIMIT: usize = 15 << 20;

/// Large answers of fewer bytes are not worth compressing.
const SMALLEST_COMPRESSED: usize = 4 << 10;

/// A body as it came.
pub struct Unread {
    /// How it is written.
    pub format: Format,
    /// All of it.
    pub bytes: Vec<u8>,
}

impl Unread {
    /// Reads it.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, ApiError> {
        self.format.read(&self.bytes)
    }
}

impl FromRequest<Arc<AppState>> for Unread {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        received(request, app, app.config.max_body_bytes).await
    }
}

/// A body that has been read.
pub struct Body<T>(pub T);

impl<T: DeserializeOwned> FromRequest<Arc<AppState>> for Body<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        Unread::from_request(request, app).await?.read().map(Self)
    }
}

/// A body that is still to be read, in another thread.
pub struct LargeBody<T> {
    unread: Unread,
    value: PhantomData<fn() -> T>,
}

impl<T: DeserializeOwned> LargeBody<T> {
    /// Reads it.
    pub fn read(self) -> Result<T, ApiError> {
        self.unread.read()
    }
}

impl<T> FromRequest<Arc<AppState>> for LargeBody<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        let unread = received(request, app, app.config.max_batch_bytes).await?;
        Ok(Self { unread, value: PhantomData })
    }
}

async fn received(request: Request, app: &AppState, limit: usize) -> Result<Unread, ApiError> {
    let format = Format::of_body(request.headers()).ok_or_else(ApiError::media_type)?;
    let bytes = tokio::time::timeout(app.config.body_timeout, collected(request.into_body(), app, limit));
    Ok(Unread { format, bytes: bytes.await.map_err(|_| ApiError::body_timeout())?? })
}

/// Collects a body up to the limit; what is too much is read and forgotten.
///
/// Only so many large ones at a time: together they could hold more memory than all connections.
async fn collected(mut body: axum::body::Body, app: &AppState, limit: usize) -> Result<Vec<u8>, ApiError> {
    let (mut bytes, mut size) = (Vec::new(), 0);
    let (mut room, mut refusal) = (None, None);
    while let Some(frame) = poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await {
        let frame = frame.map_err(|_| ApiError::body_timeout())?;
        let data = frame.data_ref().map_or(&[][..], |data| data);
        size += data.len();
        if size > limit {
            refusal = Some(ApiError::too_large(limit));
        } else if refusal.is_none() && !fits(size, &mut room, app) {
            refusal = Some(ApiError::too_many_bodies());
        }
        if refusal.is_none() {
            bytes.extend_from_slice(data);
        } else if size > limit + FORGOTTEN_LIMIT {
            break;
        }
    }
    refusal.map_or(Ok(bytes), Err)
}

/// Whether there is room for a body of that size, beside the `room` that it takes up already; one that is larger than
/// all the room needs all of it.
fn fits<'a>(size: usize, room: &mut Option<SemaphorePermit<'a>>, app: &'a AppState) -> bool {
    let places = if size > SMALL { size.div_ceil(PLACE).min(app.config.max_large_bodies) } else { 0 };
    let missing = places.saturating_sub(room.as_ref().map_or(0, SemaphorePermit::num_permits));
    if missing == 0 {
        return true;
    }
    let Ok(more) = app.large_bodies.try_acquire_many(u32::try_from(missing).unwrap_or(u32::MAX)) else { return false };
    match room {
        Some(room) => room.merge(more),
        None => *room = Some(more),
    }
    true
}

/// An answer of a few kilobytes.
pub struct Answer<T>(pub T);

/// An answer of up to megabytes.
pub struct LargeAnswer<T>(pub T);

impl<T: Serialize + Send + Sync + 'static> IntoResponse for Answer<T> {
    fn into_response(self) -> Response {
        Unwritten { value: Arc::new(self.0), large: false }.into_response()
    }
}

impl<T: Serialize + Send + Sync + 'static> IntoResponse for LargeAnswer<T> {
    fn into_response(self) -> Response {
        Unwritten { value: Arc::new(self.0), large: true }.into_response()
    }
}

/// An answer that waits in its response for the layer that knows the client's format.
#[derive(Clone)]
struct Unwritten {
    value: Arc<dyn Writable>,
    large: bool,
}

impl Unwritten {
    fn into_response(self) -> Response {
        let mut response = Response::default();
        response.extensions_mut().insert(self);
        response
    }
}

trait Writable: Send + Sync {
    fn write(&self, format: Format) -> Result<Vec<u8>, ApiError>;
}

impl<T: Serialize + Send + Sync> Writable for T {
    fn write(&self, format: Format) -> Result<Vec<u8>, ApiError> {
        format.write(self)
    }
}

/// Lets the routes answer, and writes answers in the client's format; large ones in another thread, compressed if the client likes.
pub async fn written(request: Request, next: Next) -> Response {
    let format = Format::of_answer(request.headers());
    let gzip = accept::gzip(request.headers());
    let mut response = next.run(request).await;
    let Some(Unwritten { value, large }) = response.extensions_mut().remove::<Unwritten>() else { return response };
    let bytes = if large {
        let large = background(move |_| value.write(format).map(|bytes| compressed(bytes, gzip))).await;
        large.and_then(|large| large).map(|(bytes, encoding)| {
            response.headers_mut().insert(header::VARY, HeaderValue::from_static("accept, accept-encoding"));
            encoding.map(|encoding| response.headers_mut().insert(header::CONTENT_ENCODING, encoding));
            bytes
        })
    } else {
        value.write(format)
    };
    match bytes {
        Ok(bytes) => {
            response.headers_mut().insert(header::CONTENT_TYPE, format.media_type());
            *response.body_mut() = bytes.into();
            response
        }
        Err(problem) => problem.into_response(),
    }
}

/// The bytes, compressed where it pays, and how.
fn compressed(bytes: Vec<u8>, gzip: bool) -> (Vec<u8>, Option<HeaderValue>) {
    if !gzip || bytes.len() < SMALLEST_COMPRESSED {
        return (bytes, None);
    }
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    match encoder.write_all(&bytes).and_then(|()| encoder.finish()) {
        Ok(small) => (small, Some(HeaderValue::from_static("gzip"))),
        Err(_) => (bytes, None),
    }
}

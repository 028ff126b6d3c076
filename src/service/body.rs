//! Bodies of requests and answers, in the format that the client chose.
//!
//! Handlers take a [`Body`] and return an [`Answer`]; both hold plain values. [`AnswerEncoding`] turns answers into bytes.
//! Bodies that take longer than a few control periods to decode or encode are [`LargeBody`] and [`LargeAnswer`]. Other
//! threads handle them, so that steps do not wait.

use std::future::poll_fn;
use std::io::Write as _;
use std::marker::PhantomData;
use std::pin::Pin;
use std::sync::Arc;

use axum::body::HttpBody;
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::sync::SemaphorePermit;

use super::accept;
use super::background::background;
use super::error::ApiError;
use super::format::{Format, RawBody};
use super::state::AppState;

/// Bodies up to this size, bytes, need no permit.
const MAX_SMALL: usize = 64 << 10;

/// Larger bodies need one permit per this many bytes.
const BYTES_PER_PERMIT: usize = 1 << 20;

/// Bytes beyond the limit that are read and discarded. Most clients read the answer only after they have sent the whole
/// body. Without this, they would see a broken connection instead of the refusal.
const MAX_DISCARDED: usize = 15 << 20;

/// Smaller answers are not compressed, bytes.
const MIN_COMPRESSED: usize = 4 << 10;

impl FromRequest<Arc<AppState>> for RawBody {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        receive(request, app, app.config.max_body_bytes).await
    }
}

/// A decoded body. Another thread decodes it if it is large.
pub struct Body<T>(pub T);

impl<T: DeserializeOwned + Send + 'static> FromRequest<Arc<AppState>> for Body<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        let raw = RawBody::from_request(request, app).await?;
        let value = if raw.is_large() { app.new.run(move |_| raw.read()).await? } else { raw.read() };
        value.map(Self)
    }
}

/// A body that another thread decodes.
pub struct LargeBody<T> {
    raw: RawBody,
    value: PhantomData<fn() -> T>,
}

impl<T: DeserializeOwned> LargeBody<T> {
    /// Decodes the body.
    pub fn read(self) -> Result<T, ApiError> {
        self.raw.read()
    }
}

impl<T> FromRequest<Arc<AppState>> for LargeBody<T> {
    type Rejection = ApiError;

    async fn from_request(request: Request, app: &Arc<AppState>) -> Result<Self, ApiError> {
        let raw = receive(request, app, app.config.max_batch_bytes).await?;
        Ok(Self { raw, value: PhantomData })
    }
}

async fn receive(request: Request, app: &AppState, limit: usize) -> Result<RawBody, ApiError> {
    let format = Format::from_content_type(request.headers()).ok_or_else(ApiError::media_type)?;
    let bytes = tokio::time::timeout(app.config.body_timeout, collect(request.into_body(), app, limit));
    Ok(RawBody { format, bytes: bytes.await.map_err(|_| ApiError::body_timeout())?? })
}

/// Collects a body up to the limit, and discards the rest, but refuses one at once that states a size beyond both.
///
/// Permits limit the number of large bodies at a time: together they could use more memory than all connections.
async fn collect(mut body: axum::body::Body, app: &AppState, limit: usize) -> Result<Vec<u8>, ApiError> {
    let stated = usize::try_from(body.size_hint().lower()).unwrap_or(usize::MAX);
    if stated > limit + MAX_DISCARDED {
        return Err(ApiError::too_large(limit));
    }
    let (mut bytes, mut size) = (Vec::with_capacity(stated.min(MAX_SMALL)), 0);
    let (mut permit, mut refusal) = (None, None);
    while let Some(frame) = poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await {
        let frame = frame.map_err(|_| ApiError::body_timeout())?;
        let data = frame.data_ref().map_or(&[][..], |data| data);
        size += data.len();
        if size > limit {
            refusal = Some(ApiError::too_large(limit));
        } else if refusal.is_none() && !acquire(size, &mut permit, app) {
            refusal = Some(ApiError::too_many_bodies());
        }
        if refusal.is_none() {
            bytes.extend_from_slice(data);
        } else if size > limit + MAX_DISCARDED {
            break;
        }
    }
    refusal.map_or(Ok(bytes), Err)
}

/// Extends `permit` to a body of `size` bytes. Returns false if there are too few permits left. A body that is larger than
/// all permits together needs all of them.
fn acquire<'a>(size: usize, permit: &mut Option<SemaphorePermit<'a>>, app: &'a AppState) -> bool {
    let needed = if size > MAX_SMALL { size.div_ceil(BYTES_PER_PERMIT).min(app.config.max_large_bodies) } else { 0 };
    let missing = needed.saturating_sub(permit.as_ref().map_or(0, SemaphorePermit::num_permits));
    if missing == 0 {
        return true;
    }
    let Ok(more) = app.large_bodies.try_acquire_many(u32::try_from(missing).unwrap_or(u32::MAX)) else { return false };
    match permit {
        Some(permit) => permit.merge(more),
        None => *permit = Some(more),
    }
    true
}

/// An answer of a few kilobytes.
pub struct Answer<T>(pub T);

/// An answer of up to megabytes.
pub struct LargeAnswer<T>(pub T);

impl<T: Serialize + Send + Sync + 'static> IntoResponse for Answer<T> {
    fn into_response(self) -> Response {
        Unencoded { value: Arc::new(self.0), is_large: false }.into_response()
    }
}

impl<T: Serialize + Send + Sync + 'static> IntoResponse for LargeAnswer<T> {
    fn into_response(self) -> Response {
        Unencoded { value: Arc::new(self.0), is_large: true }.into_response()
    }
}

/// The value of an answer. It travels in the extensions of the response to [`AnswerEncoding`], which knows the format.
#[derive(Clone)]
struct Unencoded {
    value: Arc<dyn Encode>,
    is_large: bool,
}

impl Unencoded {
    fn into_response(self) -> Response {
        let mut response = Response::default();
        response.extensions_mut().insert(self);
        response
    }
}

trait Encode: Send + Sync {
    fn encode(&self, format: Format) -> Result<Vec<u8>, ApiError>;
}

impl<T: Serialize + Send + Sync> Encode for T {
    fn encode(&self, format: Format) -> Result<Vec<u8>, ApiError> {
        format.write(self)
    }
}

/// How the client wants its answer.
#[derive(Debug, Clone, Copy)]
pub struct AnswerEncoding {
    format: Format,
    gzip: bool,
}

impl AnswerEncoding {
    /// Reads the headers of a request.
    pub fn of(headers: &HeaderMap) -> Self {
        Self { format: Format::from_accept(headers), gzip: accept::gzip(headers) }
    }

    /// Encodes the answer of a route. Large answers are encoded in another thread, and compressed if the client accepts
    /// gzip.
    pub async fn encode(self, mut response: Response) -> Response {
        let Self { format, gzip } = self;
        let Some(Unencoded { value, is_large }) = response.extensions_mut().remove() else { return response };
        let encoded = if is_large {
            let encoded = background(move |_| value.encode(format).map(|bytes| compress(bytes, gzip))).await;
            encoded.and_then(|encoded| encoded).map(|(bytes, encoding)| {
                response.headers_mut().insert(header::VARY, HeaderValue::from_static("accept, accept-encoding"));
                encoding.map(|encoding| response.headers_mut().insert(header::CONTENT_ENCODING, encoding));
                bytes
            })
        } else {
            value.encode(format)
        };
        match encoded {
            Ok(bytes) => {
                response.headers_mut().insert(header::CONTENT_TYPE, HeaderValue::from_static(format.media_type()));
                *response.body_mut() = bytes.into();
                response
            }
            Err(error) => error.into_response(),
        }
    }
}

/// Compresses large answers. Returns the bytes and the value of `Content-Encoding`.
fn compress(bytes: Vec<u8>, gzip: bool) -> (Vec<u8>, Option<HeaderValue>) {
    let compressed = (gzip && bytes.len() >= MIN_COMPRESSED).then(|| gzip_of(&bytes, Compression::fast()));
    match compressed.flatten() {
        Some(compressed) => (compressed, Some(HeaderValue::from_static("gzip"))),
        None => (bytes, None),
    }
}

/// Compresses a document that is sent many times: more slowly, but to about half the size.
pub fn compress_well(bytes: &[u8]) -> Option<Vec<u8>> {
    gzip_of(bytes, Compression::default())
}

fn gzip_of(bytes: &[u8], level: Compression) -> Option<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), level);
    encoder.write_all(bytes).and_then(|()| encoder.finish()).ok()
}

//! The interface description, and Swagger UI from the binary, which needs no network.

use std::sync::Arc;

use axum::Extension;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Redirect, Response};
use utoipa_swagger_ui::Config;

use super::Segment;
use crate::service::error::ApiError;

/// Allows only files of the service itself. The style sheet of the page contains its pictures.
const ONLY_SELF: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The documents that describe the routes. They come from outside, because their descriptions include these handlers.
#[derive(Clone, Copy)]
pub struct Documents {
    /// Returns the OpenAPI document.
    pub openapi: fn() -> &'static str,
    /// Returns the AsyncAPI document.
    pub asyncapi: fn() -> &'static str,
}

/// Returns the OpenAPI document.
///
/// It describes all HTTP routes and their bodies.
#[utoipa::path(
    get,
    path = "/openapi.json",
    tag = "operation",
    responses((status = 200, body = Object, content_type = "application/json", description = "OpenAPI 3.1."))
)]
pub async fn document(Extension(documents): Extension<Documents>) -> Response {
    json((documents.openapi)())
}

/// Returns the AsyncAPI document.
///
/// It describes the messages of `/v1/controllers/{id}/stream`.
#[utoipa::path(
    get,
    path = "/asyncapi.json",
    tag = "operation",
    operation_id = "asyncapi_document",
    responses((status = 200, body = Object, content_type = "application/json", description = "AsyncAPI 3.0."))
)]
pub async fn async_document(Extension(documents): Extension<Documents>) -> Response {
    json((documents.asyncapi)())
}

fn json(text: &'static str) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], text).into_response()
}

/// `GET /docs`
pub async fn home() -> Redirect {
    Redirect::permanent("/docs/")
}

/// `GET /docs/`
pub async fn page() -> Result<Response, ApiError> {
    asset("index.html")
}

/// `GET /docs/{file}`
pub async fn file(Segment(file): Segment) -> Result<Response, ApiError> {
    asset(&file)
}

fn asset(name: &str) -> Result<Response, ApiError> {
    let config = Config::from("/openapi.json").validator_url("none");
    let asset = utoipa_swagger_ui::serve(name, Arc::new(config)).map_err(|_| ApiError::internal())?;
    let asset = asset.ok_or_else(|| ApiError::not_found("there is no such page; the reference begins at /docs/"))?;
    let media_type = HeaderValue::from_str(&asset.content_type).map_err(|_| ApiError::internal())?;
    let policy: [(HeaderName, HeaderValue); 2] =
        [(header::CONTENT_TYPE, media_type), (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(ONLY_SELF))];
    Ok((policy, asset.bytes.into_owned()).into_response())
}

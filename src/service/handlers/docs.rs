//! The interface description, and Swagger UI from the binary, which needs no network.

use std::convert::Infallible;

use axum::body::Body;
use axum::http::{HeaderMap, HeaderValue, Request, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::{Extension, Router};
use swagger_ui_dist::{ApiDefinition, OpenApiSource};
use tower_service::Service as _;

use super::Segment;
use crate::service::background::background;
use crate::service::error::ApiError;
use crate::service::published::Published;

/// Allows only files of the service itself. The style sheet of the page contains its pictures.
const ONLY_SELF: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// The page. Its script is a file of its own, because [`ONLY_SELF`] forbids scripts within pages.
const PAGE: &str = r#"<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>revprio: HTTP interface</title>
<link rel="stylesheet" href="swagger-ui.css">
<link rel="stylesheet" href="index.css">
<div id="swagger-ui"></div>
<script src="swagger-ui-bundle.js"></script>
<script src="swagger-initializer.js"></script>
</html>
"#;

const STYLE: &str = "body { margin: 0; background: #fafafa; }\n";

const SCRIPT: &str = r##"SwaggerUIBundle({ url: "/openapi.json", dom_id: "#swagger-ui", deepLinking: true, validatorUrl: null });
"##;

/// The documents that describe the routes. They come from outside, because their descriptions include these handlers.
#[derive(Clone, Copy)]
pub struct Documents {
    /// Returns the OpenAPI document.
    pub openapi: fn() -> &'static Published,
    /// Returns the AsyncAPI document.
    pub asyncapi: fn() -> &'static Published,
}

/// Returns the OpenAPI document.
///
/// It describes all HTTP routes and their bodies. It is compressed if the client accepts gzip, and has an `ETag`.
#[utoipa::path(
    get,
    path = "/openapi.json",
    tag = "operation",
    responses(
        (status = 200, body = Object, content_type = "application/json", description = "OpenAPI 3.1."),
        (status = 304, description = "The client has this version, by `If-None-Match`.")
    )
)]
pub async fn document(Extension(documents): Extension<Documents>, headers: HeaderMap) -> Result<Response, ApiError> {
    send(documents.openapi, headers).await
}

/// Returns the AsyncAPI document.
///
/// It describes the messages of `/v1/controllers/{id}/stream`.
#[utoipa::path(
    get,
    path = "/asyncapi.json",
    tag = "operation",
    operation_id = "asyncapi_document",
    responses(
        (status = 200, body = Object, content_type = "application/json", description = "AsyncAPI 3.0."),
        (status = 304, description = "The client has this version, by `If-None-Match`.")
    )
)]
pub async fn async_document(
    Extension(documents): Extension<Documents>,
    headers: HeaderMap,
) -> Result<Response, ApiError> {
    send(documents.asyncapi, headers).await
}

/// Sends a document. The first request writes it, in another thread, so that steps do not wait.
async fn send(document: fn() -> &'static Published, headers: HeaderMap) -> Result<Response, ApiError> {
    background(move |_| document().answer(&headers)).await
}

/// `GET /docs`
pub async fn home() -> Redirect {
    Redirect::permanent("/docs/")
}

/// `GET /docs/`
pub async fn page() -> Response {
    text("text/html; charset=utf-8", PAGE)
}

/// `GET /docs/{file}`
pub async fn file(Segment(name): Segment) -> Result<Response, ApiError> {
    match name.as_str() {
        "index.html" => Ok(text("text/html; charset=utf-8", PAGE)),
        "index.css" => Ok(text("text/css; charset=utf-8", STYLE)),
        "swagger-initializer.js" => Ok(text("text/javascript; charset=utf-8", SCRIPT)),
        "swagger-ui.css" | "swagger-ui-bundle.js" => swagger_ui(&name).await,
        _ => Err(ApiError::not_found("there is no such page; the reference begins at /docs/")),
    }
}

/// Returns a file of Swagger UI.
async fn swagger_ui(name: &str) -> Result<Response, ApiError> {
    let definition =
        ApiDefinition { uri_prefix: "/ui", api_definition: OpenApiSource::Uri("/openapi.json"), title: None };
    let mut files: Router = swagger_ui_dist::generate_routes(definition);
    let request = Request::get(format!("/ui/{name}")).body(Body::empty()).map_err(|_| ApiError::internal())?;
    let answer: Result<Response, Infallible> = files.call(request).await;
    let mut answer = answer.unwrap_or_else(|never| match never {});
    answer.headers_mut().insert(header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(ONLY_SELF));
    if answer.status() == StatusCode::OK { Ok(answer) } else { Err(ApiError::internal()) }
}

fn text(media_type: &'static str, text: &'static str) -> Response {
    ([(header::CONTENT_TYPE, media_type), (header::CONTENT_SECURITY_POLICY, ONLY_SELF)], text).into_response()
}

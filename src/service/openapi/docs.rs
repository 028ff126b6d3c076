//! The interactive reference: Swagger UI out of the binary, without any network.

use std::sync::Arc;

use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Redirect, Response};
use utoipa_swagger_ui::Config;

use crate::service::error::ApiError;
use crate::service::segment::Segment;

/// Nothing but what the service itself serves; the page's own pictures stand in its style sheet.
const ONLY_SELF: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; \
                         connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// `GET /docs`
pub async fn docs_home() -> Redirect {
    Redirect::permanent("/docs/")
}

/// `GET /docs/`
pub async fn docs_page() -> Result<Response, ApiError> {
    asset("index.html")
}

/// `GET /docs/{file}`
pub async fn docs_file(Segment(file): Segment) -> Result<Response, ApiError> {
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

//! The interface description, made from the handlers and the bodies.
//!
//! The derives say names, types and meanings. Added to that: the ranges that the service enforces ([`ranges`]), the
//! problems that any request may meet ([`problems`]), and the files of `api/examples` ([`examples`]).

mod asyncapi;
mod docs;
mod examples;
mod problems;
mod ranges;
mod schemas;

use std::sync::LazyLock;

use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use revprio_api::wire;
use serde_json::{Value, json};
use utoipa::OpenApi;

use super::app::described;

pub use asyncapi::asyncapi;
pub use docs::{docs_file, docs_home, docs_page};
pub use problems::KINDS;

static OPENAPI: LazyLock<String> = LazyLock::new(|| text(&document_value()));
static ASYNCAPI: LazyLock<String> = LazyLock::new(|| text(&asyncapi()));

/// What stands at the top of the document.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "revprio",
        contact(),
        description = "Velocity resolution of redundant robot arms by reverse task priority, in closed form and as a QP \
                       cascade.\n\nSI units; the unit stands in the name where a bare number stands alone. Unknown and \
                       repeated fields are refused. Vectors of joints follow the robot's joint order, or name their \
                       joints. Bodies are JSON or MessagePack (`application/msgpack`, structs as maps with field \
                       names), the request by `Content-Type`, the answer by `Accept`, otherwise as the request. \
                       Numbers are finite doubles."
    ),
    servers((url = "/", description = "This service.")),
    tags(
        (name = "resolve", description = "Stateless questions: tasks in, joint velocities out."),
        (name = "control", description = "Controllers: one call per control period."),
        (name = "analysis", description = "What an arm or a contact can do."),
        (name = "robots", description = "The arms that requests can name."),
        (name = "simulation", description = "The built-in simulator against this service."),
        (name = "operation", description = "For those who run the service.")
    ),
    components(schemas(wire::Problem, wire::WatchedStep, wire::LiveFrame))
)]
pub struct ApiDoc;

/// The OpenAPI document.
pub fn openapi_document() -> &'static str {
    &OPENAPI
}

/// The AsyncAPI document of the stream.
pub fn asyncapi_document() -> &'static str {
    &ASYNCAPI
}

fn text(document: &Value) -> String {
    format!("{document:#}\n")
}

fn document_value() -> Value {
    let mut document = serde_json::to_value(described().into_openapi()).unwrap_or_default();
    schemas::complete(&mut document);
    ranges::complete(&mut document);
    problems::complete(&mut document);
    examples::complete(&mut document);
    secure(&mut document);
    document
}

/// Bearer tokens, where the service was given one.
fn secure(document: &mut Value) {
    document["security"] = json!([{}, {"token": []}]);
    document["components"]["securitySchemes"] = json!({"token": {
        "type": "http",
        "scheme": "bearer",
        "description": "The token that the service was started with; needed only if there is one.",
    }});
}

/// The OpenAPI document.
///
/// This one.
#[utoipa::path(
    get,
    path = "/openapi.json",
    tag = "operation",
    responses((status = 200, body = Object, content_type = "application/json", description = "OpenAPI 3.1."))
)]
pub async fn document() -> Response {
    json_text(openapi_document())
}

/// The AsyncAPI document.
///
/// It describes the messages of `/v1/controllers/{id}/stream`.
#[utoipa::path(
    get,
    path = "/asyncapi.json",
    tag = "operation",
    operation_id = "asyncapi_document",
    responses((status = 200, body = Object, content_type = "application/json", description = "AsyncAPI 3.0."))
)]
pub async fn async_document() -> Response {
    json_text(asyncapi_document())
}

fn json_text(text: &'static str) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], text).into_response()
}

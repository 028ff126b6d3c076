//! The interface description, from the handlers and the types of the bodies.
//!
//! The derives write names, types and descriptions. This module adds the details that the derives omit ([`schemas`]), the
//! ranges that the service checks ([`ranges`]), the problems of each operation ([`problems`]), and the files of
//! `api/examples` ([`examples`]). It describes the other modules, and only [`app`](super::app) uses it.

mod asyncapi;
mod examples;
mod problems;
mod ranges;
mod schemas;

use std::sync::LazyLock;

use revprio_api::wire;
use serde_json::{Value, json};
use utoipa::OpenApi;

use super::routes::routes;

static OPENAPI: LazyLock<String> = LazyLock::new(|| format!("{:#}\n", document()));
static ASYNCAPI: LazyLock<String> = LazyLock::new(|| format!("{:#}\n", asyncapi::asyncapi(&document())));

/// The head of the document.
#[derive(OpenApi)]
#[openapi(
    info(
        title = "revprio",
        contact(),
        description = "Computes joint velocities of redundant robot arms by reverse task priority, in closed form or with a \
                       hierarchy of QPs.\n\nAll quantities are in SI units. A field that holds a plain number has its unit \
                       in its name. Unknown and repeated fields are refused. Joint vectors follow the robot's joint order, \
                       or name their joints. Bodies are JSON or MessagePack (`application/msgpack`, structs as maps with \
                       field names). `Content-Type` selects the format of the request, `Accept` the format of the answer. \
                       Without `Accept`, the answer has the format of the request. Numbers are finite doubles."
    ),
    servers((url = "/", description = "This service.")),
    tags(
        (name = "resolve", description = "Stateless resolution: tasks in, joint velocities out."),
        (name = "control", description = "Controllers: one call per control period."),
        (name = "analysis", description = "Kinematics of arms, stability of contacts."),
        (name = "robots", description = "The arms that requests can name."),
        (name = "simulation", description = "The built-in simulator, with this service as the controller."),
        (name = "operation", description = "For operators of the service.")
    ),
    components(schemas(wire::Problem, wire::WatchedStep, wire::LiveFrame))
)]
struct Head;

/// Returns the OpenAPI document.
pub fn openapi_document() -> &'static str {
    &OPENAPI
}

/// Returns the AsyncAPI document of the stream.
pub fn asyncapi_document() -> &'static str {
    &ASYNCAPI
}

fn document() -> Value {
    let mut document = serde_json::to_value(routes(Head::openapi()).into_openapi()).unwrap_or_default();
    schemas::complete(&mut document);
    ranges::complete(&mut document);
    problems::complete(&mut document);
    examples::complete(&mut document);
    add_security(&mut document);
    document
}

/// Adds the bearer token, which only services with a token require.
fn add_security(document: &mut Value) {
    document["security"] = json!([{}, {"token": []}]);
    document["components"]["securitySchemes"] = json!({"token": {
        "type": "http",
        "scheme": "bearer",
        "description": "The token of the service. Required only if the service was started with one.",
    }});
}

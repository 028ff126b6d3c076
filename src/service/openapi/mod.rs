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

use super::handlers::docs::Documents;
use super::published::Published;
use super::routes::routes;

static OPENAPI: LazyLock<Value> = LazyLock::new(document);
static ASYNCAPI: LazyLock<Value> = LazyLock::new(|| asyncapi::asyncapi(&OPENAPI));

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
        (name = "control", description = "Control loops, recommended: open a session, then call it once per control period."),
        (name = "resolve", description = "Single problems without memory: tasks in, joint velocities out."),
        (name = "robots", description = "The arms that requests can name."),
        (name = "analysis", description = "Kinematics of an arm, stability of a contact, before you start a loop."),
        (name = "simulation", description = "The built-in simulator, with this service as the controller."),
        (name = "operation", description = "For operators of the service: health, metrics, these descriptions.")
    ),
    components(schemas(wire::Problem, wire::WatchedStep, wire::LiveFrame))
)]
struct Head;

/// Returns the OpenAPI document, indented.
pub fn openapi_document() -> String {
    format!("{:#}\n", *OPENAPI)
}

/// Returns the AsyncAPI document of the stream, indented.
pub fn asyncapi_document() -> String {
    format!("{:#}\n", *ASYNCAPI)
}

/// The documents that the service sends.
pub const DOCUMENTS: Documents = Documents { openapi: published_openapi, asyncapi: published_asyncapi };

/// Returns the OpenAPI document as the service sends it.
fn published_openapi() -> &'static Published {
    static PUBLISHED: LazyLock<Published> = LazyLock::new(|| Published::new(&OPENAPI));
    &PUBLISHED
}

/// Returns the AsyncAPI document as the service sends it.
fn published_asyncapi() -> &'static Published {
    static PUBLISHED: LazyLock<Published> = LazyLock::new(|| Published::new(&ASYNCAPI));
    &PUBLISHED
}

fn document() -> Value {
    let mut document = serde_json::to_value(routes(Head::openapi(), DOCUMENTS).into_openapi()).unwrap_or_default();
    schemas::complete(&mut document);
    ranges::complete(&mut document);
    add_ways(&mut document);
    problems::complete(&mut document);
    examples::complete(&mut document);
    add_security(&mut document);
    document
}

/// The page for users of the interface, whose first table the description shows too.
const PAGE: &str = include_str!("../../../docs/http.md");

/// Adds the table of the ways to call to the description.
fn add_ways(document: &mut Value) {
    let table: Vec<&str> =
        PAGE.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|')).collect();
    let text = document["info"]["description"].as_str().unwrap_or_default();
    document["info"]["description"] = json!(format!("{text}\n\n{}", table.join("\n")));
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

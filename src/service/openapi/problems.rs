//! The problems of each operation, and the formats of bodies, in the document.

use revprio_api::wire;
use serde_json::{Value, json};

use super::schemas::{reference, schema_name};
use crate::service::error::KINDS;

/// Adds the possible problems to every operation, and a table of all kinds to the document.
pub fn complete(document: &mut Value) {
    for (path, item) in document["paths"].as_object_mut().into_iter().flatten() {
        let operations = item.as_object_mut().into_iter().flatten().filter(|(_, operation)| operation.is_object());
        for (_, operation) in operations {
            let has_body = operation.get("requestBody").is_some();
            add_problems(path, operation, has_body);
            add_message_pack(path, operation, has_body);
        }
    }
    let kinds = KINDS.iter().map(|kind| format!("/problems/{}", kind.name));
    let problem = &mut document["components"]["schemas"][schema_name::<wire::Problem>()]["properties"];
    problem["type"]["enum"] = kinds.collect();
    problem["type"]["format"] = json!("uri-reference");
    problem["candidates"]["examples"] = json!([["left_hand", "right_hand"]]);
    let row = |kind: &crate::service::error::Kind| {
        format!("| `/problems/{}` | {} | {} | {} |\n", kind.name, kind.status.as_u16(), kind.cause, kind.remedy)
    };
    let table: String = KINDS.iter().map(row).collect();
    let text = document["info"]["description"].as_str().unwrap_or_default();
    document["info"]["description"] = json!(format!(
        "{text}\n\nA refused request gets a problem (RFC 9457, `application/problem+json`). It contains the JSON pointer of \
         the wrong field, if there is one. Its `type` is stable. Every operation refuses a wrong host (400, 403), unknown \
         encodings (415, 501) and, after many failures, a wrong token (429).\n\n| type | status | cause | remedy |\n|---|---|---|---|\n{table}"
    ));
}

fn add_problems(path: &str, operation: &mut Value, has_body: bool) {
    let mut statuses = match path {
        // The service answers `/healthz` with 503 while it is stuck.
        "/healthz" | "/readyz" => vec![403, 500, 503],
        _ => vec![401, 403, 500, 503],
    };
    if has_body {
        statuses.extend([400, 408, 413, 415, 422]);
    }
    if path.contains('{') {
        statuses.push(404);
    }
    let mut parameters = operation["parameters"].as_array().into_iter().flatten();
    if parameters.any(|parameter| parameter["in"] == "header") {
        statuses.push(400);
    }
    let Some(responses) = operation["responses"].as_object_mut() else { return };
    for status in statuses {
        responses.entry(status.to_string()).or_insert_with(|| json!({"description": causes(status)}));
    }
    for (status, response) in responses {
        if status.as_str() >= "400" {
            response["content"] = json!({"application/problem+json": {"schema": reference::<wire::Problem>()}});
        }
        let description = "ID of the request, as in its problem and in the log.";
        response["headers"]["X-Request-Id"] = json!({"description": description, "schema": {"type": "string"}});
        let (name, description, schema) = match status.as_str() {
            "401" => ("WWW-Authenticate", "`Bearer`.", json!({"type": "string"})),
            "426" => ("Upgrade", "`websocket`.", json!({"type": "string"})),
            "429" | "503" => {
                let schema = json!({"type": "integer", "minimum": 0, "maximum": 3600});
                ("Retry-After", "Time until the next attempt, s.", schema)
            }
            _ => continue,
        };
        response["headers"][name] = json!({"description": description, "schema": schema});
    }
}

/// Adds MessagePack as a format of the bodies.
fn add_message_pack(path: &str, operation: &mut Value, has_body: bool) {
    if has_body {
        let content = &mut operation["requestBody"]["content"];
        content["application/msgpack"] = json!({"schema": content["application/json"]["schema"]});
    }
    if path.starts_with("/v1/") {
        for (status, response) in operation["responses"].as_object_mut().into_iter().flatten() {
            let schema = response["content"]["application/json"]["schema"].clone();
            if status.starts_with('2') && schema.get("$ref").is_some() {
                response["content"]["application/msgpack"] = json!({"schema": schema});
            }
        }
    }
}

/// Returns the causes of a status, from all its kinds.
fn causes(status: u16) -> String {
    let kinds = KINDS.iter().filter(|kind| kind.status.as_u16() == status);
    kinds.map(|kind| format!("`{}`: {}", kind.name, kind.cause)).collect::<Vec<_>>().join(" ")
}

//! What any request may be refused for.

use serde_json::{Value, json};

/// Every kind of problem: status, last part of its `type`, when it comes, what to do.
pub const KINDS: [(u16, &str, &str, &str); 23] = [
    (
        400,
        "malformed",
        "The body is neither JSON nor MessagePack, or holds a number that is not finite.",
        "Mend the body's syntax where `detail` says.",
    ),
    (
        401,
        "unauthorized",
        "The service needs a token, and the request has none or another one.",
        "Send `Authorization: Bearer` with the service's token.",
    ),
    (403, "permanent", "What belongs to the service cannot be deleted.", "Delete only what was registered."),
    (
        403,
        "foreign-origin",
        "A web page of another site makes the request.",
        "Allow its origin when the service is started.",
    ),
    (
        404,
        "not-found",
        "There is no such route, robot, controller, scenario or simulation.",
        "Take the name from a list or from the answer that made it.",
    ),
    (
        404,
        "unknown-controller",
        "The session was deleted, was idle for too long, or the service was started anew.",
        "Open it again.",
    ),
    (405, "method-not-allowed", "The route exists, the method does not.", "Use a method that `Allow` names."),
    (406, "not-acceptable", "Nothing that `Accept` names can be had.", "Accept one of the types that `detail` names."),
    (408, "timeout", "The body did not arrive in time.", "Send it whole and at once."),
    (
        409,
        "sequence",
        "The sequence number of a state does not grow.",
        "Count up with every new state; only an unchanged state may be sent again.",
    ),
    (409, "name-taken", "The name belongs to another robot.", "Choose another."),
    (409, "no-trace", "The simulation is not finished, and may never be.", "Wait for its end; see its state."),
    (
        409,
        "not-live",
        "The simulation was not started as interactive, has not begun, or has ended.",
        "Start one with `interactive`.",
    ),
    (413, "too-large", "The body is too large.", "Send less; `detail` names the limit."),
    (
        415,
        "media-type",
        "The body is neither `application/json` nor `application/msgpack`.",
        "Say with `Content-Type` what is sent.",
    ),
    (
        422,
        "invalid",
        "A field is wrong: unknown, missing, of wrong type or size, out of range, or at odds with others.",
        "Change the field at `pointer` as `detail` says.",
    ),
    (426, "upgrade-required", "The route speaks WebSocket.", "Use a WebSocket client."),
    (500, "internal", "A defect of the service, not of the request.", "See the service's log."),
    (
        503,
        "too-many-controllers",
        "As many sessions are open as there is room for.",
        "Delete one, or wait until an idle one ends.",
    ),
    (
        503,
        "too-many-robots",
        "As many robots are registered as there is room for.",
        "Delete one, or wait until an idle one ends.",
    ),
    (503, "busy", "Long work takes all places.", "Try again after the time that `Retry-After` says."),
    (503, "overloaded", "More requests wait than can be answered in time.", "Send fewer, or start another server."),
    (503, "draining", "The service is about to end.", "Call another one."),
];

/// Adds to every operation what it may be refused for, and to the document what each kind means.
pub fn complete(document: &mut Value) {
    for (path, item) in document["paths"].as_object_mut().into_iter().flatten() {
        let operations = item.as_object_mut().into_iter().flatten().filter(|(_, operation)| operation.is_object());
        for (_, operation) in operations {
            refusals(path, operation);
        }
    }
    let kinds = KINDS.iter().map(|(_, kind, ..)| format!("/problems/{kind}"));
    let problem = &mut document["components"]["schemas"]["Problem"]["properties"];
    problem["type"]["enum"] = kinds.collect();
    problem["type"]["format"] = json!("uri-reference");
    let rows = KINDS
        .iter()
        .map(|(status, kind, when, remedy)| format!("| `/problems/{kind}` | {status} | {when} | {remedy} |\n"));
    let table: String = rows.collect();
    let text = document["info"]["description"].as_str().unwrap_or_default();
    document["info"]["description"] = json!(format!(
        "{text}\n\nWhat is refused gets a problem (RFC 9457, `application/problem+json`) with the JSON pointer of the \
         offending field, where there is one. Its `type` is stable.\n\n| type | status | when | remedy |\n|---|---|---|---|\n{table}"
    ));
}

fn refusals(path: &str, operation: &mut Value) {
    let has_body = operation.get("requestBody").is_some();
    let mut statuses = match path {
        "/healthz" => vec![500],
        "/readyz" => vec![500, 503],
        _ => vec![401, 403, 500, 503],
    };
    if has_body {
        statuses.extend([400, 408, 413, 415, 422]);
    }
    if path.contains('{') {
        statuses.push(404);
    }
    let Some(responses) = operation["responses"].as_object_mut() else { return };
    for status in statuses {
        responses.entry(status.to_string()).or_insert_with(|| json!({"description": meaning(status)}));
    }
    for (status, response) in responses {
        if status.as_str() >= "400" {
            response["content"] =
                json!({"application/problem+json": {"schema": {"$ref": "#/components/schemas/Problem"}}});
        }
        let id = json!({"description": "Name of the request, as in its problem and in the log.", "schema": {"type": "string"}});
        response["headers"]["X-Request-Id"] = id;
        let (name, description, schema) = match status.as_str() {
            "401" => ("WWW-Authenticate", "`Bearer`.", json!({"type": "string"})),
            "426" => ("Upgrade", "`websocket`.", json!({"type": "string"})),
            "503" => {
                ("Retry-After", "When to try again, s.", json!({"type": "integer", "minimum": 0, "maximum": 3600}))
            }
            _ => continue,
        };
        response["headers"][name] = json!({"description": description, "schema": schema});
    }
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

/// When a status comes, in the words of its kinds.
fn meaning(status: u16) -> String {
    let kinds = KINDS.iter().filter(|(other, ..)| *other == status);
    kinds.map(|(_, kind, when, _)| format!("`{kind}`: {when}")).collect::<Vec<_>>().join(" ")
}

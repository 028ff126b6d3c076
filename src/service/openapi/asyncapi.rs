//! The AsyncAPI document of the stream.

use std::collections::BTreeSet;

use revprio_api::wire;
use serde_json::{Value, json};

use super::schemas::{reference, references};

/// Returns the document. It contains the schemas of the OpenAPI document that its messages use.
pub fn asyncapi(openapi: &Value) -> Value {
    let schemas = &openapi["components"]["schemas"];
    let [state, answer, problem] =
        [reference::<wire::State>(), reference::<wire::StepAnswer>(), reference::<wire::Problem>()];
    let mut names = BTreeSet::new();
    references(schemas, &json!([state, answer, problem]), &mut names);
    let schemas: serde_json::Map<_, _> = names.into_iter().map(|name| (name.clone(), schemas[&name].clone())).collect();
    let message = |name: &str, title: &str, summary: &str, payload: &Value| {
        json!({
            "name": name,
            "title": title,
            "summary": summary,
            "contentType": if name == "problem" { "application/problem+json" } else { "application/json" },
            "payload": payload,
        })
    };
    let link = |name: &str| json!({"$ref": format!("#/channels/stream/messages/{name}")});
    json!({
        "asyncapi": "3.0.0",
        "info": {
            "title": "revprio stream",
            "version": openapi["info"]["version"],
            "license": {"name": openapi["info"]["license"]["name"]},
            "description": "A session over WebSocket: one state in, one answer out. A stream is faster than requests. \
                Open the session with POST /v1/controllers. Messages are JSON in text frames (no subprotocol or \
                `revprio.json`) or MessagePack in binary frames (`revprio.msgpack`), with structs as maps with field \
                names. A refused state is answered with a problem, and the stream continues. A message has at most 64 \
                KiB. The service pings every 10 s. It closes the stream with code 1001 when the service ends, 1002 for \
                a message that is not a WebSocket message or is larger than 128 KiB, 1011 for a defect of the service, \
                4404 when the controller has ended, 4408 when the client was silent for 30 s.",
        },
        "defaultContentType": "application/json",
        "servers": {"service": {
            "host": "127.0.0.1:8080",
            "protocol": "ws",
            "description": "The default address of `revprio serve`.",
            "security": [{"$ref": "#/components/securitySchemes/token"}],
        }},
        "channels": {"stream": {
            "address": "/v1/controllers/{id}/stream",
            "title": "Stream of a session",
            "description": "Several streams and requests may share a session; sequence numbers follow the same rules.",
            "parameters": {"id": {"description": "ID of the session, from the answer to POST /v1/controllers.",
                "examples": ["8f3c2f2e-4f0e-4d55-9a57-0f3a5a3c1b7e"]}},
            "messages": {
                "state": {"$ref": "#/components/messages/state"},
                "answer": {"$ref": "#/components/messages/answer"},
                "problem": {"$ref": "#/components/messages/problem"},
            },
            "bindings": {"ws": {
                "method": "GET",
                "headers": {"type": "object", "properties": {"Sec-WebSocket-Protocol": {
                    "type": "string",
                    "enum": ["revprio.json", "revprio.msgpack"],
                    "description": "Subprotocol: the format of the messages. The default is JSON.",
                }}},
                "bindingVersion": "0.1.0",
            }},
        }},
        "operations": {
            "step": {
                "action": "receive",
                "summary": "Receives a state and replies with one answer or problem.",
                "channel": {"$ref": "#/channels/stream"},
                "messages": [link("state")],
                "reply": {
                    "channel": {"$ref": "#/channels/stream"},
                    "messages": [link("answer"), link("problem")],
                },
            },
        },
        "components": {
            "messages": {
                "state": message("state", "State", "The measured state.", &state),
                "answer": message("answer", "Answer", "Joint velocities for one period, without `memory`.", &answer),
                "problem": message("problem", "Problem", "The reason why a state is refused. It has a `status`.", &problem),
            },
            "securitySchemes": {"token": openapi["components"]["securitySchemes"]["token"]},
            "schemas": schemas,
        },
    })
}

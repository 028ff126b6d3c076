//! The AsyncAPI document of the stream.

use serde_json::{Value, json};

use super::document_value;

/// The document: the schemas are those of the OpenAPI document.
pub fn asyncapi() -> Value {
    let openapi = document_value();
    let schemas = &openapi["components"]["schemas"];
    let mut needed = serde_json::Map::new();
    for name in ["State", "StepAnswer", "Problem"] {
        collect(schemas, name, &mut needed);
    }
    let message = |name: &str, title: &str, summary: &str, schema: &str| {
        json!({
            "name": name,
            "title": title,
            "summary": summary,
            "contentType": if name == "problem" { "application/problem+json" } else { "application/json" },
            "payload": {"$ref": format!("#/components/schemas/{schema}")},
        })
    };
    let link = |name: &str| json!({"$ref": format!("#/channels/stream/messages/{name}")});
    json!({
        "asyncapi": "3.0.0",
        "info": {
            "title": "revprio stream",
            "version": openapi["info"]["version"],
            "license": {"name": openapi["info"]["license"]["name"]},
            "description": "A session over WebSocket: one state message in, one answer out, for loops faster than \
                requests allow. Open the session with POST /v1/controllers. Without a subprotocol, or with \
                `revprio.json`, messages are JSON in text frames; with `revprio.msgpack` they are MessagePack in binary \
                frames, structs as maps with field names. A state that is refused is answered by a problem, and the \
                stream goes on. A message has at most 64 KiB. The service pings every 10 s and closes with code 1001 \
                when it ends, 1002 for what is no WebSocket message or larger than 1 MiB, 1011 for a defect of its own, \
                4404 when the controller has ended, 4408 when nothing was heard of the client for 30 s.",
        },
        "defaultContentType": "application/json",
        "servers": {"service": {
            "host": "127.0.0.1:8080",
            "protocol": "ws",
            "description": "Where `revprio serve` listens by default.",
            "security": [{"$ref": "#/components/securitySchemes/token"}],
        }},
        "channels": {"stream": {
            "address": "/v1/controllers/{id}/stream",
            "title": "Stream of a session",
            "description": "Several streams and requests may share a session; sequence numbers follow the same rules.",
            "parameters": {"id": {"description": "Name of the session, as POST /v1/controllers answered.",
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
                    "description": "Subprotocol: the format of the messages; JSON if left out.",
                }}},
                "bindingVersion": "0.1.0",
            }},
        }},
        "operations": {
            "step": {
                "action": "receive",
                "summary": "Takes a state and replies with one answer or problem.",
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
                "state": message("state", "State", "The measured state.", "State"),
                "answer": message("answer", "Answer", "Joint velocities for one period; without `memory`.", "StepAnswer"),
                "problem": message("problem", "Problem", "Why a state is refused; has a `status`.", "Problem"),
            },
            "securitySchemes": {"token": openapi["components"]["securitySchemes"]["token"]},
            "schemas": needed,
        },
    })
}

/// Takes over a schema with all that it refers to.
fn collect(schemas: &Value, name: &str, needed: &mut serde_json::Map<String, Value>) {
    if needed.contains_key(name) {
        return;
    }
    needed.insert(name.to_owned(), schemas[name].clone());
    let text = schemas[name].to_string();
    for link in text.split("#/components/schemas/").skip(1) {
        collect(schemas, link.split('"').next().unwrap_or_default(), needed);
    }
}

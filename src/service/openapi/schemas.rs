//! What the derives leave out of schemas.

use serde_json::{Value, json};

/// Tagged objects that refuse unknown fields: serde does so for the whole enum, the derive says it of structs alone.
const CLOSED: [&str; 5] = ["Inequality", "Law", "Limits", "NullSpaceMotion", "Profile"];

/// Completes all schemas.
pub fn complete(document: &mut Value) {
    for name in CLOSED {
        for variant in variants(&mut document["components"]["schemas"][name]) {
            if variant["type"] == "object" {
                variant["additionalProperties"] = json!(false);
            }
        }
    }
    for (name, schema) in document["components"]["schemas"].as_object_mut().into_iter().flatten() {
        title_variants(name, schema);
        visit(schema, &mut described_outside);
        visit(schema, &mut listed_example);
    }
    for (path, item) in document["paths"].as_object_mut().into_iter().flatten() {
        if let Some(parameter) = parameter(path) {
            item["parameters"] = json!([parameter]);
        }
        let events = "/get/responses/200/content/text~1event-stream";
        if let Some(content) = item.pointer_mut(events) {
            content["schema"] = match path.rsplit('/').next() {
                Some("watch") => event(&["step"], "WatchedStep"),
                Some("live") => event(&["frame", "end"], "LiveFrame"),
                _ => event(&["progress", "end"], "Simulation"),
            };
        }
    }
}

/// A server-sent event.
fn event(names: &[&str], data: &str) -> Value {
    json!({
        "type": "object",
        "description": "One event of the stream.",
        "required": ["event", "data"],
        "properties": {
            "event": {"type": "string", "enum": names, "description": "What it is about."},
            "data": {
                "type": "string",
                "description": format!("A `{data}` as JSON."),
                "contentMediaType": "application/json",
                "contentSchema": {"$ref": format!("#/components/schemas/{data}")},
            },
        },
    })
}

/// The variable part of a path.
fn parameter(path: &str) -> Option<Value> {
    let named = |of: &str, example: &str| {
        let schema = json!({"type": "string", "minLength": 1, "examples": [example]});
        Some(json!({"name": "name", "in": "path", "required": true, "description": of, "schema": schema}))
    };
    let identified = |of: &str| {
        let schema = json!({"type": "string", "format": "uuid", "examples": ["1f0c2f2e-4f0e-4d55-9a57-0f3a5a3c1b7e"]});
        Some(json!({"name": "id", "in": "path", "required": true, "description": of, "schema": schema}))
    };
    match path.split('/').nth(2)? {
        _ if !path.contains('{') => None,
        "robots" => named("Name of the robot.", "sawyer_dh"),
        "scenarios" => named("Name of the scenario.", "stiff_wall"),
        "simulations" => identified("Name of the run, as `POST /v1/simulations` answered."),
        _ => identified("Name of the session, as `POST /v1/controllers` answered."),
    }
}

/// JSON Schema knows lists of examples.
fn listed_example(schema: &mut Value) {
    let example = schema.as_object_mut().and_then(|fields| fields.remove("example"));
    if let Some(example) = example {
        schema["examples"] = json!([example]);
    }
}

/// What may be `null` or left out is described as a whole, not only where it is given.
fn described_outside(schema: &mut Value) {
    if schema.get("description").is_none()
        && let Some(option) =
            schema.get_mut("oneOf").and_then(Value::as_array_mut).and_then(|options| options.last_mut())
        && option.get("$ref").is_some()
        && let Some(description) = option.as_object_mut().and_then(|reference| reference.remove("description"))
    {
        schema["description"] = description;
    }
}

/// The alternatives of a schema.
pub fn variants(schema: &mut Value) -> impl Iterator<Item = &mut Value> {
    schema["oneOf"].as_array_mut().into_iter().flatten()
}

/// Names the alternatives of tagged objects after their tag, so that generated clients have names for them.
fn title_variants(name: &str, schema: &mut Value) {
    if schema.get("oneOf").is_none() {
        return;
    }
    for variant in variants(schema) {
        if let Some(kind) = variant["properties"]["kind"]["enum"][0].as_str() {
            let words = kind.split('_').map(|word| word[..1].to_uppercase() + &word[1..]);
            variant["title"] = json!(words.collect::<String>() + name);
            variant["properties"]["kind"]["description"] = json!("Says which.");
        }
    }
}

/// Calls `act` with every schema in a schema, itself first.
pub fn visit(schema: &mut Value, act: &mut impl FnMut(&mut Value)) {
    act(schema);
    let Some(fields) = schema.as_object_mut() else { return };
    for (key, part) in fields {
        match key.as_str() {
            "properties" => part.as_object_mut().into_iter().flatten().for_each(|(_, schema)| visit(schema, act)),
            "oneOf" | "allOf" | "anyOf" | "prefixItems" => {
                part.as_array_mut().into_iter().flatten().for_each(|schema| visit(schema, act));
            }
            "items" | "additionalProperties" if part.is_object() => visit(part, act),
            _ => (),
        }
    }
}

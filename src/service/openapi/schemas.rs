//! Completes the schemas that the derives write.

use std::collections::BTreeSet;

use revprio_api::wire;
use revprio_lab::simulator::TargetProgram;
use serde_json::{Value, json};
use utoipa::ToSchema;

/// Start of the references to schemas.
const SCHEMAS: &str = "#/components/schemas/";

/// Returns the name of the schema of a type.
pub fn schema_name<T: ToSchema>() -> String {
    T::name().into_owned()
}

/// Returns a reference to the schema of a type.
pub fn reference<T: ToSchema>() -> Value {
    json!({"$ref": format!("{SCHEMAS}{}", T::name())})
}

/// Adds the names of all schemas that `value` refers to, directly or through other schemas.
pub fn references(schemas: &Value, value: &Value, names: &mut BTreeSet<String>) {
    for link in value.to_string().split(SCHEMAS).skip(1) {
        let name = link.split('"').next().unwrap_or_default();
        if names.insert(name.to_owned()) {
            references(schemas, &schemas[name], names);
        }
    }
}

/// Completes all schemas.
pub fn complete(document: &mut Value) {
    // These enums refuse unknown fields, but the derive writes `additionalProperties` only for structs.
    let closed_enums = [
        schema_name::<wire::Inequality>(),
        schema_name::<wire::Law>(),
        schema_name::<wire::Limits>(),
        schema_name::<wire::NullSpaceMotion>(),
        schema_name::<wire::Profile>(),
        schema_name::<TargetProgram>(),
    ];
    for name in closed_enums {
        for variant in variants(&mut document["components"]["schemas"][name]) {
            if variant["type"] == "object" {
                variant["additionalProperties"] = json!(false);
            }
        }
    }
    for (name, schema) in document["components"]["schemas"].as_object_mut().into_iter().flatten() {
        title_variants(name, schema);
        visit(schema, &mut move_description_out);
        visit(schema, &mut list_example);
        visit(schema, &mut remove_null_default);
    }
    for (path, item) in document["paths"].as_object_mut().into_iter().flatten() {
        if let Some(parameter) = parameter(path) {
            item["parameters"] = json!([parameter]);
        }
        let events = "/get/responses/200/content/text~1event-stream";
        if let Some(content) = item.pointer_mut(events) {
            content["schema"] = match path.rsplit('/').next() {
                Some("watch") => event::<wire::WatchedStep>(&["step"]),
                Some("live") => event::<wire::LiveFrame>(&["frame", "end"]),
                _ => event::<wire::Simulation>(&["progress", "end"]),
            };
        }
    }
}

/// Returns the schema of a server-sent event with data of type `T`.
fn event<T: ToSchema>(names: &[&str]) -> Value {
    json!({
        "type": "object",
        "description": "One event of the stream.",
        "required": ["event", "data"],
        "properties": {
            "event": {"type": "string", "enum": names, "description": "Name of the event."},
            "data": {
                "type": "string",
                "description": format!("A `{}` as JSON.", T::name()),
                "contentMediaType": "application/json",
                "contentSchema": reference::<T>(),
            },
        },
    })
}

/// Returns the variable part of a path.
fn parameter(path: &str) -> Option<Value> {
    let name = |description: &str, example: &str| {
        let schema = json!({"type": "string", "minLength": 1, "examples": [example]});
        Some(json!({"name": "name", "in": "path", "required": true, "description": description, "schema": schema}))
    };
    let id = |description: &str| {
        let schema = json!({"type": "string", "format": "uuid", "examples": ["1f0c2f2e-4f0e-4d55-9a57-0f3a5a3c1b7e"]});
        Some(json!({"name": "id", "in": "path", "required": true, "description": description, "schema": schema}))
    };
    match path.split('/').nth(2)? {
        _ if !path.contains('{') => None,
        "robots" => name("Name of the robot.", "sawyer_dh"),
        "scenarios" => name("Name of the scenario.", "stiff_wall"),
        "simulations" => id("ID of the simulation, from the answer to `POST /v1/simulations`."),
        _ => id("ID of the session, from the answer to `POST /v1/controllers`."),
    }
}

/// Replaces the single example of the derive by a list, as JSON Schema requires.
fn list_example(schema: &mut Value) {
    let example = schema.as_object_mut().and_then(|fields| fields.remove("example"));
    if let Some(example) = example {
        schema["examples"] = json!([example]);
    }
}

/// Removes the default `null`, which the derive writes for some optional fields.
fn remove_null_default(schema: &mut Value) {
    if schema.get("default").is_some_and(Value::is_null) {
        schema.as_object_mut().map(|fields| fields.remove("default"));
    }
}

/// Moves the description of an optional value from its second variant to the whole value.
fn move_description_out(schema: &mut Value) {
    if schema.get("description").is_none()
        && let Some(option) =
            schema.get_mut("oneOf").and_then(Value::as_array_mut).and_then(|options| options.last_mut())
        && option.get("$ref").is_some()
        && let Some(description) = option.as_object_mut().and_then(|reference| reference.remove("description"))
    {
        schema["description"] = description;
    }
}

/// Returns the variants of a schema.
pub fn variants(schema: &mut Value) -> impl Iterator<Item = &mut Value> {
    schema.get_mut("oneOf").and_then(Value::as_array_mut).into_iter().flatten()
}

/// Gives the variants of tagged enums a title after their tag. Code generators use the titles as names.
fn title_variants(name: &str, schema: &mut Value) {
    if schema.get("oneOf").is_none() {
        return;
    }
    for variant in variants(schema) {
        if let Some(kind) = variant["properties"]["kind"]["enum"][0].as_str() {
            let words = kind.split('_').map(|word| word[..1].to_uppercase() + &word[1..]);
            variant["title"] = json!(words.collect::<String>() + name);
            variant["properties"]["kind"]["description"] = json!("Selects the variant.");
        }
    }
}

/// Calls `act` with a schema and then with all schemas inside it.
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

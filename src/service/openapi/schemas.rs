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

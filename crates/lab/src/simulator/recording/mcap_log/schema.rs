//! JSON schemas, derived from examples.

use serde::Serialize;
use serde_json::{Value, json};

use super::super::Recording;
use super::super::json_lines::write_object;

/// Returns the schema of the samples of a recording.
pub fn of_sample(recording: &Recording, timed: bool) -> serde_json::Result<String> {
    let mut first = Vec::new();
    if recording.samples.is_empty() {
        return of(&json!({}));
    }
    write_object(recording, 0, timed, &mut first)?;
    of(&serde_json::from_slice::<Value>(&first)?)
}

/// Returns the schema of messages with the structure of `example`. A field that is `null` may have any type.
pub fn of(example: &impl Serialize) -> serde_json::Result<String> {
    Ok(schema(&serde_json::to_value(example)?).to_string())
}

fn schema(example: &Value) -> Value {
    match example {
        Value::Null => json!({}),
        Value::Bool(_) => json!({"type": "boolean"}),
        Value::Number(_) => json!({"type": "number"}),
        Value::String(_) => json!({"type": "string"}),
        Value::Array(items) => json!({"type": "array", "items": items.first().map_or(json!({}), schema)}),
        Value::Object(fields) => {
            let properties: serde_json::Map<_, _> =
                fields.iter().map(|(name, value)| (name.clone(), schema(value))).collect();
            json!({"type": "object", "properties": properties})
        }
    }
}

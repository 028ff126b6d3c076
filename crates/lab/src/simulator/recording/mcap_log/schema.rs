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
    let mut example: Value = serde_json::from_slice(&first)?;
    // Without sensors it is `null` in all samples.
    if let Some(fields) = example.as_object_mut() {
        fields.retain(|name, value| name != "sensed" || !value.is_null());
    }
    of(&example)
}

/// Returns the schema of messages with the structure of `example`. What is `null` in it is a number that may be missing, and an empty list has
/// numbers: readers refuse a field without a type.
pub fn of(example: &impl Serialize) -> serde_json::Result<String> {
    Ok(schema(&serde_json::to_value(example)?).to_string())
}

fn schema(example: &Value) -> Value {
    match example {
        Value::Bool(_) => json!({"type": "boolean"}),
        Value::Null | Value::Number(_) => json!({"type": "number"}),
        Value::String(_) => json!({"type": "string"}),
        Value::Array(items) => json!({"type": "array", "items": schema(items.first().unwrap_or(&Value::Null))}),
        Value::Object(fields) => {
            let properties: serde_json::Map<_, _> =
                fields.iter().map(|(name, value)| (name.clone(), schema(value))).collect();
            json!({"type": "object", "properties": properties})
        }
    }
}

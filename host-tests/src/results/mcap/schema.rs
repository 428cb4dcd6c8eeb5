//! Derives the JSON schemas of messages from examples.

use serde_json::{Map, Value, json};

/// Derives the JSON schema of a type from two values of it. In `full` every field is present. A
/// field that is null in `default` may be null in a message.
pub fn schema(full: &Value, default: &Value) -> Value {
    let name = match full {
        Value::Object(fields) => {
            let properties: Map<_, _> = fields
                .iter()
                .map(|(name, value)| (name.clone(), schema(value, &default[name])))
                .collect();
            return json!({ "type": "object", "properties": properties });
        }
        Value::Array(items) => {
            let item = items.first().unwrap_or(&Value::Null);
            let mut array = json!({ "type": "array", "items": schema(item, item) });
            if default.is_null() {
                array["type"] = json!(["array", "null"]);
            }
            return array;
        }
        Value::Number(number) if number.is_u64() => "integer",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Bool(_) => "boolean",
        Value::Null => "null",
    };
    if default.is_null() {
        json!({ "type": [name, "null"] })
    } else {
        json!({ "type": name })
    }
}

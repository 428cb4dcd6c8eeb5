//! `run.mcap`: every sample of a run as JSON messages that Foxglove and other log viewers open.

use crate::record::{Heard, Sample, Truth};
use mcap::records::MessageHeader;
use mcap::{McapResult, WriteOptions};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::{Seek, Write};

/// Writes the channels `/truth` and `/bus`, one message a sample, and `/events`, one message an event.
/// Times are virtual nanoseconds since power-up.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(samples: &[Sample], out: impl Write + Seek) -> McapResult<()> {
    let mut log = WriteOptions::new()
        .compression(None)
        .library("tautrack")
        .create(out)?;
    let mut channel = |topic: &str, schema: &str, text: &Value| -> McapResult<u16> {
        let schema = log.add_schema(schema, "jsonschema", text.to_string().as_bytes())?;
        log.add_channel(schema, topic, "json", &BTreeMap::new())
    };
    let truth = channel(
        "/truth",
        "tautrack.Truth",
        &schema(&json!(full_truth()), &json!(Truth::default())),
    )?;
    let bus = channel(
        "/bus",
        "tautrack.Heard",
        &schema(&json!(full_heard()), &json!(Heard::default())),
    )?;
    let event = log_message(0.0, "");
    let events = channel("/events", "foxglove.Log", &schema(&event, &event))?;
    for (sequence, sample) in (0..).zip(samples) {
        let mut put = |channel_id: u16, message: &Value| {
            let log_time = (sample.time_s * 1e9).round() as u64;
            let header = MessageHeader {
                channel_id,
                sequence,
                log_time,
                publish_time: log_time,
            };
            log.write_to_known_channel(&header, message.to_string().as_bytes())
        };
        put(truth, &json!(sample.truth))?;
        put(bus, &json!(sample.heard))?;
        for text in &sample.heard.events {
            put(events, &log_message(sample.time_s, text))?;
        }
    }
    log.finish()?;
    Ok(())
}

/// The fields that Foxglove's log panel reads; level 3 is a warning there.
fn log_message(time_s: f64, text: &str) -> Value {
    let nanoseconds = (time_s * 1e9).round() as u64;
    let timestamp =
        json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 });
    json!({ "timestamp": timestamp, "level": 3, "message": text, "name": "bus", "file": "", "line": 0 })
}

fn full_truth() -> Truth {
    Truth {
        contacts: vec![[0.0; 3]],
        backward_margin: Some(0.0),
        forward_margin: Some(0.0),
        ..Truth::default()
    }
}

fn full_heard() -> Heard {
    Heard {
        position: Some([0.0; 3]),
        margins: Some([0.0; 4]),
        currents: vec![0.0],
        events: vec![String::new()],
        ..Heard::default()
    }
}

/// JSON schema of a type, told from a value with everything present and its default; what is null there may be absent.
fn schema(full: &Value, default: &Value) -> Value {
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

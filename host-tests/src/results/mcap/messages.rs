//! Converts the samples, frames and events of a run to JSON messages.

use crate::robots::NodeName;
use crate::scenario::Scenario;
use crate::simulator::record::{BusFrame, Event, Level, Sample};
use crate::simulator::slcan::MAX_CLIENTS;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io;

/// Metadata of the recording: name, seed, and the scenario as it ran, with changes from the command
/// line.
pub(super) fn metadata(scenario: &Scenario) -> io::Result<BTreeMap<String, String>> {
    let toml = toml::to_string(&scenario.description()).map_err(io::Error::other)?;
    Ok([
        ("name", scenario.name.clone()),
        ("seed", scenario.seed.to_string()),
        ("toml", toml),
    ]
    .map(|(key, text)| (key.to_owned(), text))
    .into())
}

/// Names of the participants of the bus, by their number: nodes, operator, clients, forger.
pub(super) fn senders(nodes: &[NodeName]) -> Vec<String> {
    let nodes = nodes.iter().map(NodeName::to_string);
    let clients = (1..=MAX_CLIENTS).map(|client| format!("client_{client}"));
    nodes
        .chain(["operator".to_owned()])
        .chain(clients)
        .chain(["forger".to_owned()])
        .collect()
}

/// A frame that the bus delivered.
#[derive(Serialize)]
pub(super) struct FrameMessage<'a> {
    sender: &'a str,
    id: u16,
    data: &'a [u8],
}

pub(super) fn frame_message<'a>(sent: &'a BusFrame, senders: &'a [String]) -> FrameMessage<'a> {
    FrameMessage {
        sender: senders.get(sent.sender).map_or("unknown", String::as_str),
        id: sent.frame.id(),
        data: sent.frame.data(),
    }
}

/// State of every drive by its node's name; a drive whose node has no power is left out.
pub(super) fn drives(nodes: &[NodeName], sample: &Sample) -> Value {
    let named = nodes.iter().zip(&sample.drives);
    let states: Map<_, _> = named
        .filter_map(|(node, state)| Some((node.to_string(), json!((*state)?))))
        .collect();
    states.into()
}

pub(super) fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// Converts a time in s to the form that Foxglove's messages use.
pub(super) fn timestamp(time_s: f64) -> Value {
    let nanoseconds = nanoseconds(time_s);
    json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 })
}

/// A message with the fields that Foxglove's log panel reads.
pub(super) fn log_message(time_s: f64, event: &Event) -> Value {
    let level = match event.level {
        Level::Info => 2,
        Level::Warning => 3,
        Level::Error => 4,
    };
    let name = if event.injected { "scenario" } else { "bus" };
    json!({ "timestamp": timestamp(time_s), "level": level, "message": event.text, "name": name, "file": "", "line": 0 })
}

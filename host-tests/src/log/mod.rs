//! `run.mcap`: everything that a run left behind, as JSON messages that Foxglove and other log viewers open.
//!
//! [`container`] writes the file, [`scene`] draws robot and ground, [`schema`] describes the messages. Here: which there are.

pub mod container;
pub mod scene;
pub mod schema;

use crate::machines;
use crate::plant::Plant;
use crate::record::{BusFrame, DriveState, Event, Heard, Level, Sample, Sketch, Truth};
use crate::scenario::Scenario;
use crate::slcan::MAX_CLIENTS;
use crate::summary::NodeFacts;
use container::Container;
use schema::schema;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Every so many samples the scene moves: 25 times a second.
const SCENE_STRIDE: usize = 4;

/// What a run left behind.
pub struct Recording<'a> {
    /// What was run.
    pub scenario: &'a Scenario,
    /// Its nodes in their order, the guard last.
    pub nodes: &'a [NodeFacts],
    /// Its samples.
    pub samples: &'a [Sample],
    /// The frames that the bus delivered, in order.
    pub frames: &'a [BusFrame],
}

/// Writes the channels `/truth`, `/bus` and `/drives`, one message a sample; `/can`, one message a frame; `/events`, one
/// message an event; `/scene` and `/tf` with ground and robot. The scenario as it ran and its seed are metadata.
/// Times are virtual nanoseconds since power-up.
///
/// # Errors
/// When `out` cannot be written.
pub fn write(recording: &Recording, out: impl Write) -> io::Result<()> {
    let Recording {
        scenario,
        nodes,
        samples,
        frames,
    } = *recording;
    let mut log = Container::new(out)?;
    log.metadata("scenario", &metadata(scenario)?)?;
    let plant = machines::machine(scenario).plant;
    let channels = Channels::new(&mut log, nodes);
    let senders = senders(nodes);
    let mut frames = frames.iter().peekable();
    let picture = Picture::new(plant.as_ref());
    if !samples.is_empty() {
        let still = scene::still(plant.as_ref(), samples);
        let time = nanoseconds(samples[0].time_s);
        log.message(channels.scene, time, still.to_string().as_bytes())?;
    }
    for (index, sample) in samples.iter().enumerate() {
        let time = nanoseconds(sample.time_s);
        while let Some(frame) = frames.next_if(|frame| frame.time_us * 1_000 <= time) {
            put_frame(&mut log, channels.can, frame, &senders)?;
        }
        let mut put = |channel: u16, message: &Value| {
            log.message(channel, time, message.to_string().as_bytes())
        };
        put(channels.truth, &json!(sample.truth))?;
        put(channels.bus, &json!(sample.heard))?;
        put(channels.drives, &drives(nodes, sample))?;
        for event in &sample.heard.events {
            put(channels.events, &log_message(sample.time_s, event))?;
        }
        if index % SCENE_STRIDE == 0 {
            put(channels.tf, &scene::transforms(&picture.shapes, sample))?;
            if !picture.sketch.lines.is_empty() {
                put(channels.scene, &scene::struts(&picture.sketch, sample))?;
            }
        }
    }
    for frame in frames {
        put_frame(&mut log, channels.can, frame, &senders)?;
    }
    log.finish()
}

/// How the robot is drawn.
struct Picture {
    shapes: Vec<crate::record::BodyShape>,
    sketch: Sketch,
}

impl Picture {
    fn new(plant: &dyn Plant) -> Self {
        Self {
            shapes: plant.bodies(),
            sketch: plant.sketch(),
        }
    }
}

/// Numbers of the channels.
struct Channels {
    truth: u16,
    bus: u16,
    drives: u16,
    can: u16,
    events: u16,
    scene: u16,
    tf: u16,
}

impl Channels {
    fn new<W: Write>(log: &mut Container<W>, nodes: &[NodeFacts]) -> Self {
        let mut channel = |topic: &str, name: &str, full: &Value, default: &Value| {
            log.channel(topic, name, &schema(full, default).to_string())
        };
        let event = Event {
            level: Level::Info,
            injected: false,
            text: String::new(),
        };
        let event = log_message(0.0, &event);
        let frame = json!({ "sender": "", "id": 0, "data": [0] });
        let sample = Sample {
            drives: vec![Some(DriveState::default()); nodes.len()],
            ..Sample::default()
        };
        let drives = drives(nodes, &sample);
        let (scene, tf) = (scene::example(), scene::transforms_example());
        Self {
            truth: channel(
                "/truth",
                "tautrack.Truth",
                &json!(full_truth()),
                &json!(Truth::default()),
            ),
            bus: channel(
                "/bus",
                "tautrack.Heard",
                &json!(full_heard()),
                &json!(Heard::default()),
            ),
            drives: channel("/drives", "tautrack.Drives", &drives, &drives),
            can: channel("/can", "tautrack.CanFrame", &frame, &frame),
            events: channel("/events", "foxglove.Log", &event, &event),
            scene: channel("/scene", "foxglove.SceneUpdate", &scene, &scene),
            tf: channel("/tf", "foxglove.FrameTransforms", &tf, &tf),
        }
    }
}

/// The scenario as it ran, with what the command line changed, and its seed.
fn metadata(scenario: &Scenario) -> io::Result<BTreeMap<String, String>> {
    let toml = toml::to_string(&scenario.description()).map_err(io::Error::other)?;
    Ok([
        ("name", scenario.name.clone()),
        ("seed", scenario.seed.to_string()),
        ("toml", toml),
    ]
    .map(|(key, text)| (key.to_owned(), text))
    .into())
}

/// Names of the participants of the bus in their order.
fn senders(nodes: &[NodeFacts]) -> Vec<String> {
    let nodes = nodes.iter().map(|node| node.name.to_string());
    let clients = (1..=MAX_CLIENTS).map(|client| format!("client_{client}"));
    nodes
        .chain(["operator".to_owned()])
        .chain(clients)
        .collect()
}

fn put_frame<W: Write>(
    log: &mut Container<W>,
    channel: u16,
    sent: &BusFrame,
    senders: &[String],
) -> io::Result<()> {
    let sender = senders.get(sent.sender).map_or("unknown", String::as_str);
    let message = json!({ "sender": sender, "id": sent.frame.id(), "data": sent.frame.data() });
    log.message(
        channel,
        sent.time_us * 1_000,
        message.to_string().as_bytes(),
    )
}

/// The drives by their nodes' names; one whose node has no power is absent.
fn drives(nodes: &[NodeFacts], sample: &Sample) -> Value {
    let named = nodes.iter().zip(&sample.drives);
    let states: Map<_, _> = named
        .filter_map(|(node, state)| Some((node.name.to_string(), json!((*state)?))))
        .collect();
    states.into()
}

fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9).round() as u64
}

/// A time as Foxglove's messages have it.
fn timestamp(time_s: f64) -> Value {
    let nanoseconds = nanoseconds(time_s);
    json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 })
}

/// The fields that Foxglove's log panel reads.
fn log_message(time_s: f64, event: &Event) -> Value {
    let level = match event.level {
        Level::Info => 2,
        Level::Warning => 3,
        Level::Error => 4,
    };
    let name = if event.injected { "scenario" } else { "bus" };
    json!({ "timestamp": timestamp(time_s), "level": level, "message": event.text, "name": name, "file": "", "line": 0 })
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
        events: vec![Event {
            level: Level::Info,
            injected: false,
            text: String::new(),
        }],
        ..Heard::default()
    }
}

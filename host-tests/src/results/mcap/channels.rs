//! Defines the channels of the recording, each with the JSON schema of its messages.

use super::container::Container;
use super::messages::{drives, log_message};
use super::scene;
use super::schema::schema;
use crate::robots::NodeName;
use crate::simulator::record::{DriveState, Event, Level, Received, Sample};
use crate::world::truth::Truth;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Numbers of the channels in the file.
pub(super) struct Channels {
    pub truth: u16,
    pub bus: u16,
    pub drives: u16,
    pub can: u16,
    pub events: u16,
    pub scene: u16,
    pub tf: u16,
}

impl Channels {
    /// # Errors
    /// When the file cannot be written.
    pub fn new<W: Write>(log: &mut Container<W>, nodes: &[NodeName]) -> io::Result<Self> {
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
        Ok(Self {
            truth: channel(
                "/truth",
                "tautrack.Truth",
                &json!(full_truth()),
                &json!(Truth::default()),
            )?,
            bus: channel(
                "/bus",
                "tautrack.Received",
                &json!(full_received()),
                &json!(Received::default()),
            )?,
            drives: channel("/drives", "tautrack.Drives", &drives, &drives)?,
            can: channel("/can", "tautrack.CanFrame", &frame, &frame)?,
            events: channel("/events", "foxglove.Log", &event, &event)?,
            scene: channel("/scene", "foxglove.SceneUpdate", &scene, &scene)?,
            tf: channel("/tf", "foxglove.FrameTransforms", &tf, &tf)?,
        })
    }
}

fn full_truth() -> Truth {
    Truth {
        contacts: vec![[0.0; 3]],
        backward_margin: Some(0.0),
        forward_margin: Some(0.0),
        ..Truth::default()
    }
}

fn full_received() -> Received {
    Received {
        position: Some([0.0; 3]),
        margins: Some([0.0; 4]),
        currents: vec![0.0],
        events: vec![Event {
            level: Level::Info,
            injected: false,
            text: String::new(),
        }],
        ..Received::default()
    }
}

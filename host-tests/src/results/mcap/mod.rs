//! Writes `run.mcap`: all data of a run as JSON messages, which Foxglove and other log viewers
//! open.
//!
//! This module orders the messages. [`container`] writes the file, `channels` defines the channels,
//! `messages` makes the messages, [`scene`] draws robot and ground, [`schema`] derives the schemas
//! of the messages.

mod channels;
pub mod container;
mod messages;
pub mod scene;
pub mod schema;

use crate::scenario::Scenario;
use crate::simulator::facts::NodeFacts;
use crate::simulator::record::{BusFrame, Sample};
use channels::Channels;
use container::Container;
use messages::{drives, log_message, metadata, nanoseconds, put_frame, senders};
use scene::Picture;
use serde_json::{Value, json};
use std::io::{self, Write};

/// Samples from one update of the scene to the next: 25 updates a second.
const SCENE_STRIDE: usize = 4;

/// All data of a run that the recording needs.
pub struct Recording<'a> {
    /// The scenario of the run.
    pub scenario: &'a Scenario,
    /// The nodes in their order, the guard last.
    pub nodes: &'a [NodeFacts],
    /// The samples in order of time.
    pub samples: &'a [Sample],
    /// The frames that the bus delivered, in order.
    pub frames: &'a [BusFrame],
}

/// Writes the recording.
///
/// The channels `/truth`, `/bus` and `/drives` have one message per sample, `/can` has one per
/// frame, `/events` has one per event. `/scene` and `/tf` show ground and robot. The scenario as it
/// ran and its seed are metadata. Times are ns of virtual time since power-up.
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
    let plant = scenario.plant();
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
        put(channels.bus, &json!(sample.received))?;
        put(channels.drives, &drives(nodes, sample))?;
        for event in &sample.received.events {
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

//! Writes `run.mcap` while a run goes on: all data of the run as JSON messages, which Foxglove and
//! other log viewers open.
//!
//! This module orders the messages. [`container`] writes the file, `channels` defines the channels,
//! `messages` makes the messages, `json` writes them as text, [`scene`] draws robot and ground,
//! [`schema`] derives the schemas of the messages.

mod channels;
pub mod container;
mod json;
mod messages;
pub mod scene;
pub mod schema;

use crate::robots::NodeName;
use crate::scenario::Scenario;
use crate::simulator::record::{BusFrame, Sample};
use crate::world::Plant;
use channels::Channels;
use container::Container;
use messages::{drives, frame_message, log_message, metadata, nanoseconds, senders};
use scene::{Extent, Picture};
use serde::Serialize;
use std::io::{self, Write};

/// Samples from one update of the scene to the next: 25 updates a second.
const SCENE_STRIDE: usize = 4;

/// The recording of a run that goes on.
///
/// The channels `/truth`, `/bus` and `/drives` have one message per sample, `/can` has one per
/// frame, `/events` has one per event. `/scene` and `/tf` show ground and robot. The scenario as it
/// ran and its seed are metadata. Times are ns of virtual time since power-up.
///
/// Memory: up to 1 MiB of messages, and about 0.3 kB for the index of each MiB in the file.
pub struct Recording<W: Write> {
    log: Container<W>,
    channels: Channels,
    nodes: Vec<NodeName>,
    senders: Vec<String>,
    plant: Box<dyn Plant>,
    picture: Picture,
    extent: Extent,
    /// Number of samples so far.
    samples: usize,
}

impl<W: Write> Recording<W> {
    /// Begins the file.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn new(scenario: &Scenario, out: W) -> io::Result<Self> {
        let mut log = Container::new(out)?;
        log.metadata("scenario", metadata(scenario)?)?;
        let nodes: Vec<_> = scenario.nodes().iter().map(|node| node.name).collect();
        let plant = scenario.plant();
        Ok(Self {
            channels: Channels::new(&mut log, &nodes)?,
            log,
            senders: senders(&nodes),
            nodes,
            picture: Picture::new(plant.as_ref()),
            plant,
            extent: Extent::default(),
            samples: 0,
        })
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn frame(&mut self, frame: &BusFrame) -> io::Result<()> {
        let message = frame_message(frame, &self.senders);
        put(
            &mut self.log,
            self.channels.can,
            frame.time_us * 1_000,
            &message,
        )
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn sample(&mut self, sample: &Sample) -> io::Result<()> {
        let time = nanoseconds(sample.time_s);
        let (log, channels) = (&mut self.log, &self.channels);
        put(log, channels.truth, time, &sample.truth)?;
        put(log, channels.bus, time, &sample.received)?;
        put(log, channels.drives, time, &drives(&self.nodes, sample))?;
        for event in &sample.received.events {
            put(
                log,
                channels.events,
                time,
                &log_message(sample.time_s, event),
            )?;
        }
        if self.samples.is_multiple_of(SCENE_STRIDE) {
            let Picture { shapes, sketch } = &self.picture;
            put(log, channels.tf, time, &scene::transforms(shapes, sample))?;
            if !sketch.lines.is_empty() {
                put(log, channels.scene, time, &scene::struts(sketch, sample))?;
            }
        }
        self.extent.include(sample.truth.cog);
        self.samples += 1;
        Ok(())
    }

    /// Ends the file: writes ground and shapes, and the index through which readers find all
    /// messages.
    ///
    /// How much ground the robot needs is known only now. Its message has the time 0 and a chunk of
    /// its own, so that readers find it first.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        if self.samples > 0 {
            self.log.end_chunk()?;
            let still = scene::still(self.plant.as_ref(), &self.extent);
            put(&mut self.log, self.channels.scene, 0, &still)?;
        }
        self.log.finish()
    }
}

fn put<W: Write>(
    log: &mut Container<W>,
    channel: u16,
    time_ns: u64,
    message: &impl Serialize,
) -> io::Result<()> {
    log.message(channel, time_ns, &json::text(message)?)
}

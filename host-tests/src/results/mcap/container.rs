//! Writes an MCAP file (<https://mcap.dev/spec>) from front to back: chunks of messages, and a
//! summary.
//!
//! The chunks are not compressed, because the crate `mcap` compresses with C libraries.

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// A chunk ends with the first message that exceeds this many bytes.
const CHUNK: u64 = 1 << 20;

/// An MCAP file that is being written.
pub struct Container<W: Write> {
    writer: Writer<NoSeek<W>>,
    /// Number of messages so far, by channel.
    counts: BTreeMap<u16, u32>,
}

impl<W: Write> Container<W> {
    /// Begins a file: writes magic bytes and header.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn new(out: W) -> io::Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .chunk_size(Some(CHUNK))
            .disable_seeking(true)
            .library("tautrack");
        let writer = options.create(NoSeek::new(out)).map_err(of_file)?;
        let counts = BTreeMap::new();
        Ok(Self { writer, counts })
    }

    /// Adds a channel of JSON messages with its own schema, and returns the channel's number.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn channel(&mut self, topic: &str, schema: &str, definition: &str) -> io::Result<u16> {
        let definition = definition.as_bytes();
        let schema = self.writer.add_schema(schema, "jsonschema", definition);
        let schema = schema.map_err(of_file)?;
        let channel = self
            .writer
            .add_channel(schema, topic, "json", &BTreeMap::new());
        channel.map_err(of_file)
    }

    /// Adds a message.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn message(&mut self, channel: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let count = self.counts.entry(channel).or_default();
        let header = MessageHeader {
            channel_id: channel,
            sequence: *count,
            log_time: time_ns,
            publish_time: time_ns,
        };
        *count += 1;
        let written = self.writer.write_to_known_channel(&header, data);
        written.map_err(of_file)
    }

    /// Writes the messages so far as a chunk. The next message begins a new one.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn end_chunk(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(of_file)
    }

    /// Adds a metadata record: a name with pairs of key and text.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn metadata(&mut self, name: &str, texts: BTreeMap<String, String>) -> io::Result<()> {
        let metadata = Metadata {
            name: name.to_owned(),
            metadata: texts,
        };
        self.writer.write_metadata(&metadata).map_err(of_file)
    }

    /// Writes the messages that are left, and the summary through which readers find all records.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.finish().map_err(of_file)?;
        self.writer.into_inner().into_inner().flush()
    }
}

/// The file's own error, if it is one.
fn of_file(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

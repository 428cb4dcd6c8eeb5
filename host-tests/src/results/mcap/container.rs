//! Writes an MCAP file (<https://mcap.dev/spec>) from front to back: chunks of messages, compressed
//! with LZ4, and a summary.
//!
//! The `mcap` crate can compress only with C libraries. This writer compresses in Rust. The tests
//! read its files with that crate and with the `mcap` package of Python.

use lz4_flex::frame::{BlockSize, FrameEncoder, FrameInfo};
use std::collections::BTreeMap;
use std::io::{self, Write};

const MAGIC: &[u8] = b"\x89MCAP0\r\n";
const COMPRESSION: &str = "lz4";
/// A chunk ends as soon as it has this many bytes before compression.
const CHUNK: usize = 1 << 20;

/// Operation codes of records.
const HEADER: u8 = 0x01;
const FOOTER: u8 = 0x02;
const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK_RECORD: u8 = 0x06;
const MESSAGE_INDEX: u8 = 0x07;
const CHUNK_INDEX: u8 = 0x08;
const STATISTICS: u8 = 0x0b;
const METADATA: u8 = 0x0c;
const METADATA_INDEX: u8 = 0x0d;
const SUMMARY_OFFSET: u8 = 0x0e;
const DATA_END: u8 = 0x0f;

/// Content of one record, little-endian.
#[derive(Default)]
struct Content(Vec<u8>);

impl Content {
    fn u16(mut self, value: u16) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u32(mut self, value: u32) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    fn u64(mut self, value: u64) -> Self {
        self.0.extend(value.to_le_bytes());
        self
    }

    /// Adds bytes or text, preceded by their length.
    fn bytes(self, bytes: &[u8]) -> Self {
        let mut with_length = self.u32(bytes.len() as u32);
        with_length.0.extend_from_slice(bytes);
        with_length
    }

    fn map(self, pairs: &BTreeMap<String, String>) -> Self {
        let content = pairs.iter().fold(Self::default(), |content, (key, value)| {
            content.bytes(key.as_bytes()).bytes(value.as_bytes())
        });
        self.bytes(&content.0)
    }

    /// Adds a map from channel numbers to values.
    fn by_channel(self, values: &BTreeMap<u16, u64>) -> Self {
        let content = values
            .iter()
            .fold(Self::default(), |content, (channel, value)| {
                content.u16(*channel).u64(*value)
            });
        self.bytes(&content.0)
    }
}

fn record(operation: u8, content: &Content) -> Vec<u8> {
    let mut bytes = vec![operation];
    bytes.extend((content.0.len() as u64).to_le_bytes());
    bytes.extend_from_slice(&content.0);
    bytes
}

/// Messages that are not written yet.
#[derive(Default)]
struct Chunk {
    records: Vec<u8>,
    times: Option<[u64; 2]>,
    /// Time in ns and position in the chunk of each message, by channel.
    index: BTreeMap<u16, Vec<[u64; 2]>>,
}

/// An MCAP file that is being written.
pub struct Container<W: Write> {
    out: W,
    /// Bytes written so far.
    length: u64,
    chunk: Chunk,
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
    chunk_indexes: Vec<Vec<u8>>,
    metadata_indexes: Vec<Vec<u8>>,
    counts: BTreeMap<u16, u64>,
    times: Option<[u64; 2]>,
}

impl<W: Write> Container<W> {
    /// Begins a file: writes magic bytes and header.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn new(out: W) -> io::Result<Self> {
        let mut container = Self {
            out,
            length: 0,
            chunk: Chunk::default(),
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
            counts: BTreeMap::new(),
            times: None,
        };
        container.put(MAGIC)?;
        let header = Content::default().bytes(b"").bytes(b"tautrack");
        container.put(&record(HEADER, &header))?;
        Ok(container)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.length += bytes.len() as u64;
        self.out.write_all(bytes)
    }

    /// Adds a channel of JSON messages with its own schema, and returns the channel's number.
    pub fn channel(&mut self, topic: &str, schema: &str, definition: &str) -> u16 {
        let id = self.channels.len() as u16 + 1;
        let schema = Content::default()
            .u16(id)
            .bytes(schema.as_bytes())
            .bytes(b"jsonschema")
            .bytes(definition.as_bytes());
        let channel = Content::default()
            .u16(id)
            .u16(id)
            .bytes(topic.as_bytes())
            .bytes(b"json")
            .map(&BTreeMap::new());
        let [schema, channel] = [record(SCHEMA, &schema), record(CHANNEL, &channel)];
        self.chunk.records.extend_from_slice(&schema);
        self.chunk.records.extend_from_slice(&channel);
        self.schemas.push(schema);
        self.channels.push(channel);
        id
    }

    /// Adds a message.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn message(&mut self, channel: u16, time_ns: u64, data: &[u8]) -> io::Result<()> {
        let count = self.counts.entry(channel).or_default();
        let mut content = Content::default()
            .u16(channel)
            .u32(*count as u32)
            .u64(time_ns)
            .u64(time_ns);
        *count += 1;
        content.0.extend_from_slice(data);
        let place = self.chunk.records.len() as u64;
        let index = self.chunk.index.entry(channel).or_default();
        index.push([time_ns, place]);
        self.chunk.times = Some(include(self.chunk.times, time_ns));
        self.chunk.records.extend(record(MESSAGE, &content));
        if self.chunk.records.len() >= CHUNK {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// Writes the messages so far as a chunk. The next message begins a new one.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn end_chunk(&mut self) -> io::Result<()> {
        let chunk = std::mem::take(&mut self.chunk);
        if chunk.records.is_empty() {
            return Ok(());
        }
        let [start, end] = chunk.times.unwrap_or_default();
        self.times = chunk.times.map_or(self.times, |[start, end]| {
            Some(include(Some(include(self.times, start)), end))
        });
        let info = FrameInfo::new()
            .block_size(BlockSize::Max1MB)
            .content_checksum(true);
        let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
        encoder.write_all(&chunk.records)?;
        let compressed = encoder.finish().map_err(io::Error::other)?;
        let size = chunk.records.len() as u64;
        // A CRC of 0 means that there is none: the LZ4 frame has its own checksum.
        let mut content = Content::default()
            .u64(start)
            .u64(end)
            .u64(size)
            .u32(0)
            .bytes(COMPRESSION.as_bytes())
            .u64(compressed.len() as u64);
        content.0.extend_from_slice(&compressed);
        let bytes = record(CHUNK_RECORD, &content);
        let chunk_at = self.length;
        self.put(&bytes)?;
        let indexes_at = self.length;
        let mut offsets = BTreeMap::new();
        for (channel, messages) in &chunk.index {
            offsets.insert(*channel, self.length);
            let messages = messages
                .iter()
                .fold(Content::default(), |content, [time, place]| {
                    content.u64(*time).u64(*place)
                });
            let index = Content::default().u16(*channel).bytes(&messages.0);
            self.put(&record(MESSAGE_INDEX, &index))?;
        }
        let index = Content::default()
            .u64(start)
            .u64(end)
            .u64(chunk_at)
            .u64(bytes.len() as u64)
            .by_channel(&offsets)
            .u64(self.length - indexes_at)
            .bytes(COMPRESSION.as_bytes())
            .u64(compressed.len() as u64)
            .u64(size);
        self.chunk_indexes.push(record(CHUNK_INDEX, &index));
        Ok(())
    }

    /// Adds a metadata record: a name with pairs of key and text.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn metadata(&mut self, name: &str, texts: &BTreeMap<String, String>) -> io::Result<()> {
        let bytes = record(
            METADATA,
            &Content::default().bytes(name.as_bytes()).map(texts),
        );
        let index = Content::default()
            .u64(self.length)
            .u64(bytes.len() as u64)
            .bytes(name.as_bytes());
        self.metadata_indexes.push(record(METADATA_INDEX, &index));
        self.put(&bytes)
    }

    /// Writes the messages that are left, and the summary through which readers find all records.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.end_chunk()?;
        self.put(&record(DATA_END, &Content::default().u32(0)))?;
        let summary_at = self.length;
        let [start, end] = self.times.unwrap_or_default();
        let statistics = Content::default()
            .u64(self.counts.values().sum())
            .u16(self.schemas.len() as u16)
            .u32(self.channels.len() as u32)
            .u32(0)
            .u32(self.metadata_indexes.len() as u32)
            .u32(self.chunk_indexes.len() as u32)
            .u64(start)
            .u64(end)
            .by_channel(&self.counts);
        let groups = [
            (SCHEMA, std::mem::take(&mut self.schemas)),
            (CHANNEL, std::mem::take(&mut self.channels)),
            (STATISTICS, vec![record(STATISTICS, &statistics)]),
            (CHUNK_INDEX, std::mem::take(&mut self.chunk_indexes)),
            (METADATA_INDEX, std::mem::take(&mut self.metadata_indexes)),
        ];
        let mut offsets = Vec::new();
        for (operation, records) in groups {
            let group_at = self.length;
            for bytes in records {
                self.put(&bytes)?;
            }
            if self.length > group_at {
                let mut offset = Content(vec![operation]);
                offset = offset.u64(group_at).u64(self.length - group_at);
                offsets.push(record(SUMMARY_OFFSET, &offset));
            }
        }
        let offsets_at = self.length;
        for bytes in offsets {
            self.put(&bytes)?;
        }
        let footer = Content::default().u64(summary_at).u64(offsets_at).u32(0);
        self.put(&record(FOOTER, &footer))?;
        self.put(MAGIC)?;
        self.out.flush()
    }
}

/// Extends a range of times so that it includes `time`.
fn include(range: Option<[u64; 2]>, time: u64) -> [u64; 2] {
    range.map_or([time; 2], |[start, end]| [start.min(time), end.max(time)])
}

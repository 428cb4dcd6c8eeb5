//! Decodes the log bytes of a node to lines of text. The lines are the same for every board.

use crate::programs::Board;
use defmt_decoder::{DecodeError, Table};
use std::fs;
use std::path::Path;

/// Assembles a node's log bytes to records, which may be spread over several steps.
pub struct LogReader {
    /// Texts of the records of an emulated node or a flash image, read from its ELF file; `None`
    /// for the nodes in this process, which send text.
    texts: Option<Table>,
    pending: Vec<u8>,
}

impl LogReader {
    /// Creates a reader for the program at `path`.
    ///
    /// # Errors
    /// A text that says why the log texts cannot be read from the program's file.
    pub fn new(board: Board, path: &Path) -> Result<Self, String> {
        let texts = match board {
            Board::Host => None,
            Board::Qemu | Board::Image => Some(texts(path)?),
        };
        Ok(Self {
            texts,
            pending: Vec::new(),
        })
    }

    /// Returns the records that are complete with these bytes, one line each:
    /// `WARN: what happened`.
    pub fn lines(&mut self, bytes: &[u8]) -> Vec<String> {
        self.pending.extend_from_slice(bytes);
        // Records of both kinds end with a byte that occurs nowhere else in them.
        let last = if self.texts.is_some() { 0 } else { b'\n' };
        let end = self.pending.iter().rposition(|byte| *byte == last);
        let records: Vec<u8> = self.pending.drain(..end.map_or(0, |at| at + 1)).collect();
        match &self.texts {
            Some(texts) => decode(texts, &records),
            None => String::from_utf8_lossy(&records)
                .lines()
                .map(str::to_owned)
                .collect(),
        }
    }
}

fn texts(path: &Path) -> Result<Table, String> {
    let program = fs::read(path).map_err(|error| error.to_string())?;
    match Table::parse(&program) {
        Ok(Some(table)) => Ok(table),
        Ok(None) => Err("the program has no log texts".into()),
        Err(error) => Err(error.to_string()),
    }
}

fn decode(texts: &Table, records: &[u8]) -> Vec<String> {
    let mut decoder = texts.new_stream_decoder();
    decoder.received(records);
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(record) => {
                let level = record.level().map_or("info", |level| level.as_str());
                lines.push(format!(
                    "{}: {}",
                    level.to_uppercase(),
                    record.display_message()
                ));
            }
            Err(DecodeError::Malformed) => lines.push("ERROR: a log record is not readable".into()),
            Err(DecodeError::UnexpectedEof) => return lines,
        }
    }
}

//! Decodes the log bytes of a node to lines of text. The lines are the same for every board.

#[cfg(unix)]
use super::log_texts::Texts;
use crate::programs::Board;
use std::path::Path;

/// Assembles a node's log bytes to records, which may be spread over several steps.
pub struct LogReader {
    /// Texts of the records of an emulated node or a flash image; `None` for the nodes in this
    /// process, which send text.
    texts: Option<Texts>,
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
            Board::Qemu | Board::Image => Some(Texts::read(path)?),
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
            Some(texts) => texts.decode(&records),
            None => String::from_utf8_lossy(&records)
                .lines()
                .map(str::to_owned)
                .collect(),
        }
    }
}

/// Texts of a program. A page on the web has no such programs.
#[cfg(not(unix))]
enum Texts {}

#[cfg(not(unix))]
impl Texts {
    fn read(_: &Path) -> Result<Self, String> {
        Err("a page has no files".to_owned())
    }

    fn decode(&self, _: &[u8]) -> Vec<String> {
        match *self {}
    }
}

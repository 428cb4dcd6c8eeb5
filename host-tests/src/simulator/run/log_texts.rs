//! Texts of the log records of a program with defmt, read from its ELF file.

use defmt_decoder::{DecodeError, Table};
use std::fs;
use std::path::Path;

/// The texts of a program.
pub(super) struct Texts(Table);

impl Texts {
    /// Reads the texts of the program at `path`.
    ///
    /// # Errors
    /// A text that says why the file has none.
    pub fn read(path: &Path) -> Result<Self, String> {
        let program = fs::read(path).map_err(|error| error.to_string())?;
        match Table::parse(&program) {
            Ok(Some(table)) => Ok(Self(table)),
            Ok(None) => Err("the program has no log texts".into()),
            Err(error) => Err(error.to_string()),
        }
    }

    /// Decodes whole records, one line each.
    pub fn decode(&self, records: &[u8]) -> Vec<String> {
        let mut decoder = self.0.new_stream_decoder();
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
                Err(DecodeError::Malformed) => {
                    lines.push("ERROR: a log record is not readable".into());
                }
                Err(DecodeError::UnexpectedEof) => return lines,
            }
        }
    }
}

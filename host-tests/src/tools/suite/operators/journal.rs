//! Writes each result of the operators' suite as a line of JSON as soon as it is known. An
//! interrupted suite therefore keeps its results and can continue.

use super::Row;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Mutex;

/// A file to which results are appended.
pub struct Journal {
    file: Mutex<File>,
}

impl Journal {
    /// Opens `path` to append results, and returns the results that it already has. A line that
    /// cannot be parsed, such as an incomplete one, is skipped.
    ///
    /// # Errors
    /// The file can neither be read nor made.
    pub fn open(path: &Path) -> io::Result<(Self, Vec<Row>)> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => return Err(error),
        };
        let rows = text
            .lines()
            .filter_map(|line| serde_json::from_str(line).ok());
        let rows = rows.collect();
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        if !text.is_empty() && !text.ends_with('\n') {
            writeln!(file)?;
        }
        let file = Mutex::new(file);
        Ok((Self { file }, rows))
    }

    /// Appends a result.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&self, row: &Row) -> io::Result<()> {
        let line = serde_json::to_string(row)? + "\n";
        let mut file = self
            .file
            .lock()
            .map_err(|_| io::Error::other("another run ended in a panic"))?;
        file.write_all(line.as_bytes())
    }
}

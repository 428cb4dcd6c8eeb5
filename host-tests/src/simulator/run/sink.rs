//! Receiver of the record of a run.

use crate::simulator::record::{BusFrame, Sample};
use std::{fmt, io};

/// Receives the record of a run in order of time, while the run goes on. The runner keeps nothing
/// of it, so its memory does not grow with the length of a run.
///
/// An error of any method ends the run.
pub trait Sink {
    /// Receives a sample; there are [`crate::simulator::record::SAMPLE_HZ`] per second.
    ///
    /// # Errors
    /// [`Unwritten`] if a file cannot be written.
    fn sample(&mut self, sample: Sample) -> Result<(), Unwritten>;

    /// Receives a frame that the bus delivered. It precedes the sample of the same time.
    ///
    /// # Errors
    /// [`Unwritten`] if a file cannot be written.
    fn frame(&mut self, _frame: &BusFrame) -> Result<(), Unwritten> {
        Ok(())
    }

    /// Receives a line of a node's log, with time and node.
    ///
    /// # Errors
    /// [`Unwritten`] if a file cannot be written.
    fn log(&mut self, _line: &str) -> Result<(), Unwritten> {
        Ok(())
    }
}

/// Keeps all samples in memory, and neither frames nor log lines.
impl Sink for Vec<Sample> {
    fn sample(&mut self, sample: Sample) -> Result<(), Unwritten> {
        self.push(sample);
        Ok(())
    }
}

/// A file of the results that could not be written.
#[derive(Debug)]
pub struct Unwritten {
    /// Name of the file.
    pub file: &'static str,
    /// The reason.
    pub error: io::Error,
}

impl fmt::Display for Unwritten {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} is not complete: {}", self.file, self.error)
    }
}

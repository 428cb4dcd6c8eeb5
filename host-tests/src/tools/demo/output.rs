//! Opens the folder for the results before a run, and writes the results into it after the run.

use crate::results::summary::Summary;
use crate::results::{mcap as log, report};
use crate::scenario::Scenario;
use crate::simulator::run::Outcome;
use std::error::Error;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

const SUMMARY: &str = "summary.json";
const LOG: &str = "run.mcap";
const REPORT: &str = "report.html";
const NODES_LOG: &str = "nodes.log";

/// Bytes on the disk that are reserved for `summary.json` before the run: more than any summary
/// needs.
const RESERVED: usize = 64 * 1024;

/// The folder for the results, with its open `summary.json`.
pub struct Output {
    folder: PathBuf,
    summary: File,
}

/// A file that could not be written, and the reason.
pub struct Unwritten {
    /// Name of the file.
    pub file: &'static str,
    /// The reason.
    pub error: Box<dyn Error>,
}

impl Output {
    /// Makes `folder` and opens its `summary.json`. The results of an earlier run stay.
    ///
    /// # Errors
    /// An error of the operating system, if the folder cannot be made or no file can be opened in
    /// it.
    pub fn open(folder: &Path) -> io::Result<Self> {
        fs::create_dir_all(folder)?;
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(false);
        Ok(Self {
            folder: folder.to_owned(),
            summary: options.open(folder.join(SUMMARY))?,
        })
    }

    /// Removes the results of an earlier run, and writes a preliminary `summary.json`. That file
    /// reserves space for the final one, which can then be written even if the disk becomes full
    /// during the run.
    ///
    /// # Errors
    /// An error of the operating system.
    pub fn begin(&mut self) -> io::Result<()> {
        for name in [LOG, REPORT, NODES_LOG] {
            match fs::remove_file(self.folder.join(name)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        let text = "{ \"ended_early\": \"the run has not ended, or was killed\" }";
        let mut text = text.as_bytes().to_vec();
        text.resize(RESERVED, b'\n');
        self.summary.set_len(0)?;
        self.summary.write_all(&text)
    }

    /// The folder's path.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Writes all files, the smallest first. If a file fails, its incomplete content stays, and the
    /// other files are still written. Returns the files that failed.
    pub fn write(
        mut self,
        scenario: &Scenario,
        summary: &Summary,
        outcome: &Outcome,
    ) -> Vec<Unwritten> {
        let mut unwritten = Vec::new();
        let mut note = |file, result: Result<(), Box<dyn Error>>| {
            if let Err(error) = result {
                unwritten.push(Unwritten { file, error });
            }
        };
        note(SUMMARY, self.write_summary(summary));
        let lines = outcome.log.iter().flat_map(|line| [line.as_str(), "\n"]);
        let text: String = lines.collect();
        note(NODES_LOG, self.write_text(NODES_LOG, &text));
        let report = report::html(scenario, summary, &outcome.samples);
        note(REPORT, self.write_text(REPORT, &report));
        note(LOG, self.write_log(scenario, summary, outcome));
        unwritten
    }

    fn write_summary(&mut self, summary: &Summary) -> Result<(), Box<dyn Error>> {
        let text = serde_json::to_vec_pretty(summary)?;
        io::Seek::rewind(&mut self.summary)?;
        self.summary.write_all(&text)?;
        Ok(self.summary.set_len(text.len() as u64)?)
    }

    fn write_text(&self, name: &str, text: &str) -> Result<(), Box<dyn Error>> {
        Ok(fs::write(self.folder.join(name), text)?)
    }

    fn write_log(
        &self,
        scenario: &Scenario,
        summary: &Summary,
        outcome: &Outcome,
    ) -> Result<(), Box<dyn Error>> {
        let mut out = BufWriter::new(File::create(self.folder.join(LOG))?);
        let recording = log::Recording {
            scenario,
            nodes: &summary.nodes,
            samples: &outcome.samples,
            frames: &outcome.frames,
        };
        log::write(&recording, &mut out)?;
        Ok(out.flush()?)
    }
}

//! Opens the folder for the results before a run, and writes the results into it while the run goes
//! on.

use crate::results::mcap::Recording;
use crate::results::report::Page;
use crate::results::summary::{Statistics, Summary};
use crate::scenario::Scenario;
use crate::simulator::record::{BusFrame, Sample};
use crate::simulator::run::{Ending, Sink, Unwritten};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, LineWriter, Write};
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

    /// The folder's path.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Removes the results of an earlier run, and begins those of a run of this scenario.
    ///
    /// Writes a preliminary `summary.json`. That file reserves space for the final one, which can
    /// then be written even if the disk becomes full during the run.
    ///
    /// # Errors
    /// An error of the operating system.
    pub fn begin(mut self, scenario: &Scenario) -> io::Result<Results> {
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
        self.summary.write_all(&text)?;
        let log = BufWriter::new(File::create(self.folder.join(LOG))?);
        Ok(Results {
            statistics: Statistics::new(scenario),
            page: Page::new(scenario),
            log: Some(Recording::new(scenario, log)?),
            nodes_log: LineWriter::new(File::create(self.folder.join(NODES_LOG))?),
            summary: self.summary,
            folder: self.folder,
        })
    }
}

/// The results of a run that goes on. `run.mcap` and `nodes.log` are written while it goes on,
/// summary and page at its end.
pub struct Results {
    folder: PathBuf,
    summary: File,
    statistics: Statistics,
    page: Page,
    /// `None` after an error.
    log: Option<Recording<BufWriter<File>>>,
    nodes_log: LineWriter<File>,
}

impl Sink for Results {
    fn sample(&mut self, sample: Sample) -> Result<(), Unwritten> {
        self.statistics.add(&sample);
        self.page.add(&sample);
        self.record(|log| log.sample(&sample))
    }

    fn frame(&mut self, frame: &BusFrame) -> Result<(), Unwritten> {
        self.record(|log| log.frame(frame))
    }

    fn log(&mut self, line: &str) -> Result<(), Unwritten> {
        writeln!(self.nodes_log, "{line}").map_err(unwritten(NODES_LOG))
    }
}

impl Results {
    /// Writes into the recording. A recording that could not be written is given up: it ends where
    /// the error occurred.
    fn record(
        &mut self,
        write: impl FnOnce(&mut Recording<BufWriter<File>>) -> io::Result<()>,
    ) -> Result<(), Unwritten> {
        let written = self.log.as_mut().map_or(Ok(()), write);
        if written.is_err() {
            self.log = None;
        }
        written.map_err(unwritten(LOG))
    }

    /// Ends all files, the smallest first. If a file fails, its incomplete content stays, and the
    /// other files are still written. Returns the summary, and the files that failed.
    pub fn finish(mut self, scenario: &Scenario, ending: &Ending) -> (Summary, Vec<Unwritten>) {
        let mut summary = self.statistics.summary(scenario, &ending.facts);
        summary.clients = ending.clients;
        if let Some(why) = &ending.error {
            summary.end_early(&why.to_string());
        }
        let report = self.folder.join(REPORT);
        let write_report = || {
            let mut out = BufWriter::new(File::create(report)?);
            self.page.write(scenario, &summary, &mut out)?;
            out.flush()
        };
        let written = [
            (SUMMARY, write_summary(&mut self.summary, &summary)),
            (NODES_LOG, self.nodes_log.flush()),
            (REPORT, write_report()),
            (LOG, self.log.map_or(Ok(()), Recording::finish)),
        ];
        let failed = written
            .into_iter()
            .filter_map(|(file, result)| result.map_err(unwritten(file)).err());
        (summary, failed.collect())
    }
}

fn unwritten(file: &'static str) -> impl FnOnce(io::Error) -> Unwritten {
    move |error| Unwritten { file, error }
}

fn write_summary(file: &mut File, summary: &Summary) -> io::Result<()> {
    let text = serde_json::to_vec_pretty(summary)?;
    io::Seek::rewind(file)?;
    file.write_all(&text)?;
    file.set_len(text.len() as u64)
}

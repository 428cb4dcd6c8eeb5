//! `cargo tool weigh`: finds B2P2's masses and centres of mass from weighings.
//!
//! The robot stands still with two of its axles on scales, at several chassis angles and pitches.
//! `weighings` is the file with the readings, `bodies` what the scales must show for given masses,
//! `fit` finds the masses that explain the readings best, and `report` prints them.

mod bodies;
mod fit;
mod report;
mod weighings;

use super::settings::{Backup, ToolError};
use bodies::Bodies;
use clap::Args;
use fit::Fit;
use std::fmt;
use std::path::{Path, PathBuf};
use tautrack::settings::{Setting, Settings};
use weighings::Weighings;

/// Product code of the guards (`shared/dictionary`).
const GUARD: u32 = 3;

/// Finds B2P2's masses and centres of mass from the readings of scales under its axles
#[derive(Args)]
pub(super) struct Arguments {
    /// File with the readings (TOML)
    file: PathBuf,
    /// Dump of all nodes. The masses start from those of its guard, and the results are written
    /// into all its nodes
    #[arg(long, value_name = "FILE")]
    dump: Option<PathBuf>,
}

/// Why no masses were written.
#[derive(Debug)]
pub(super) enum WeighError {
    /// The dump cannot be read or written, or is wrong.
    Dump(ToolError),
    /// A file cannot be used.
    File(PathBuf, String),
    /// The readings contradict each other, or give a value that no setting can have.
    Refused(String),
}

impl fmt::Display for WeighError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Dump(error) => error.fmt(f),
            Self::File(path, why) => write!(f, "{}: {why}", path.display()),
            Self::Refused(why) => write!(f, "{why}; nothing was written"),
        }
    }
}

/// Prints the masses that the readings give, and writes them into the dump, if there is one.
pub(super) fn run(arguments: &Arguments) -> Result<(), WeighError> {
    let weighings = Weighings::read(&arguments.file)?;
    let mut dump = arguments.dump.as_deref().map(open).transpose()?;
    let settings = match &dump {
        Some((_, settings)) => settings.clone(),
        None => Settings::default(),
    };
    let fit = Fit::new(&Bodies::new(&settings), &weighings, &settings)
        .map_err(|why| WeighError::File(arguments.file.clone(), why))?;
    report::print(&fit);
    let results = fit.settings().map_err(WeighError::Refused)?;
    report::uncertainty(&fit);
    if let (Some(path), Some((dump, _))) = (&arguments.dump, &mut dump) {
        for node in &mut dump.node {
            for (setting, value) in &results {
                let name = setting.description().name.to_owned();
                node.settings.insert(name, *value);
            }
        }
        dump.write(path).map_err(WeighError::Dump)?;
        report::written(path, dump.node.len());
    }
    Ok(())
}

/// Reads a dump and the settings of its guard.
fn open(path: &Path) -> Result<(Backup, Settings), WeighError> {
    let dump = Backup::read(path).map_err(WeighError::Dump)?;
    dump.check(path).map_err(WeighError::Dump)?;
    let guards: Vec<_> = dump
        .node
        .iter()
        .filter(|node| node.identity[1] == GUARD)
        .collect();
    let &[guard] = guards.as_slice() else {
        let count = guards.len();
        let why = format!("{count} nodes have the product code {GUARD} of a guard, not one");
        return Err(WeighError::File(path.to_owned(), why));
    };
    let mut settings = Settings::default();
    for (name, value) in &guard.settings {
        if let Some(setting) = Setting::from_name(name) {
            settings
                .set(setting.description().key, *value)
                .map_err(|error| WeighError::File(path.to_owned(), error.to_string()))?;
        }
    }
    Ok((dump, settings))
}

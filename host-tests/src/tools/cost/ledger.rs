//! Reads and writes `cost.toml`, the ledger of costs: the ceiling of each entry, and its pinned
//! count, which is the count at the last `cargo cost --write`.

use super::{CostError, Measurement};
use crate::programs::setup::checkout::root;
use serde::Deserialize;
use std::fmt::Write;
use std::path::PathBuf;
use std::{fs, io};

/// The content of `cost.toml`.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    /// The compiler for which the pinned counts are valid.
    pub rustc: String,
    /// Entries of kernels and ticks.
    pub kernel: Vec<Kernel>,
}

/// The entry of a kernel or tick.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Its name, as the firmware prints it.
    pub name: String,
    /// Maximum instructions of a call that are allowed.
    pub ceiling: Option<u32>,
    /// Why the entry exceeds its ceiling; absent if it does not.
    pub excuse: Option<String>,
    /// Maximum instructions of a call with the recorded compiler.
    pub pinned: u32,
    /// Worst error, as a test asserts it.
    pub error: Option<String>,
    /// Calls per second in its loop.
    pub rate_hz: Option<u32>,
}

impl Ledger {
    /// The entry with this name.
    pub fn kernel(&self, name: &str) -> Option<&Kernel> {
        self.kernel.iter().find(|kernel| kernel.name == name)
    }
}

fn path() -> io::Result<PathBuf> {
    Ok(root()?.join("host-tests/cost.toml"))
}

/// Reads `cost.toml`.
///
/// # Errors
/// The file cannot be read or parsed; the error names the line.
pub fn read() -> Result<Ledger, CostError> {
    toml::from_str(&fs::read_to_string(path()?)?)
        .map_err(|error| CostError::Malformed(format!("cost.toml: {error}")))
}

/// Writes compiler and counts of `measurement` into `cost.toml`. Everything else in it stays the
/// same.
///
/// # Errors
/// The file cannot be read or written.
pub fn pin(measurement: &Measurement) -> Result<(), CostError> {
    let old = fs::read_to_string(path()?)?;
    let (mut new, mut most) = (String::new(), None);
    for line in old.lines() {
        if let Some(name) = line.strip_prefix("name = ") {
            let name = name.trim_matches('"');
            let entry = measurement.entries.iter().find(|entry| entry.name == name);
            most = entry.map(|entry| entry.most);
        }
        // Writing to a string cannot fail.
        let _ = match most {
            Some(most) if line.starts_with("pinned = ") => writeln!(new, "pinned = {most}"),
            _ if line.starts_with("rustc = ") => writeln!(new, "rustc = \"{}\"", measurement.rustc),
            _ => writeln!(new, "{line}"),
        };
    }
    Ok(fs::write(path()?, new)?)
}

/// Lists the violations of `ledger` in `measurement`, one line each. Pinned counts are compared
/// only if the compiler is the recorded one.
pub fn violations(measurement: &Measurement, ledger: &Ledger) -> Vec<String> {
    let pins_hold = measurement.rustc == ledger.rustc;
    let mut found = Vec::new();
    for kernel in &ledger.kernel {
        let name = &kernel.name;
        let Some(entry) = measurement.entries.iter().find(|entry| entry.name == *name) else {
            found.push(format!("{name}: in cost.toml, but not measured"));
            continue;
        };
        let most = entry.most;
        if pins_hold && most != kernel.pinned {
            found.push(format!(
                "{name}: {most} instructions, pinned at {}; if that is meant: cargo cost --write",
                kernel.pinned
            ));
        }
        match (kernel.ceiling, &kernel.excuse) {
            (Some(ceiling), None) if most > ceiling => {
                found.push(format!("{name}: {most} instructions, ceiling {ceiling}"));
            }
            (Some(ceiling), Some(_)) if most <= ceiling => {
                found.push(format!(
                    "{name}: within its ceiling of {ceiling}, so it needs no excuse"
                ));
            }
            (None, Some(_)) => found.push(format!("{name}: an excuse, but no ceiling")),
            _ => {}
        }
    }
    for entry in &measurement.entries {
        if ledger.kernel(&entry.name).is_none() {
            found.push(format!("{}: measured, but not in cost.toml", entry.name));
        }
    }
    found
}

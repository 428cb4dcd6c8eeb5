//! The command line of `cargo cost`.

use super::{CostError, Measurement, ledger, measure, page};
use clap::Parser;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::{fmt, fs};

/// Counts instructions, models cycles and measures memory of the control code on the emulated
/// Cortex-M4F.
#[derive(Parser)]
#[command(name = "cargo cost")]
struct Arguments {
    /// Print the measurement as JSON.
    #[arg(long)]
    json: bool,
    /// Show what changed since the measurement in FILE, which --json printed.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Pin the counts in host-tests/cost.toml and write docs/cost.md.
    #[arg(long)]
    write: bool,
}

/// Runs the command. The first of `arguments` is the program's name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    match command(&Arguments::parse_from(arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo cost: {error}");
            ExitCode::FAILURE
        }
    }
}

fn command(arguments: &Arguments) -> Result<(), CostError> {
    let malformed = |path: &Path, error: &dyn fmt::Display| {
        CostError::Malformed(format!("{}: {error}", path.display()))
    };
    let before: Option<Measurement> = match &arguments.compare {
        None => None,
        Some(path) => Some(
            serde_json::from_str(&fs::read_to_string(path)?)
                .map_err(|error| malformed(path, &error))?,
        ),
    };
    let measurement = measure()?;
    if arguments.write {
        ledger::pin(&measurement)?;
        fs::write(page::path()?, page::page(&measurement, &ledger::read()?))?;
    }
    if arguments.json {
        let text = serde_json::to_string_pretty(&measurement)
            .map_err(|error| CostError::Malformed(error.to_string()))?;
        println!("{text}");
    } else {
        print!("{}", page::tables(&measurement, &ledger::read()?));
    }
    if let Some(before) = before {
        eprint!("{}", page::changes(&before, &measurement));
    }
    Ok(())
}

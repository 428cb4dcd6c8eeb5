//! `cargo cost`: what the control code costs on a Cortex-M4F, counted in the emulator, never timed.
//!
//! [`emulator`] runs the firmware's `cost` program and reads its counts; [`trace`] runs it once more and sees every instruction, of
//! which [`cycles`] makes a model of the time; [`image`] reads the sizes of programs,
//! [`stack`] the depth of their stacks. [`ledger`] holds the ceilings and the pinned
//! counts of `cost.toml`, and [`page`] writes docs/cost.md. This file is the command line.

pub mod cycles;
pub mod emulator;
pub mod image;
pub mod ledger;
pub mod page;
pub mod stack;
pub mod trace;

use crate::machines::Kind;
use crate::nodes::{self, Board, BuildError};
use clap::Parser;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Counted calls of every entry.
pub const CALLS: u32 = 1_000;
/// Traced calls of every entry: the first ones of those that are counted.
const TRACED_CALLS: u32 = 16;
/// Core clock of the motor board, Hz.
pub const CORE_HZ: f64 = 170e6;

/// What one kernel or tick costs.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// Its name, as in `cost.toml`.
    pub name: String,
    /// Counted calls.
    pub calls: u32,
    /// Least instructions of a call.
    pub least: u32,
    /// Most instructions of a call.
    pub most: u32,
    /// Mean of all calls.
    pub mean: f64,
    /// Modelled cycles of the slowest traced call: least and most, see [`cycles`].
    pub cycles: [u32; 2],
    /// Bytes of code that the traced calls ran through.
    pub code_bytes: u32,
}

/// Everything that was measured.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Measurement {
    /// The compiler, as it signs its programs.
    pub rustc: String,
    /// Kernels and ticks.
    pub entries: Vec<Entry>,
    /// Sizes of the nodes' programs.
    pub images: Vec<image::Image>,
}

/// Why nothing could be measured.
#[derive(Debug)]
pub enum CostError {
    /// The programs do not build.
    Build(BuildError),
    /// The emulator or a file cannot be used.
    Io(io::Error),
    /// A program, a file or the emulator's output is not what it should be.
    Malformed(String),
}

impl fmt::Display for CostError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Build(error) => error.fmt(f),
            Self::Io(error) => error.fmt(f),
            Self::Malformed(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for CostError {}

impl From<BuildError> for CostError {
    fn from(error: BuildError) -> Self {
        Self::Build(error)
    }
}

impl From<io::Error> for CostError {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Builds the programs, counts, traces, and reads their sizes. The same to the digit in every run with the same compiler.
///
/// # Errors
/// [`CostError`]; also when the controls do not read what they must, or counts and trace do not agree.
pub fn measure() -> Result<Measurement, CostError> {
    let instruments = nodes::instruments()?;
    let programs = nodes::build(Board::Qemu, Kind::B2p2)?;
    let elf = fs::read(&instruments.cost.path)?;
    let counts = emulator::count(&instruments.cost.path, CALLS)?;
    let traces = trace::trace(&instruments.cost.path, &elf, TRACED_CALLS)?;
    let entries = counts
        .into_iter()
        .map(|count| {
            let trace = traces
                .iter()
                .find(|trace| trace.name == count.name)
                .ok_or_else(|| CostError::Malformed(format!("{} was not traced", count.name)))?;
            Ok(Entry {
                mean: count.sum as f64 / f64::from(count.calls),
                name: count.name,
                calls: count.calls,
                least: count.least,
                most: count.most,
                cycles: trace.cycles,
                code_bytes: trace.code_bytes,
            })
        })
        .collect::<Result<_, CostError>>()?;
    let images = [
        ("axle", &programs.axle),
        ("screw", &programs.screw),
        ("guard", &programs.guard),
        ("ticks alone", &instruments.ticks),
    ]
    .into_iter()
    .map(|(name, program)| {
        let mut image = image::Image::read(name, &fs::read(&program.path)?)?;
        if name != "ticks alone" {
            image.stack = Some(stack::deepest(&program.path, name != "guard")?);
        }
        Ok(image)
    })
    .collect::<Result<_, CostError>>()?;
    Ok(Measurement {
        rustc: image::compiler(&elf)?,
        entries,
        images,
    })
}

/// Instructions, modelled cycles and sizes of the control code on the emulated Cortex-M4F.
#[derive(Parser)]
#[command(name = "cargo cost")]
struct Arguments {
    /// Print the measurement as JSON.
    #[arg(long)]
    json: bool,
    /// Show what changed since a measurement that --json printed into this file.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Pin the counts in host-tests/cost.toml and write docs/cost.md.
    #[arg(long)]
    write: bool,
}

/// The command line; `arguments` with the program's name.
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

//! Everything that is measured, and how.

use super::{CostError, emulator, image, stack, trace};
use crate::programs;
use crate::programs::Board;
use crate::robots::Kind;
use serde::{Deserialize, Serialize};
use std::fs;

/// Counted calls of every entry.
pub const CALLS: u32 = 1_000;
/// Traced calls of every entry: the first ones of those that are counted.
const TRACED_CALLS: u32 = 16;

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
    /// Modelled cycles of the slowest traced call: least and most, see [`super::cycles`].
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

/// Builds the programs, counts, traces, and reads their sizes. The same to the digit in every run
/// with the same compiler.
///
/// # Errors
/// [`CostError`]; also when the controls do not read what they must, or counts and trace do not
/// agree.
pub fn measure() -> Result<Measurement, CostError> {
    let instruments = programs::instruments()?;
    let programs = Kind::B2p2.programs(Board::Qemu)?;
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

//! Measures counts, cycles, sizes and stacks of all entries and programs.

use super::{CostError, emulator, image, stack, trace};
use crate::programs;
use crate::programs::Board;
use crate::robots::Kind;
use serde::{Deserialize, Serialize};
use std::fs;

/// Number of counted calls of every entry.
pub const CALLS: u32 = 1_000;
/// Number of traced calls of every entry: the first ones of the counted calls.
const TRACED_CALLS: u32 = 16;

/// Cost of one kernel or tick.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// Its name, as in `cost.toml`.
    pub name: String,
    /// Number of counted calls.
    pub calls: u32,
    /// Minimum instructions of a call.
    pub least: u32,
    /// Maximum instructions of a call.
    pub most: u32,
    /// Mean instructions of a call.
    pub mean: f64,
    /// Minimum and maximum of the modelled cycles of the slowest traced call, see
    /// [`super::cycles`].
    pub cycles: [u32; 2],
    /// Bytes of code that the traced calls executed.
    pub code_bytes: u32,
}

/// Results of a measurement.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Measurement {
    /// Version of the compiler that built the programs.
    pub rustc: String,
    /// Kernels and ticks.
    pub entries: Vec<Entry>,
    /// Memory of the programs.
    pub images: Vec<image::Image>,
}

/// Builds the programs, counts and traces their calls, and reads their sizes. With the same
/// compiler every run gives identical results.
///
/// # Errors
/// [`CostError`]; also if the control calls do not give the expected counts, or counts and trace
/// disagree.
pub fn measure() -> Result<Measurement, CostError> {
    let instruments = programs::instruments()?;
    let [axle, screw] = programs::drives()?;
    let guard = Kind::B2p2.programs(Board::Qemu)?.nodes;
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
        ("axle", &axle),
        ("screw", &screw),
        ("guard", &guard),
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

//! Runs the firmware's program `cost` in QEMU and reads the counts that it prints.

use crate::programs;
use crate::programs::setup::QEMU;
use std::process::Command;

/// Instructions of the calls of a function or a tick: one line that the program prints.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Count {
    /// Name of the function or tick.
    pub name: String,
    /// Minimum of all calls.
    pub minimum: u32,
    /// Maximum of all calls.
    pub maximum: u32,
    /// Mean of all calls, rounded down.
    pub mean: u32,
}

/// Builds the program and counts. Every run of the same program gives the same counts.
///
/// # Errors
/// The program does not build, QEMU does not run, or the program ends with failure: its controls do
/// not read 0 and 10, or the entry after the last line cannot be counted.
pub fn count() -> Result<Vec<Count>, String> {
    let program = programs::instruments().map_err(|error| error.to_string())?;
    let output = Command::new(QEMU)
        .args(["-M", "mps2-an386", "-nographic", "-monitor", "none"])
        // One instruction takes 256 ns of virtual time, and the virtual clock does not follow the
        // host's clock.
        .args(["-serial", "none", "-icount", "shift=8,sleep=off"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(&program.cost.path)
        .output()
        .map_err(|error| format!("{QEMU}: {error}"))?;
    let lines = String::from_utf8_lossy(&output.stdout);
    if !output.status.success() {
        return Err(format!("counting ends after these lines:\n{lines}"));
    }
    let counts = lines.lines().map(|line| parse(line).ok_or(line));
    let counts: Result<_, _> = counts.collect();
    counts.map_err(|line| format!("not a line of counts: {line}"))
}

fn parse(line: &str) -> Option<Count> {
    let mut fields = line.split(';');
    let name = fields.next()?.to_owned();
    let mut number = || fields.next()?.parse().ok();
    Some(Count {
        name,
        minimum: number()?,
        maximum: number()?,
        mean: number()?,
    })
}

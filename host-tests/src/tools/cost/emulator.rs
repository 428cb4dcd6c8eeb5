//! Runs the firmware's `cost` program in QEMU and reads the counts that it prints.

use super::CostError;
use crate::programs::setup::QEMU;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// The counts of one kernel or tick: one line that the program prints.
#[derive(Clone, PartialEq, Debug)]
pub struct Count {
    /// Name of the kernel or tick.
    pub name: String,
    /// Number of counted calls.
    pub calls: u32,
    /// Minimum instructions of a call.
    pub least: u32,
    /// Maximum instructions of a call.
    pub most: u32,
    /// Sum of the instructions of all calls.
    pub sum: u64,
    /// Address of the counted function.
    pub address: u32,
}

/// Starts `program` in QEMU with the additional QEMU options `arguments`. The program makes `calls`
/// calls per entry.
pub(super) fn start(program: &Path, calls: u32, arguments: &[&str]) -> Result<Child, CostError> {
    let mut child = Command::new(QEMU)
        .args([
            "-M",
            "mps2-an386",
            "-nographic",
            "-monitor",
            "none",
            "-serial",
            "none",
        ])
        // One instruction takes 256 ns of virtual time, and the virtual clock does not follow the
        // host's clock.
        .args(["-icount", "shift=8,sleep=off"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(arguments)
        .arg("-kernel")
        .arg(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()?;
    if let Some(mut input) = child.stdin.take() {
        input.write_all(&calls.to_le_bytes())?;
    }
    Ok(child)
}

/// Reads the remaining output of the child, waits until it ends and parses the lines.
pub(super) fn finish(mut child: Child) -> Result<Vec<Count>, CostError> {
    let (mut lines, mut errors) = (String::new(), String::new());
    if let Some(mut output) = child.stdout.take() {
        output.read_to_string(&mut lines)?;
    }
    if let Some(mut output) = child.stderr.take() {
        output.read_to_string(&mut errors)?;
    }
    let status = child.wait()?;
    if !status.success() {
        return Err(CostError::Malformed(format!(
            "the controls do not read 0 and 10, or the program fails ({status}):\n{lines}{errors}"
        )));
    }
    lines
        .lines()
        .map(|line| {
            parse(line).ok_or_else(|| CostError::Malformed(format!("not a line of counts: {line}")))
        })
        .collect()
}

/// Counts the instructions of `calls` calls of every kernel and tick.
///
/// # Errors
/// QEMU does not run, or the program's control calls do not give the expected counts.
pub fn count(program: &Path, calls: u32) -> Result<Vec<Count>, CostError> {
    finish(start(program, calls, &[])?)
}

fn parse(line: &str) -> Option<Count> {
    let mut fields = line.split(';');
    Some(Count {
        name: fields.next()?.to_owned(),
        calls: fields.next()?.parse().ok().filter(|calls| *calls > 0)?,
        least: fields.next()?.parse().ok()?,
        most: fields.next()?.parse().ok()?,
        sum: fields.next()?.parse().ok()?,
        address: u32::from_str_radix(fields.next()?.strip_prefix("0x")?, 16).ok()?,
    })
}

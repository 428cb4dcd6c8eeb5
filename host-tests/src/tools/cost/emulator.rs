//! Runs the firmware's `cost` program in QEMU and reads its lines.

use super::CostError;
use crate::programs::setup::QEMU;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// One line of the program.
#[derive(Clone, PartialEq, Debug)]
pub struct Count {
    /// What was counted.
    pub name: String,
    /// Counted calls.
    pub calls: u32,
    /// Least instructions of a call.
    pub least: u32,
    /// Most instructions of a call.
    pub most: u32,
    /// Instructions of all calls.
    pub sum: u64,
    /// Address of the function.
    pub address: u32,
}

/// Starts `program` with `arguments` more for QEMU, to make `calls` calls per entry.
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
        // One instruction is 256 ns of virtual time, and the clock never waits for the host's.
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

/// Reads what is left of the child's output, waits for its end and reads the lines.
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

/// Counts `calls` calls of everything.
///
/// # Errors
/// The emulator does not run, or the program finds its controls wrong.
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

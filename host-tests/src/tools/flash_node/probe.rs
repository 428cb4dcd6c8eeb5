//! Calls probe-rs, which talks to the debug probe.

use crate::programs::setup::{Missing, PROBE_RS, Part as Needed};
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::Command;

/// Name of the motor board's chip in probe-rs.
pub(super) const MOTOR_BOARD: &str = "STM32G431CBTx";
/// Name of the guard's board's chip in probe-rs.
pub(super) const GUARD_BOARD: &str = "STM32G474RETx";

/// Something that is written to the flash memory.
pub(super) enum Part {
    /// Program whose addresses are in its file.
    Elf(PathBuf),
    /// Bytes, and their address.
    Bytes(PathBuf, u32),
}

impl Part {
    fn arguments(&self, chip: &str) -> Vec<OsString> {
        let mut arguments: Vec<OsString> = ["download", "--chip", chip].map(Into::into).into();
        match self {
            Self::Elf(path) => {
                arguments.extend(["--binary-format", "elf"].map(Into::into));
                arguments.push(path.into());
            }
            Self::Bytes(path, address) => {
                let address = format!("{address:#010x}");
                arguments.extend(["--binary-format", "bin", "--base-address"].map(Into::into));
                arguments.extend([address.into(), path.into()]);
            }
        }
        arguments
    }
}

/// Checks that probe-rs is installed and finds a probe.
///
/// # Errors
/// One line that says what is missing and what to do.
pub(super) fn check() -> Result<(), String> {
    let output = Command::new(PROBE_RS)
        .arg("list")
        .output()
        .map_err(|error| not_started(&error))?;
    if String::from_utf8_lossy(&output.stdout).contains("[0]") {
        Ok(())
    } else {
        Err("no debug probe is connected: connect the USB cable of the board's ST-LINK".to_owned())
    }
}

/// Writes all parts to this chip and starts the program; only prints the commands if `dry_run`.
///
/// # Errors
/// One line with the command that failed.
pub(super) fn flash(chip: &str, parts: &[Part], dry_run: bool) -> Result<(), String> {
    let reset = ["reset", "--chip", chip].map(Into::into).into();
    let commands = parts.iter().map(|part| part.arguments(chip)).chain([reset]);
    for arguments in commands {
        let line: Vec<_> = arguments
            .iter()
            .map(|word| word.to_string_lossy())
            .collect();
        let line = format!("{PROBE_RS} {}", line.join(" "));
        println!("{line}");
        if dry_run {
            continue;
        }
        let status = Command::new(PROBE_RS)
            .args(&arguments)
            .status()
            .map_err(|error| not_started(&error))?;
        if !status.success() {
            return Err(format!("failed: {line}"));
        }
    }
    Ok(())
}

/// Reads a register of this chip.
///
/// # Errors
/// One line with the command that failed.
pub(super) fn read(chip: &str, address: u32) -> Result<u32, String> {
    let words = read_words(chip, address, 1)?;
    words.first().copied().ok_or_else(|| "no word".to_owned())
}

/// Reads words of this chip's memory.
///
/// # Errors
/// The same.
pub(super) fn read_words(chip: &str, address: u32, count: usize) -> Result<Vec<u32>, String> {
    let output = access(&[
        "read",
        "--chip",
        chip,
        "b32",
        &hex(address),
        &count.to_string(),
    ])?;
    // The words alone, or in lines behind an address and a colon.
    let words = output
        .split_whitespace()
        .filter(|word| !word.ends_with(':'));
    let words: Result<Vec<u32>, _> = words
        .map(|word| u32::from_str_radix(word.trim_start_matches("0x"), 16))
        .collect();
    match words {
        Ok(words) if words.len() == count => Ok(words),
        _ => Err(format!("{PROBE_RS} read: {}", output.trim())),
    }
}

/// Writes a register of this chip.
///
/// # Errors
/// The same.
pub(super) fn write(chip: &str, address: u32, word: u32) -> Result<(), String> {
    let [address, word] = [address, word].map(hex);
    access(&["write", "--chip", chip, "b32", &address, &word]).map(drop)
}

fn hex(word: u32) -> String {
    format!("{word:#010x}")
}

/// Runs a command, and returns what it prints.
fn access(arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(PROBE_RS)
        .args(arguments)
        .output()
        .map_err(|error| not_started(&error))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("failed: {PROBE_RS} {}", arguments.join(" ")))
    }
}

fn not_started(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        Missing(Needed::ProbeRs).to_string()
    } else {
        format!("probe-rs does not start: {error}")
    }
}

//! Node programs and their SHA-256 hashes.

use super::BuildError;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

/// Board that the nodes run on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Board {
    /// The Cortex-M4F that QEMU emulates. All published results are obtained with it.
    Qemu,
    /// The host itself, for fuzzing and debuggers: a process for each node, built as the tests are.
    Native,
    /// WebAssembly modules in the simulator's process, for sweeps: the fastest nodes.
    Wasm,
    /// The flash image of the motor board, on a model of its chip. It replaces single nodes of the
    /// other kinds, because there is none for the guard: see [`super::motor_board`].
    Image,
}

/// Node program.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Program {
    /// Path of the executable.
    pub path: PathBuf,
    /// SHA-256 of the executable, in hexadecimal.
    pub sha256: String,
}

/// Program of a simulated robot for one board.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Programs {
    /// Board that it runs on.
    pub board: Board,
    /// Program of all nodes; it contains their roles.
    pub nodes: Program,
}

/// Measuring programs for the emulated board, which are not nodes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instruments {
    /// Counts the instructions of the control code.
    pub cost: Program,
    /// Contains only the control ticks, for checks of its symbols.
    pub ticks: Program,
}

/// Computes the hash of the program at `path`.
pub(super) fn identify(path: PathBuf) -> Result<Program, BuildError> {
    match fs::read(&path) {
        Ok(bytes) => Ok(Program {
            path,
            sha256: hexadecimal(&Sha256::digest(bytes)),
        }),
        Err(error) => Err(BuildError::Unreadable { path, error }),
    }
}

/// Formats `bytes` in hexadecimal, as in a program's hash.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

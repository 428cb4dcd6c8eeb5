//! The programs, and which they are exactly.

use super::BuildError;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

/// What the nodes run on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Board {
    /// The Cortex-M4F that QEMU emulates; what a claim is made with.
    Qemu,
    /// The host itself; for sweeps, fuzzing and debuggers.
    Native,
}

/// One node program.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Program {
    /// The executable.
    pub path: PathBuf,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// The programs of all roles for one board.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Programs {
    /// What they run on.
    pub board: Board,
    /// Closes the loops of one motor.
    pub axle: Program,
    /// An axle whose set-point follows the chassis joint.
    pub screw: Program,
    /// Proposes and filters set-points.
    pub guard: Program,
}

/// Programs for the emulated board that are no nodes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Instruments {
    /// Counts the instructions of every kernel and tick.
    pub cost: Program,
    /// Nothing but the control ticks.
    pub ticks: Program,
}

pub(super) fn program(folder: &Path, role: &str) -> Result<Program, BuildError> {
    let path = folder.join(role);
    match fs::read(&path) {
        Ok(bytes) => Ok(Program {
            path,
            sha256: hexadecimal(&Sha256::digest(bytes)),
        }),
        Err(error) => Err(BuildError::Unreadable { path, error }),
    }
}

/// `bytes` in hexadecimal, as fingerprints are written.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

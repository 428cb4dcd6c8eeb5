//! Node programs and their SHA-256 hashes.

#[cfg(unix)]
use super::BuildError;
#[cfg(unix)]
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::PathBuf;

/// Board that the nodes run on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Board {
    /// The Cortex-M4F that QEMU emulates. All published results are obtained with it.
    Qemu,
    /// Values in the simulator's process: the fastest nodes, built as the tests are.
    Host,
    /// The flash image of the motor board, on a model of its chip. It replaces single nodes of the
    /// other kinds, because there is none for the guard: see [`super::motor_board`].
    Image,
}

/// Node program.
#[derive(Clone, PartialEq, Eq, Default, Debug)]
pub struct Program {
    /// Path of the executable. For nodes in this process, the name of the guard's program.
    pub path: PathBuf,
    /// SHA-256 of the executable, in hexadecimal; of this process, for nodes in it.
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

impl Programs {
    /// Nodes in this process, of the robot whose guard has the program `guard`, without a hash.
    pub fn in_process(guard: &str) -> Self {
        Self {
            board: Board::Host,
            nodes: Program {
                path: PathBuf::from(guard),
                sha256: String::new(),
            },
        }
    }
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
#[cfg(unix)]
pub(super) fn identify(path: PathBuf) -> Result<Program, BuildError> {
    match std::fs::read(&path) {
        Ok(bytes) => Ok(Program {
            path,
            sha256: hexadecimal(&Sha256::digest(bytes)),
        }),
        Err(error) => Err(BuildError::Unreadable { path, error }),
    }
}

/// Nodes in this process, of the robot whose guard has the program `guard`.
#[cfg(unix)]
pub(super) fn own(guard: &str) -> Result<Program, BuildError> {
    static SHA256: std::sync::OnceLock<String> = std::sync::OnceLock::new();
    let path = PathBuf::from(guard);
    if let Some(sha256) = SHA256.get() {
        let sha256 = sha256.clone();
        return Ok(Program { path, sha256 });
    }
    let unreadable = |error| BuildError::Unreadable {
        path: path.clone(),
        error,
    };
    let executable = std::env::current_exe().map_err(unreadable)?;
    let sha256 = identify(executable)?.sha256;
    let sha256 = SHA256.get_or_init(|| sha256).clone();
    Ok(Program { path, sha256 })
}

/// Formats `bytes` in hexadecimal, as in a program's hash.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}

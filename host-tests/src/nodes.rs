//! Builds the node programs, for the emulated board or for the host, and says exactly which programs they are.

use crate::machines::Kind;
use crate::setup::checkout::{NoCheckout, root};
use crate::setup::machine::{DISTRIBUTION_CARGO, DISTRIBUTION_LINKER, DISTRIBUTION_RUSTC};
use crate::setup::{self, Missing, TARGET, Toolchain};
use sha2::{Digest, Sha256};
use std::env;
use std::ffi::OsStr;
use std::fmt::{self, Write};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Lines of cargo's output that an error shows.
const SHOWN_LINES: usize = 30;

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

/// Why there are no programs.
#[derive(Debug)]
pub enum BuildError {
    /// There are no sources.
    NoCheckout(NoCheckout),
    /// Something needed is not installed.
    Missing(Missing),
    /// cargo does not start.
    Cargo(io::Error),
    /// cargo fails.
    Failed {
        /// The board that was built for.
        board: Board,
        /// The last lines that cargo wrote.
        output: String,
    },
    /// cargo succeeds, but the program cannot be read.
    Unreadable {
        /// The program.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NoCheckout(error) => write!(f, "{error}"),
            Self::Missing(missing) => write!(f, "{missing}"),
            Self::Cargo(error) => write!(f, "cargo does not start: {error}"),
            Self::Failed { board, output } => {
                write!(f, "the nodes for {board:?} do not build:\n{output}")
            }
            Self::Unreadable { path, error } => {
                write!(f, "cannot read {}: {error}", path.display())
            }
        }
    }
}

impl std::error::Error for BuildError {}

/// Builds the nodes of one robot for `board`; quick when nothing has changed. Installs what that takes, see [`setup`].
///
/// May be called from several threads and programs at once: cargo lets one of them build and the others wait.
///
/// # Errors
/// [`BuildError`], with cargo's last lines when the build fails.
pub fn build(board: Board, kind: Kind) -> Result<Programs, BuildError> {
    let folder = folder_of(board, &["axle", "screw", kind.guard_program()])?;
    Ok(Programs {
        board,
        axle: program(&folder, "axle")?,
        screw: program(&folder, "screw")?,
        guard: program(&folder, kind.guard_program())?,
    })
}

/// Builds what measures the control code on the emulated core, as [`build`] builds the nodes.
///
/// # Errors
/// As [`build`].
pub fn instruments() -> Result<Instruments, BuildError> {
    let folder = folder_of(Board::Qemu, &["cost", "ticks"])?;
    Ok(Instruments {
        cost: program(&folder, "cost")?,
        ticks: program(&folder, "ticks")?,
    })
}

/// Builds `programs` and returns the folder that they are in.
fn folder_of(board: Board, programs: &[&str]) -> Result<PathBuf, BuildError> {
    let root = root().map_err(BuildError::NoCheckout)?;
    let toolchain = match board {
        Board::Qemu => setup::ensure().map_err(BuildError::Missing)?,
        Board::Native => Toolchain::Current,
    };
    let mut folder = root.join("target").join(match toolchain {
        Toolchain::Current => "nodes",
        Toolchain::Distribution => "nodes-distribution",
    });
    let output = command(board, toolchain, programs, &folder)
        .current_dir(root)
        .output()
        .map_err(BuildError::Cargo)?;
    if !output.status.success() {
        let output = last_lines(&String::from_utf8_lossy(&output.stderr));
        return Err(BuildError::Failed { board, output });
    }
    if board == Board::Qemu {
        folder.push(TARGET);
    }
    folder.push("firmware");
    Ok(folder)
}

fn command(board: Board, toolchain: Toolchain, programs: &[&str], target_folder: &Path) -> Command {
    let cargo = match toolchain {
        Toolchain::Current => env::var_os("CARGO").unwrap_or_else(|| "cargo".into()),
        Toolchain::Distribution => DISTRIBUTION_CARGO.into(),
    };
    let mut command = Command::new(cargo);
    for (name, _) in env::vars_os() {
        if changes_a_build(&name) {
            command.env_remove(name);
        }
    }
    command.arg("build");
    command.args(["--package", "tautrack-firmware"]);
    for program in programs {
        command.args(["--bin", program]);
    }
    command
        .args(["--locked", "--profile", "firmware", "--target-dir"])
        .arg(target_folder);
    if board == Board::Qemu {
        command.args(["--target", TARGET, "--features", "mps2"]);
    }
    if toolchain == Toolchain::Distribution {
        // Its compiler is a stable one, which builds the library of another target only when told that it may.
        command
            .arg("-Zbuild-std=core")
            .env("RUSTC_BOOTSTRAP", "1")
            .env("RUSTC", DISTRIBUTION_RUSTC);
        command.env(
            "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER",
            DISTRIBUTION_LINKER,
        );
    }
    command
}

/// Whether an environment variable can make cargo build another program. `cargo run` and `cargo test` set many for
/// what they start, and equal sources shall give equal nodes; where crates are fetched from is the user's business.
pub fn changes_a_build(name: &OsStr) -> bool {
    let name = name.to_string_lossy();
    let fetching = [
        "CARGO_HTTP_",
        "CARGO_NET_",
        "CARGO_REGISTRY_",
        "CARGO_REGISTRIES_",
        "CARGO_SOURCE_",
    ];
    if name == "CARGO_HOME" || fetching.iter().any(|prefix| name.starts_with(prefix)) {
        return false;
    }
    let rustc =
        name.starts_with("RUSTC") || name.starts_with("RUSTFLAGS") || name.starts_with("RUSTDOC");
    name.starts_with("CARGO_") || rustc || name.starts_with("DEFMT_")
}

fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(SHOWN_LINES)..].join("\n")
}

fn program(folder: &Path, role: &str) -> Result<Program, BuildError> {
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

//! Calls cargo to build the node programs.

use super::setup::checkout::root;
use super::setup::machine::{DISTRIBUTION_CARGO, DISTRIBUTION_LINKER, DISTRIBUTION_RUSTC};
use super::setup::{self, Part, TARGET, Toolchain, WASM_TARGET};
use super::{Board, BuildError};
use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Maximum number of lines of cargo's output in an error.
const SHOWN_LINES: usize = 30;

/// What cargo builds.
pub(super) struct Recipe<'a> {
    /// Name of the board, for errors.
    pub board: &'a str,
    /// Compiler target; `None` for the host.
    pub target: Option<&'static str>,
    /// Features of the firmware.
    pub features: &'a str,
    /// Profile of the workspace.
    pub profile: &'a str,
    /// Log records (`DEFMT_LOG`) of a flash image, the same for all of a profile. `None`: the
    /// program is not flashed.
    pub flashed_with_log: Option<&'a str>,
    /// Compiles the library with the program, for size and with [`SMALL_FLAGS`]. Its copies of
    /// memory are slow.
    pub small_library: bool,
}

impl Recipe<'_> {
    /// Programs that run on the board of the simulator.
    pub(super) fn simulated(board: Board, features: &str) -> Recipe<'_> {
        Recipe {
            board: board.name(),
            target: target(board),
            features,
            profile: "firmware",
            flashed_with_log: None,
            small_library: false,
        }
    }
}

/// Builds `programs` and returns the folder that contains them.
pub(super) fn folder_of(recipe: &Recipe, programs: &[&str]) -> Result<PathBuf, BuildError> {
    let root = root().map_err(BuildError::NoCheckout)?;
    let toolchain = setup::ensure(needs(recipe)).map_err(BuildError::Missing)?;
    let mut folder = root.join("target").join(match toolchain {
        Toolchain::Current => "nodes",
        Toolchain::Distribution => "nodes-distribution",
    });
    let output = command(recipe, toolchain, &folder)
        .args(["--features", recipe.features])
        .args(programs.iter().flat_map(|program| ["--bin", program]))
        .current_dir(root)
        .output()
        .map_err(BuildError::Cargo)?;
    if !output.status.success() {
        let output = last_lines(&String::from_utf8_lossy(&output.stderr));
        return Err(BuildError::Failed {
            board: recipe.board.to_owned(),
            output,
        });
    }
    folder.extend(recipe.target);
    folder.push(recipe.profile);
    Ok(folder)
}

/// What this computer needs to build the programs and to run them.
fn needs(recipe: &Recipe) -> &'static [Part] {
    match recipe.target {
        Some(TARGET) if recipe.small_library => &[Part::Target, Part::Sources],
        Some(TARGET) if recipe.flashed_with_log.is_some() => &[Part::Target],
        Some(TARGET) => &[Part::Target, Part::Qemu],
        Some(_) => &[Part::Wasm],
        None => &[],
    }
}

/// Compiler target of the board's programs; `None` for the host.
fn target(board: Board) -> Option<&'static str> {
    match board {
        Board::Qemu | Board::Image => Some(TARGET),
        Board::Native => None,
        Board::Wasm => Some(WASM_TARGET),
    }
}

/// Log records of a board's program. Those of the bus stack and of the chip's library would take
/// 1.1 KB.
pub(super) const FLASHED_LOG: &str = "info,zencan_node=off,zencan_common=off,embassy_stm32=off";

/// Flags of the compiler for small images, as in a file of cargo. A panic is the instruction UDF.
/// Its text and its place, and the code that passes them on, would take 15 KB.
const SMALL_FLAGS: &str = "'-Cpanic=immediate-abort', '-Zunstable-options'";

fn command(recipe: &Recipe, toolchain: Toolchain, target_folder: &Path) -> Command {
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
    command
        .args(["--locked", "--profile", recipe.profile, "--target-dir"])
        .arg(target_folder);
    if recipe.target.is_none() {
        // Without link-time optimisation, the programs of the host are built sooner.
        command.args(["--config", "profile.firmware.lto=false"]);
    }
    if let Some(target) = recipe.target {
        command.args(["--target", target]);
        if let Some(log) = recipe.flashed_with_log {
            let prefix = packages().display().to_string();
            command.arg("--config");
            let small = if recipe.small_library {
                SMALL_FLAGS
            } else {
                ""
            };
            command.arg(format!(
                "target.{target}.rustflags = ['--remap-path-prefix={prefix}=', {small}]"
            ));
            // Equal values for all programs of a profile, so that cargo finds the macros and with
            // them everything else unchanged. The build script of `proc-macro2` reads the second.
            command.env("DEFMT_LOG", log).env("RUSTC_BOOTSTRAP", "1");
        }
        if recipe.small_library {
            command.arg("-Zbuild-std-features=optimize_for_size");
        }
    }
    if toolchain == Toolchain::Distribution || recipe.small_library {
        // A stable compiler builds the library only if RUSTC_BOOTSTRAP is set.
        command.arg("-Zbuild-std=core").env("RUSTC_BOOTSTRAP", "1");
    }
    if toolchain == Toolchain::Distribution {
        command.env("RUSTC", DISTRIBUTION_RUSTC);
        command.env(
            "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER",
            DISTRIBUTION_LINKER,
        );
    }
    command
}

/// Folder with the sources of the packages of crates.io. The debug information names them without
/// this folder.
fn packages() -> PathBuf {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
    // Cargo computes the number from the address of crates.io. The last part makes a final slash.
    home.unwrap_or_default()
        .join("registry/src/index.crates.io-1949cf8c6b5b557f")
        .join("")
}

/// Whether an environment variable can change the program that cargo builds. `cargo run` and
/// `cargo test` set many such variables for the programs they start; without them, equal sources
/// give equal nodes. Variables that only decide where crates are fetched from are not included.
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

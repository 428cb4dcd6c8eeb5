//! Calls cargo to build the programs of the boards. Whoever needs a program calls it with the same
//! flags and the same target folder, so that each program is built once.

use super::checkout::{NoCheckout, root};
use super::machine::{commit, library_folder};
use super::{Missing, PAGE_TARGET, Part, TARGET, ensure};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fmt, io};

/// Maximum number of lines of cargo's output in an error.
const SHOWN_LINES: usize = 30;

/// Reason why programs could not be built.
#[derive(Debug)]
pub enum BuildError {
    /// No checkout with the sources was found.
    NoCheckout(NoCheckout),
    /// A needed program is not installed.
    Missing(Missing),
    /// cargo does not start.
    Cargo(io::Error),
    /// cargo runs and fails.
    Failed {
        /// Name of the board that the programs were built for.
        board: String,
        /// The last lines of cargo's output.
        output: String,
    },
    /// cargo succeeds, but a program cannot be read.
    Unreadable {
        /// Path of the program.
        path: PathBuf,
        /// Error of the read.
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
                write!(f, "the nodes for {board} do not build:\n{output}")
            }
            Self::Unreadable { path, error } => {
                write!(f, "cannot read {}: {error}", path.display())
            }
        }
    }
}

impl std::error::Error for BuildError {}

/// What cargo builds.
pub struct Recipe<'a> {
    /// Name of the board, for errors.
    pub board: &'a str,
    /// Compiler target.
    pub target: &'static str,
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

/// The emulated board, with these features of the firmware.
pub const fn emulated(features: &str) -> Recipe<'_> {
    Recipe {
        board: "mps2",
        target: TARGET,
        features,
        profile: "firmware",
        flashed_with_log: None,
        small_library: false,
    }
}

/// Builds `programs` and returns the folder that contains them. Returns quickly if nothing has
/// changed. Installs what the build needs.
///
/// May be called from several threads and programs at once: cargo lets one of them build and the
/// others wait.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
pub fn folder_of(recipe: &Recipe, programs: &[&str]) -> Result<PathBuf, BuildError> {
    let root = root().map_err(BuildError::NoCheckout)?;
    ensure(needs(recipe)).map_err(BuildError::Missing)?;
    let mut folder = root.join("target/nodes");
    let output = command(recipe, root, &folder)
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
    folder.push(recipe.target);
    folder.push(recipe.profile);
    Ok(folder)
}

/// Builds the module of the page on the web and returns its path. Returns quickly if nothing has
/// changed. Installs what the build needs.
///
/// # Errors
/// [`BuildError`], with cargo's last lines if the build fails.
pub fn page_module() -> Result<PathBuf, BuildError> {
    let root = root().map_err(BuildError::NoCheckout)?;
    ensure(&[Part::PageTarget]).map_err(BuildError::Missing)?;
    let folder = root.join("target/page");
    let output = cargo()
        .args(["build", "--locked", "--package", "tautrack-host-tests"])
        .args(["--bin", "page", "--features", "page", "--profile", "page"])
        .args(["--target", PAGE_TARGET, "--target-dir"])
        .arg(&folder)
        .current_dir(root)
        .output()
        .map_err(BuildError::Cargo)?;
    if !output.status.success() {
        let output = last_lines(&String::from_utf8_lossy(&output.stderr));
        return Err(BuildError::Failed {
            board: "the page".to_owned(),
            output,
        });
    }
    Ok(folder.join(PAGE_TARGET).join("page/page.wasm"))
}

/// What this computer needs to build the programs and to run them.
fn needs(recipe: &Recipe) -> &'static [Part] {
    if recipe.small_library {
        &[Part::Target, Part::Sources]
    } else if recipe.flashed_with_log.is_some() {
        &[Part::Target]
    } else {
        &[Part::Target, Part::Qemu]
    }
}

/// Log records of a board's program. Those of the chip's library would take
/// 1.1 KB.
pub const FLASHED_LOG: &str = "info,embassy_stm32=off";

/// Flags of the compiler for small images. A panic is the instruction UDF. Its text and its place,
/// and the code that passes them on, would take 15 KB.
const SMALL_FLAGS: [&str; 2] = ["-Cpanic=immediate-abort", "-Zunstable-options"];

/// Cargo, without the variables that the cargo around this program has set.
fn cargo() -> Command {
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    for (name, _) in env::vars_os() {
        if changes_a_build(&name) {
            command.env_remove(name);
        }
    }
    command
}

fn command(recipe: &Recipe, root: &Path, target_folder: &Path) -> Command {
    let mut command = cargo();
    command.arg("build");
    command.args(["--package", "tautrack-firmware"]);
    command
        .args(["--locked", "--profile", recipe.profile, "--target-dir"])
        .arg(target_folder);
    command.args(["--target", recipe.target]);
    let flags = flags(recipe, root);
    command.arg("--config");
    command.arg(format!("target.{TARGET}.rustflags = {flags:?}"));
    if let Some(log) = recipe.flashed_with_log {
        // Equal values for all programs of a profile, so that cargo finds the macros and with them
        // everything else unchanged. The build script of `proc-macro2` reads the second.
        command.env("DEFMT_LOG", log).env("RUSTC_BOOTSTRAP", "1");
    }
    if recipe.small_library {
        command.args(["-Zbuild-std=core", "-Zbuild-std-features=optimize_for_size"]);
        // A stable compiler builds the library only if RUSTC_BOOTSTRAP is set.
        command.env("RUSTC_BOOTSTRAP", "1");
    }
    command
}

/// Flags of the compiler for a program of a board.
///
/// Texts of panics and debug information name source files. The flags replace what differs between
/// computers, so that the bytes of a program do not depend on any folder.
fn flags(recipe: &Recipe, root: &Path) -> Vec<String> {
    let mut flags: Vec<String> = folders(root)
        .iter()
        .map(|(folder, name)| format!("--remap-path-prefix={}={name}", folder.display()))
        .collect();
    if recipe.small_library {
        flags.extend(SMALL_FLAGS.map(str::to_owned));
    }
    flags
}

/// Folders with sources, and what programs name them. The compiler sees a folder that is reached
/// through a link by either path.
fn folders(root: &Path) -> Vec<(PathBuf, String)> {
    // The library that is compiled already names its sources by the compiler's commit. If they are
    // installed, the compiler would name their folder instead.
    let library = library_folder("rustc".as_ref());
    let commit = commit("rustc".as_ref()).map(|commit| format!("/rustc/{commit}"));
    let named = [
        // The build script writes code into the checkout.
        Some((root.to_owned(), String::new())),
        Some((root.join(packages()), String::new())),
        library.zip(commit),
    ];
    let named = named.into_iter().flatten();
    named
        .flat_map(|(folder, name)| {
            let real = folder.canonicalize().ok().filter(|real| *real != folder);
            let both = [Some(folder), real].into_iter().flatten();
            both.map(move |folder| (folder, name.clone()))
        })
        .collect()
}

/// Folder with the sources of the packages of crates.io. A mirror of it has another name, and then
/// programs name that folder.
fn packages() -> PathBuf {
    let home = env::var_os("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
    // Cargo computes the number from the address of crates.io.
    home.unwrap_or_default()
        .join("registry/src/index.crates.io-1949cf8c6b5b557f")
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

/// The end of cargo's output, for an error.
pub fn last_lines(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    lines[lines.len().saturating_sub(SHOWN_LINES)..].join("\n")
}

//! Reads from this computer the facts that a plan needs, and performs the plan's steps.

use super::checkout::root;
use super::plan::{Facts, Rights, Step};
use super::{BROWSER, PAGE_TARGET, PROBE_RS, QEMU, TARGET};
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::{env, fs};

/// Collects the facts about this computer and its environment variables.
pub fn facts() -> Facts {
    let rustc = env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    Facts {
        target_library: library(&rustc, TARGET),
        page_library: library(&rustc, PAGE_TARGET),
        library_sources: library_sources(&rustc),
        rustup: succeeds(&["rustup", "--version"]),
        qemu: succeeds(&[QEMU, "--version"]),
        browser: succeeds(&[BROWSER, "--version"]),
        probe_rs: succeeds(&[PROBE_RS, "--version"]),
        apt: succeeds(&["apt-get", "--version"]),
        rights: rights(),
        setup_allowed: env::var_os("TAUTRACK_NO_SETUP").is_none_or(|value| value != "1"),
    }
}

/// Runs the commands of `step`, with their output on standard error. Returns whether all of them
/// succeeded.
pub fn perform(step: Step) -> bool {
    step.commands().iter().all(|command| {
        let status = self::command(command[0])
            .args(&command[1..])
            .env("DEBIAN_FRONTEND", "noninteractive")
            .stdin(Stdio::null())
            // Standard output is reserved for the program that requested the set-up.
            .stdout(std::io::stderr())
            .status();
        status.is_ok_and(|status| status.success())
    })
}

/// Creates a command for `program`. It runs in the checkout's root, so that rust-toolchain.toml
/// selects the toolchain.
fn command(program: impl AsRef<OsStr>) -> Command {
    let mut command = Command::new(program);
    if let Ok(root) = root() {
        command.current_dir(root);
    }
    command
}

fn library(rustc: &OsStr, target: &str) -> bool {
    let Some(directory) = answer(rustc, &["--print", "target-libdir", "--target", target]) else {
        return false;
    };
    let Ok(mut entries) = fs::read_dir(directory) else {
        return false;
    };
    entries.any(|entry| {
        entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with("libcore-"))
    })
}

fn library_sources(rustc: &OsStr) -> bool {
    library_folder(rustc).is_some_and(|folder| folder.join("library/core").exists())
}

/// Folder for the sources of the compiler's library, whether they are installed or not.
pub fn library_folder(rustc: &OsStr) -> Option<PathBuf> {
    let sysroot = answer(rustc, &["--print", "sysroot"])?;
    Some(PathBuf::from(sysroot).join("lib/rustlib/src/rust"))
}

/// Commit that the compiler was built from.
pub fn commit(rustc: &OsStr) -> Option<String> {
    let version = answer(rustc, &["-vV"])?;
    let mut lines = version.lines();
    lines.find_map(|line| Some(line.strip_prefix("commit-hash: ")?.to_owned()))
}

fn rights() -> Option<Rights> {
    if answer("id".as_ref(), &["-u"]).is_some_and(|user| user == "0") {
        Some(Rights::Root)
    } else if succeeds(&["sudo", "-n", "true"]) {
        Some(Rights::Sudo)
    } else {
        None
    }
}

fn succeeds(command: &[&str]) -> bool {
    answer(command[0].as_ref(), &command[1..]).is_some()
}

/// Runs a program; returns its standard output without the line's end, or `None` if it fails.
fn answer(program: &OsStr, arguments: &[&str]) -> Option<String> {
    let output = command(program)
        .args(arguments)
        .stdin(Stdio::null())
        .stderr(Stdio::null())
        .output()
        .ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim_end().to_owned())
}

//! Builds node programs for this computer.

use super::program::identify;
use super::setup::build::last_lines;
use super::setup::checkout::root;
use super::{BuildError, Program};
use serde_json::Value;
use std::env;
use std::path::PathBuf;
use std::process::Command;

/// Builds `program` as `cargo test` builds it, in the same folder. So the tests build it once, and
/// its arithmetic is checked for overflows.
pub(super) fn native(program: &str) -> Result<Program, BuildError> {
    let output = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["build", "--locked", "--workspace", "--bin", program])
        .args(["--message-format", "json-render-diagnostics"])
        .current_dir(root().map_err(BuildError::NoCheckout)?)
        .output()
        .map_err(BuildError::Cargo)?;
    let messages = String::from_utf8_lossy(&output.stdout);
    let built = messages.lines().find_map(|message| {
        let message: Value = serde_json::from_str(message).ok()?;
        let named = message["target"]["name"] == program;
        let path = message["executable"].as_str().filter(|_| named)?;
        Some(PathBuf::from(path))
    });
    match built.filter(|_| output.status.success()) {
        Some(path) => identify(path),
        None => Err(BuildError::Failed {
            board: "native".to_owned(),
            output: last_lines(&String::from_utf8_lossy(&output.stderr)),
        }),
    }
}

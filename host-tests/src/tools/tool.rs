//! `cargo tool`: [`settings`](super::settings) of the nodes on a bus.

use super::settings;
use clap::{Parser, Subcommand};
use std::ffi::OsString;
use std::process::ExitCode;

/// Works on the nodes of a robot and on their settings.
#[derive(Parser)]
#[command(name = "cargo tool", version)]
struct Arguments {
    #[command(subcommand)]
    tool: Tool,
}

#[derive(Subcommand)]
enum Tool {
    /// Reads and writes the settings of the nodes
    #[command(subcommand)]
    Settings(settings::Command),
}

/// Runs the command. Its exit status is 0 if everything was done, else 1; 2 for bad arguments.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo tool"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    let Tool::Settings(command) = arguments.tool;
    match settings::run(command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

//! `cargo tool settings`: reads and writes the settings of the nodes on a bus.
//!
//! `arguments` is the command line. `adapter` is the connection to an SLCAN adapter, `client` the
//! CANopen client: SDO, heartbeats and LSS. `backup` is the file with the settings of all nodes.
//! `command` does the work.

mod adapter;
mod arguments;
mod backup;
mod client;
mod command;
mod error;

use arguments::Arguments;
pub(super) use backup::Backup;
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

/// Runs the command. Its exit status is 0 if everything was done, else 1; 2 for bad arguments.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo tool"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    match command::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

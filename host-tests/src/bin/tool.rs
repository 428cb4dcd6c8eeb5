//! `cargo tool`: works on the nodes of a bus.

use std::process::ExitCode;
use tautrack_host_tests::tools::settings;

fn main() -> ExitCode {
    settings::main(std::env::args_os().skip(1))
}

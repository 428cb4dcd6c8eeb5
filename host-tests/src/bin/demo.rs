//! `cargo demo`: builds the nodes, runs a scenario with them, and writes the results.

use std::process::ExitCode;
use tautrack_host_tests::tools::demo;

fn main() -> ExitCode {
    demo::main(std::env::args_os().skip(1))
}

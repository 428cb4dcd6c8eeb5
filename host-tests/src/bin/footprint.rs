//! `cargo footprint`: measures the memory that the motor board's programs need.

use std::process::ExitCode;
use tautrack_host_tests::tools::footprint;

fn main() -> ExitCode {
    footprint::main(std::env::args_os())
}

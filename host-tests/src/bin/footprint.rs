//! `cargo footprint`: measures the memory that the boards' programs need.

use std::process::ExitCode;
use tautrack_host_tests::tools::footprint;

fn main() -> ExitCode {
    footprint::main(std::env::args_os())
}

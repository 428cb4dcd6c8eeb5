//! `cargo evaluate`: computes model functions from JSON with the code that is flashed.

use std::process::ExitCode;
use tautrack_host_tests::tools::evaluate;

fn main() -> ExitCode {
    evaluate::main(std::env::args_os().skip(1))
}

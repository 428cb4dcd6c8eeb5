//! `cargo evaluate`: evaluates model functions with inputs from a JSON file, using the code that
//! the nodes run.

use std::process::ExitCode;
use tautrack_host_tests::tools::evaluate;

fn main() -> ExitCode {
    evaluate::main(std::env::args_os().skip(1))
}

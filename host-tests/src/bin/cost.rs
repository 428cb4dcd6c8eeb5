//! `cargo cost`: what the control code costs on the core.

use std::process::ExitCode;
use tautrack_host_tests::tools::cost;

fn main() -> ExitCode {
    cost::main(std::env::args_os())
}

//! `cargo cost`: counts the instructions of the control code on the target core.

use std::process::ExitCode;
use tautrack_host_tests::tools::cost;

fn main() -> ExitCode {
    cost::main(std::env::args_os())
}

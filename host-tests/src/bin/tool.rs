//! `cargo tool`: works on the nodes of a robot and on their settings.

use std::process::ExitCode;
use tautrack_host_tests::tools::tool;

fn main() -> ExitCode {
    tool::main(std::env::args_os().skip(1))
}

//! `cargo flash-node`: flashes a board.

use std::process::ExitCode;
use tautrack_host_tests::tools::flash_node;

fn main() -> ExitCode {
    flash_node::main(std::env::args_os())
}

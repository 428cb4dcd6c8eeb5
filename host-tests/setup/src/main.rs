//! Starts a command of `.cargo/config.toml` after its needs are met: `tautrack-setup NAME
//! ARGUMENTS`. Its exit status is the command's; 1 if a part is missing; 2 for an unknown command.

use std::env;
use std::process::ExitCode;
use tautrack_setup::commands::{COMMANDS, Command};
use tautrack_setup::ensure;

fn main() -> ExitCode {
    let mut words = env::args_os().skip(1);
    let Some(command) = words.next().and_then(|name| Command::find(&name)) else {
        let names = COMMANDS.map(|command| command.name).join(", ");
        eprintln!("error: the commands are {names}");
        return ExitCode::from(2);
    };
    let arguments: Vec<_> = words.collect();
    if let Err(missing) = ensure(&command.needs(&arguments)) {
        eprintln!("error: {missing}");
        return ExitCode::FAILURE;
    }
    let Err(error) = command.start(&arguments);
    eprintln!("error: cargo does not start: {error}");
    ExitCode::FAILURE
}

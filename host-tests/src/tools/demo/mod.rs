//! `cargo demo`: runs a scenario, or a whole suite, and reports the result as its exit status.
//!
//! `arguments` is the command line. `preparation` opens scenario, port and folder. `run` runs the
//! scenario and computes the exit status. `images` chooses the nodes that run a flash image.
//! `output` writes the files. `interrupt` handles Ctrl-C.

mod arguments;
mod images;
mod interrupt;
mod output;
mod preparation;
mod run;

use crate::programs::Board;
use crate::robots::Kind;
use crate::scenario::Sensors;
use crate::tools::page;
use crate::tools::suite::command;
use crate::tools::suite::operators::Plan;
use arguments::{Arguments, Suite, Switch};
use clap::Parser;
use preparation::Prepared;
use run::run;
use std::ffi::OsString;
use std::process::ExitCode;

/// Exit status for bad arguments and bad scenario files. Unmet expectations end with status 1.
const USAGE: u8 = 2;

/// Runs the command. Its exit status is 0 if the scenario's expectation is met; 1 if it is not, the
/// run fails or a result is not written; 2 for bad arguments and bad scenario files; 130 if the
/// user interrupted it.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo demo"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    let out = match preparation::folder(&arguments) {
        Ok(out) => out,
        Err(message) => return fail(&message, USAGE),
    };
    if let Some(folder) = &arguments.merge {
        return match command::merge(folder, arguments.json) {
            Ok(all_hold) => ExitCode::from(u8::from(!all_hold)),
            Err(message) => fail(&message, 1),
        };
    }
    if arguments.page || arguments.compare {
        let written = if arguments.page {
            page::write(&out)
        } else {
            match preparation::scenario(&arguments) {
                Ok(scenario) => page::compare::write(&scenario, &out),
                Err(message) => return fail(&message, USAGE),
            }
        };
        return match written {
            Ok(path) => {
                println!("{}: open it in a browser", path.display());
                ExitCode::SUCCESS
            }
            Err(message) => fail(&message, 1),
        };
    }
    if let Some(suite) = arguments.suite {
        let seed = arguments.seed.unwrap_or(1);
        let default_with_guard = arguments.robot == Kind::default() && arguments.guard.is_none();
        // Emulated nodes take too long for a suite.
        let board = Board::Host;
        let sensors = arguments.sensors(Sensors::default());
        let holds = match suite {
            Suite::Hazards if default_with_guard => {
                command::hazards(board, arguments.random, seed, sensors, &out)
            }
            Suite::Hazards => {
                return fail("--suite hazards takes neither --robot nor --guard", USAGE);
            }
            Suite::Clearance if arguments.grid => command::grid(board, &out),
            Suite::Clearance => {
                let runs = (arguments.runs, seed, arguments.faults);
                command::clearance(board, runs, arguments.shard, arguments.json, &out)
            }
            Suite::Operators => {
                let plan = Plan {
                    robot: arguments.robot,
                    guard: !matches!(arguments.guard, Some(Switch::Off)),
                    runs: arguments.runs,
                    seed,
                    sensors,
                };
                command::operators(board, &plan, &out)
            }
        };
        return match holds {
            Ok(all_hold) => ExitCode::from(u8::from(!all_hold)),
            Err(message) => fail(&message, 1),
        };
    }
    let prepared = match Prepared::new(&arguments, &out) {
        Ok(prepared) => prepared,
        Err(message) => return fail(&message, USAGE),
    };
    match run(&arguments, prepared) {
        Ok(status) => ExitCode::from(status),
        Err(message) => fail(&message, 1),
    }
}

fn fail(message: &str, status: u8) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(status)
}

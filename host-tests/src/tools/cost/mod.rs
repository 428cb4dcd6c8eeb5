//! `cargo cost`: counts the instructions of the control code on an emulated Cortex-M4F, and prints
//! them beside their ceilings.
//!
//! [`counts`] runs the firmware's program `cost` and reads its counts. [`ceilings`] reads
//! the files `cost.toml`.

pub mod ceilings;
pub mod counts;

use ceilings::Ceilings;
use clap::Parser;
use std::ffi::OsString;
use std::process::ExitCode;

/// Counts the instructions of the control code on the emulated Cortex-M4F, and prints them beside
/// their ceilings. Fails above a ceiling.
#[derive(Parser)]
#[command(name = "cargo cost")]
struct Arguments {}

/// Runs the command. The first of `arguments` is the program's name.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    Arguments::parse_from(arguments);
    match command() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cargo cost: {error}");
            ExitCode::FAILURE
        }
    }
}

fn command() -> Result<(), String> {
    let (ceilings, counts) = (Ceilings::read()?, counts::count()?);
    let line = |name, [least, mean, most, ceiling]: [String; 4]| {
        println!("{name:<32} {least:>7} {mean:>7} {most:>7} {ceiling:>7}");
    };
    let heading = ["minimum", "mean", "maximum", "ceiling"];
    line("instructions", heading.map(str::to_owned));
    for count in &counts {
        let numbers = [count.minimum, count.mean, count.maximum].map(|it| it.to_string());
        let [least, mean, most] = numbers;
        let ceiling = ceilings.instructions.get(&count.name);
        let ceiling = ceiling.map_or_else(String::new, u32::to_string);
        line(&count.name, [least, mean, most, ceiling]);
    }
    let excesses = ceilings.excesses(&counts);
    excesses.is_empty().then_some(()).ok_or(excesses.join("\n"))
}

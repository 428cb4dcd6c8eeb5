//! `cargo demo`: the command line, the run, the three files and the verdict.

use crate::machines::Kind;
use crate::nodes::{self, Board};
use crate::run::{self, Options, Outcome, Progress};
use crate::scenario::Scenario;
use crate::setup;
use crate::slcan::SlcanPort;
use crate::suite::judge::Row;
use crate::suite::{Findings, suite, table};
use crate::summary::Summary;
use crate::{log, report};
use clap::{Parser, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Exit status of bad arguments and bad scenario files, as of unmet expectations the failure status 1.
const USAGE: u8 = 2;

/// Runs the firmware nodes of a robot against simulated physics and reports what came out.
#[derive(Parser)]
#[command(name = "cargo demo", version)]
struct Arguments {
    /// Scenario file; the robot's own when absent, for B2P2 the staircase of its paper
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// The robot whose scenario is run when none is named
    #[arg(long, value_enum, default_value_t, conflicts_with = "scenario")]
    robot: Kind,
    /// Runs a whole suite with native nodes instead of one scenario, and writes its table
    #[arg(long, value_enum, conflicts_with_all = ["scenario", "guard", "speed", "slcan"])]
    suite: Option<Suite>,
    /// Of the suite: runs of each kind, hazardous and legitimate, to draw at random beside the named ones
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 200)]
    random: u64,
    /// What the nodes run on: the Cortex-M4F that QEMU emulates, or this computer
    #[arg(long, value_enum, default_value_t = Nodes::Qemu)]
    nodes: Nodes,
    /// Overrides the scenario: whether the guard's filter limits the operator
    #[arg(long, value_enum)]
    guard: Option<Switch>,
    /// Folder for summary.json, run.mcap and report.html
    #[arg(long, value_name = "DIR", default_value = "target/demo")]
    out: PathBuf,
    /// Overrides the scenario: seed of all noise; of the suite: seed of the drawn runs, 1 when absent
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// At most so many virtual seconds per second
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    speed: Option<f64>,
    /// Lets a CAN client (python-can, slcan) take part through this TCP address
    #[arg(long, value_name = "ADDR:PORT")]
    slcan: Option<String>,
}

#[derive(Clone, Copy, ValueEnum)]
enum Nodes {
    Qemu,
    Native,
}

#[derive(Clone, Copy, ValueEnum)]
enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, ValueEnum)]
enum Suite {
    /// What the guard saves, and what it must not hinder
    Hazards,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("it must be a number above 0".into()),
    }
}

/// Runs the command; its exit status is 0 if the scenario's expectation holds, 1 if not or if the run broke, 2 for bad
/// arguments and bad scenario files.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo demo"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    if let Some(Suite::Hazards) = arguments.suite {
        return match hazards(&arguments) {
            Ok(all_hold) => ExitCode::from(u8::from(!all_hold)),
            Err(message) => fail(&message, 1),
        };
    }
    let scenario = match scenario(&arguments) {
        Ok(scenario) => scenario,
        Err(message) => return fail(&message, USAGE),
    };
    match run(&arguments, &scenario) {
        Ok(summary) => {
            println!("\n{summary}");
            println!(
                "\n{} has summary.json, run.mcap and report.html",
                arguments.out.display()
            );
            ExitCode::from(u8::from(!summary.expectation_met))
        }
        Err(message) => fail(&message, 1),
    }
}

fn fail(message: &str, status: u8) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(status)
}

fn scenario(arguments: &Arguments) -> Result<Scenario, String> {
    let shipped = || {
        setup::machine::root()
            .join("host-tests/scenarios")
            .join(arguments.robot.scenario_file())
    };
    let path = arguments.scenario.clone().unwrap_or_else(shipped);
    let scenario = Scenario::load(&path).map_err(|error| error.to_string())?;
    let mut description = scenario.description();
    if let Some(guard) = arguments.guard {
        description.guard = matches!(guard, Switch::On);
    }
    if !description.guard {
        // What the guard does is not asked of a guard that is off.
        description.expect.guard_intervenes = None;
    }
    description.seed = arguments.seed.unwrap_or(description.seed);
    description
        .check()
        .map_err(|problem| format!("{}: {problem}", path.display()))
}

fn run(arguments: &Arguments, scenario: &Scenario) -> Result<Summary, String> {
    let board = match arguments.nodes {
        Nodes::Qemu => Board::Qemu,
        Nodes::Native => Board::Native,
    };
    println!("building the nodes (a minute or two the first time) ...");
    let programs = nodes::build(board, scenario.kind()).map_err(|error| error.to_string())?;
    let slcan = match &arguments.slcan {
        Some(address) => {
            let port = SlcanPort::bind(address)
                .map_err(|error| format!("cannot listen on {address}: {error}"))?;
            println!("a CAN client can join at {address}");
            Some(port)
        }
        None => None,
    };
    println!("{}: {}", scenario.name, scenario.about);
    let bar = bar(scenario.duration_s);
    let mut show = |progress: &Progress| {
        bar.set_position((progress.time_s * 1e3) as u64);
        let Progress {
            time_s,
            speed,
            state,
        } = progress;
        bar.set_message(format!("{time_s:6.2} s  {speed:6.3} m/s  {state}"));
    };
    let options = Options {
        speed: arguments.speed,
        slcan,
        ..Options::default()
    };
    let outcome =
        run::run(scenario, &programs, options, &mut show).map_err(|error| error.to_string())?;
    bar.finish_and_clear();
    let summary = Summary::new(scenario, &outcome.facts, &outcome.samples);
    write(&arguments.out, scenario, &summary, &outcome)
        .map_err(|error| format!("cannot write to {}: {error}", arguments.out.display()))?;
    Ok(summary)
}

/// Runs the hazard suite; whether every row holds.
fn hazards(arguments: &Arguments) -> Result<bool, String> {
    println!("building the nodes (a minute or two the first time) ...");
    let programs = nodes::build(Board::Native, Kind::B2p2).map_err(|error| error.to_string())?;
    let scenarios = setup::machine::root().join("host-tests/scenarios");
    let done = |row: &Row| {
        let simulated_s = row.simulated_s;
        let verdict = table::verdict(row);
        println!(
            "{:28} {simulated_s:6.1} s simulated  {verdict}",
            row.scenario.name
        );
    };
    let seed = arguments.seed.unwrap_or(1);
    let began = Instant::now();
    let findings = suite(&scenarios, arguments.random, seed, &programs, &done)
        .map_err(|error| error.to_string())?;
    let table = table::table(&findings);
    let simulated_s: f64 = findings.rows().map(|row| row.simulated_s).sum();
    println!(
        "\n{table}\n{simulated_s:.0} s simulated in {:.0} s",
        began.elapsed().as_secs_f64()
    );
    write_findings(&arguments.out, &table, &findings)
        .map_err(|error| format!("cannot write to {}: {error}", arguments.out.display()))?;
    Ok(findings.all_hold())
}

/// The tables, and each drawn scenario that does not hold as a file for `--scenario`.
fn write_findings(
    folder: &Path,
    table: &str,
    findings: &Findings,
) -> Result<(), Box<dyn std::error::Error>> {
    fs::create_dir_all(folder)?;
    fs::write(folder.join("hazards.md"), table)?;
    let drawn = findings.drawn.iter().flat_map(|drawn| &drawn.rows);
    for row in drawn.filter(|row| !row.unmet.is_empty()) {
        let file = folder.join(&row.scenario.name).with_extension("toml");
        fs::write(file, toml::to_string(&row.scenario)?)?;
    }
    Ok(())
}

fn bar(duration_s: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new((duration_s * 1e3) as u64).with_style(style)
}

fn write(
    folder: &Path,
    scenario: &Scenario,
    summary: &Summary,
    outcome: &Outcome,
) -> Result<(), Box<dyn std::error::Error>> {
    fs::create_dir_all(folder)?;
    serde_json::to_writer_pretty(
        BufWriter::new(File::create(folder.join("summary.json"))?),
        summary,
    )?;
    let recording = log::Recording {
        scenario,
        nodes: &summary.nodes,
        samples: &outcome.samples,
        frames: &outcome.frames,
    };
    log::write(
        &recording,
        BufWriter::new(File::create(folder.join("run.mcap"))?),
    )?;
    fs::write(
        folder.join("report.html"),
        report::html(scenario, summary, &outcome.samples),
    )?;
    if !outcome.log.is_empty() {
        fs::write(folder.join("nodes.log"), outcome.log.join("\n"))?;
    }
    Ok(())
}

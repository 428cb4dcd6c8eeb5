//! `cargo demo`: the command line, the run, the three files and the verdict.

mod interrupt;
mod output;

use crate::machines::Kind;
use crate::nodes::{self, Board};
use crate::run::{self, Options, Progress, RunError};
use crate::scenario::Scenario;
use crate::setup::checkout;
use crate::slcan::SlcanPort;
use crate::suite::command;
use crate::suite::operators::Plan;
use crate::summary::Summary;
use clap::{Parser, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use output::{Output, Unwritten};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Exit status of bad arguments and bad scenario files, as of unmet expectations the failure status 1.
const USAGE: u8 = 2;

/// Runs the firmware nodes of a robot against simulated physics and reports what came out.
#[derive(Parser)]
#[command(name = "cargo demo", version)]
struct Arguments {
    /// Scenario file; the robot's own when absent, for B2P2 the staircase of its paper
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// The robot whose scenario is run when none is named, or whose operators' suite is
    #[arg(long, value_enum, default_value_t, conflicts_with = "scenario")]
    robot: Kind,
    /// Runs a whole suite with native nodes instead of one scenario, and writes its table
    #[arg(long, value_enum, conflicts_with_all = ["scenario", "speed", "slcan"])]
    suite: Option<Suite>,
    /// Of the hazard suite: runs of each kind, hazardous and legitimate, to draw at random beside the named ones
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 200)]
    random: u64,
    /// Of the operators' suite: runs
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 100)]
    runs: u64,
    /// What the nodes run on: the Cortex-M4F that QEMU emulates, or this computer
    #[arg(long, value_enum, default_value_t = Nodes::Qemu)]
    nodes: Nodes,
    /// Overrides the scenario: whether the guard's filter limits the operator
    #[arg(long, value_enum)]
    guard: Option<Switch>,
    /// Folder for summary.json, run.mcap, report.html and nodes.log; target/demo of the checkout when
    /// absent
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overrides the scenario: seed of all noise; of the suite: seed of the drawn runs, 1 when absent
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Maximum of virtual seconds per second; with --slcan 1 when absent
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    speed: Option<f64>,
    /// Lets CAN clients (python-can, slcan) take part through this TCP address; waits for the first
    /// one
    #[arg(long, value_name = "ADDR:PORT")]
    slcan: Option<String>,
    /// Maximum time to wait for the first client, 0 to begin without one; no limit when absent
    #[arg(long, value_name = "SECONDS", requires = "slcan", value_parser = seconds)]
    slcan_wait: Option<Duration>,
    /// Time that a node may take for an answer before the run ends
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    node_timeout: Duration,
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
    /// What the guard saves, and what it must not hinder (B2P2)
    Hazards,
    /// Operators who command at random, whom the guard must keep from toppling the robot
    Operators,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("it must be a number above 0".into()),
    }
}

fn seconds(text: &str) -> Result<Duration, String> {
    let value = text.parse().ok();
    let time = value.and_then(|value| Duration::try_from_secs_f64(value).ok());
    time.ok_or_else(|| "it must be a number of seconds, 0 or more".into())
}

/// Runs the command. Its exit status is 0 if the scenario's expectation holds, 1 if not or if the
/// run broke or a result is not written, 2 for bad arguments and bad scenario files, 130 if the
/// user interrupted it.
pub fn main(arguments: impl Iterator<Item = OsString>) -> ExitCode {
    let name = std::iter::once(OsString::from("cargo demo"));
    let arguments =
        Arguments::try_parse_from(name.chain(arguments)).unwrap_or_else(|error| error.exit());
    let out = match folder(&arguments) {
        Ok(out) => out,
        Err(message) => return fail(&message, USAGE),
    };
    if let Some(suite) = arguments.suite {
        let seed = arguments.seed.unwrap_or(1);
        let b2p2_with_guard = arguments.robot == Kind::B2p2 && arguments.guard.is_none();
        let holds = match suite {
            Suite::Hazards if b2p2_with_guard => command::hazards(arguments.random, seed, &out),
            Suite::Hazards => {
                return fail("--suite hazards takes neither --robot nor --guard", USAGE);
            }
            Suite::Operators => {
                let plan = Plan {
                    robot: arguments.robot,
                    guard: !matches!(arguments.guard, Some(Switch::Off)),
                    runs: arguments.runs,
                    seed,
                };
                command::operators(&plan, &out)
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

fn root() -> Result<&'static Path, String> {
    checkout::root().map_err(|error| error.to_string())
}

/// The folder of the results, as short as the working directory allows.
fn folder(arguments: &Arguments) -> Result<PathBuf, String> {
    if let Some(out) = &arguments.out {
        return Ok(out.clone());
    }
    let folder = root()?.join("target/demo");
    let here = std::env::current_dir().unwrap_or_default();
    let short = folder.strip_prefix(here).map(Path::to_owned);
    Ok(short.unwrap_or(folder))
}

/// The scenario's file. A path that the docs name, which begins at the checkout's root, is also found
/// from another directory.
fn scenario_file(arguments: &Arguments) -> Result<PathBuf, String> {
    let Some(path) = &arguments.scenario else {
        let shipped = root()?.join("host-tests/scenarios");
        return Ok(shipped.join(arguments.robot.scenario_file()));
    };
    if !path.exists()
        && let Ok(from_root) = root().map(|root| root.join(path))
        && from_root.exists()
    {
        return Ok(from_root);
    }
    Ok(path.clone())
}

fn scenario(arguments: &Arguments) -> Result<Scenario, String> {
    let path = scenario_file(arguments)?;
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

/// What is made before anything is built, so that nothing runs in vain.
struct Prepared {
    scenario: Scenario,
    slcan: Option<SlcanPort>,
    output: Output,
}

impl Prepared {
    fn new(arguments: &Arguments, out: &Path) -> Result<Self, String> {
        let scenario = scenario(arguments)?;
        if scenario.operator.client && arguments.slcan.is_none() {
            let why = "a CAN client is the operator; add --slcan 127.0.0.1:3333 (docs/bus.md)";
            return Err(format!("{}: {why}", scenario.name));
        }
        let slcan = arguments.slcan.as_ref().map(|address| {
            SlcanPort::bind(address)
                .map_err(|error| format!("cannot listen on --slcan {address} (ADDR:PORT): {error}"))
        });
        Ok(Self {
            scenario,
            slcan: slcan.transpose()?,
            output: Output::open(out)
                .map_err(|error| format!("cannot write to --out {}: {error}", out.display()))?,
        })
    }
}

/// Runs the scenario and writes what it gives; the exit status.
fn run(arguments: &Arguments, prepared: Prepared) -> Result<u8, String> {
    let Prepared {
        scenario,
        slcan,
        mut output,
    } = prepared;
    let board = match arguments.nodes {
        Nodes::Qemu => Board::Qemu,
        Nodes::Native => Board::Native,
    };
    println!("building the nodes (a minute or two the first time) ...");
    let programs = nodes::build(board, scenario.kind()).map_err(|error| error.to_string())?;
    let interrupt = interrupt::flag().map_err(|error| format!("cannot catch Ctrl-C: {error}"))?;
    let folder = output.folder().to_owned();
    output
        .begin()
        .map_err(|error| format!("cannot write to --out {}: {error}", folder.display()))?;
    println!("{}: {}", scenario.name, scenario.about);
    if let Some(port) = &slcan {
        announce(port, arguments.slcan_wait);
    }
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
        slcan_wait: arguments.slcan_wait,
        node_timeout: Some(arguments.node_timeout),
        interrupt: Some(interrupt),
        ..Options::default()
    };
    let (outcome, broken) =
        run::record(&scenario, &programs, options, &mut show).map_err(|error| error.to_string())?;
    bar.finish_and_clear();
    let mut summary = Summary::new(&scenario, &outcome.facts, &outcome.samples);
    summary.clients = outcome.clients;
    if let Some(why) = &broken {
        summary.end_early(&why.to_string());
    }
    let unwritten = output.write(&scenario, &summary, &outcome);
    if summary.steps > 0 {
        println!("\n{summary}");
    }
    Ok(report(&folder, &summary, broken.as_ref(), &unwritten))
}

fn announce(port: &SlcanPort, wait: Option<Duration>) {
    let address = port.address().map(|address| address.to_string());
    let address = address.unwrap_or_else(|_| "the port".into());
    let then = match wait {
        None => "the run waits for the first one".to_owned(),
        Some(Duration::ZERO) => "the run does not wait".to_owned(),
        Some(wait) => format!("the run waits {} s for the first one", wait.as_secs_f64()),
    };
    println!("CAN clients can join at {address}; {then}");
}

/// Says where the results are and what is missing; the exit status.
fn report(
    folder: &Path,
    summary: &Summary,
    broken: Option<&RunError>,
    unwritten: &[Unwritten],
) -> u8 {
    let folder = folder.display();
    if unwritten.is_empty() {
        println!("\n{folder} has summary.json, run.mcap, report.html and nodes.log");
    }
    if let Some(why) = broken {
        let end = summary.simulated_s;
        eprintln!("error: {why}; the results end at {end:.2} s");
    }
    for Unwritten { file, error } in unwritten {
        eprintln!("error: {folder}/{file} is not complete: {error}");
    }
    match broken {
        Some(RunError::Interrupted) => interrupt::STATUS,
        Some(_) => 1,
        None => u8::from(!summary.expectation_met || !unwritten.is_empty()),
    }
}

fn bar(duration_s: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new((duration_s * 1e3) as u64).with_style(style)
}

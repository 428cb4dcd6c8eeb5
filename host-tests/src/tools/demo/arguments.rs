//! The command line of `cargo demo`: options, their help texts and the checks of their values.

use crate::programs::Board;
use crate::robots::Kind;
use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Runs the firmware of a robot's nodes with simulated physics and writes the results.
#[derive(Parser)]
#[command(name = "cargo demo", version)]
pub(super) struct Arguments {
    /// Scenario file to run; by default that of the robot
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// Robot whose default scenario, or whose operators' suite, is run
    #[arg(long, value_enum, default_value_t, conflicts_with = "scenario")]
    pub robot: Kind,
    /// Writes the page on the web, in which one drives the robots, instead of running a scenario:
    /// page.html in the folder of --out
    #[arg(long, conflicts_with_all = ["scenario", "suite", "speed", "slcan", "image", "flash"])]
    pub page: bool,
    /// Runs the scenario with the guard's filter on and off, and writes a page that shows both:
    /// compare.html in the folder of --out
    #[arg(long, conflicts_with_all = ["page", "suite", "speed", "slcan", "image", "flash", "guard"])]
    pub compare: bool,
    /// Runs a suite of scenarios instead of one, with the nodes of --nodes host, and writes its
    /// table
    #[arg(long, value_enum, conflicts_with_all = ["scenario", "speed", "slcan"])]
    pub suite: Option<Suite>,
    /// Hazard suite: number of hazards, and number of legitimate runs, to draw at random in
    /// addition to the named ones
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 200)]
    pub random: u64,
    /// Operators' suite: number of runs
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 100)]
    pub runs: u64,
    /// Processor of the nodes: a Cortex-M4F emulated by QEMU (qemu), or this computer (host), which
    /// is the fastest
    #[arg(long, value_enum, default_value_t = Nodes::Qemu)]
    pub nodes: Nodes,
    /// Nodes, separated by commas, that run the flash image of their board on a model of its chip,
    /// instead of --nodes; `all` means every node that has one. Slower than real time; only with
    /// `cargo demo-image`
    #[arg(
        long,
        value_name = "NODES",
        value_delimiter = ',',
        conflicts_with_all = ["suite", "flash"]
    )]
    pub image: Vec<String>,
    /// Switches the guard's filter on or off, whatever the scenario says
    #[arg(long, value_enum)]
    pub guard: Option<Switch>,
    /// Rate of inertial unit and inclinometer in Hz, whatever the scenario says
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(i32).range(20..=1_000))]
    pub sensor_hz: Option<i32>,
    /// Folder for the results: summary.json, run.mcap, report.html and nodes.log; by default
    /// target/demo of the checkout
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Seed of all noise, instead of the scenario's; for a suite the seed of the runs drawn at
    /// random, by default 1
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Maximum speed of the run, in virtual seconds per second; by default 1 with --slcan, else no
    /// limit
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub speed: Option<f64>,
    /// Folder with the flash of each node, created if missing: settings that a client saves are
    /// there in the next run. The scenario's settings fill blank flash alone. By default every run
    /// begins with blank flash
    #[arg(long, value_name = "DIR", conflicts_with = "suite")]
    pub flash: Option<PathBuf>,
    /// Gives blank nodes no settings: they are mute until a client gives them a node id by LSS
    #[arg(long, requires = "flash")]
    pub blank: bool,
    /// TCP address at which CAN clients (python-can with SLCAN) can join; the run waits for the
    /// first client
    #[arg(long, value_name = "ADDR:PORT")]
    pub slcan: Option<String>,
    /// Maximum time to wait for the first client; 0 does not wait; by default no limit
    #[arg(long, value_name = "SECONDS", requires = "slcan", value_parser = seconds)]
    pub slcan_wait: Option<Duration>,
    /// Maximum time that a node may take to answer; then the run ends
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    pub node_timeout: Duration,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Nodes {
    Qemu,
    Host,
}

impl Nodes {
    pub fn board(self) -> Board {
        match self {
            Self::Qemu => Board::Qemu,
            Self::Host => Board::Host,
        }
    }
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Suite {
    /// Runs that topple the default robot without the guard, and legitimate runs that the guard
    /// must not hinder
    Hazards,
    /// Runs with operators who command at random; the guard must keep the robot from toppling
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

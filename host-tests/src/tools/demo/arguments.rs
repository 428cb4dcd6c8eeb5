//! The command line of `cargo demo`: options, their help texts and the checks of their values.

use crate::programs::Board;
use crate::robots::Kind;
use crate::scenario::{SensorErrors, Sensors};
use crate::tools::suite::clearance::Shard;
use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Runs the firmware of a robot's nodes with simulated physics and writes the results.
#[derive(Parser)]
#[allow(clippy::struct_excessive_bools)] // one per option without a value
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
    /// Operators' and clearance suite: number of runs
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 100)]
    pub runs: u64,
    /// Clearance suite: makes only part I of N of the runs
    #[arg(long, value_name = "I/N", requires = "suite", default_value_t = Shard::WHOLE)]
    pub shard: Shard,
    /// Clearance suite: a node, the bus or the inclinometer fails in the middle of each run
    #[arg(long, requires = "suite")]
    pub faults: bool,
    /// Clearance suite: runs stairs over riser and run instead, and writes clearance.svg
    #[arg(long, requires = "suite")]
    pub grid: bool,
    /// Clearance suite: prints one line of JSON for each run instead of the table
    #[arg(long)]
    pub json: bool,
    /// Clearance suite: prints the table of the results in this folder, those of all shards, and
    /// runs nothing
    #[arg(long, value_name = "DIR", conflicts_with_all = ["scenario", "suite", "slcan"])]
    pub merge: Option<PathBuf>,
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
    /// Constant error of every axis of the gyroscope in degrees/s, whatever the scenario says
    #[arg(long, value_name = "DEG_S", allow_negative_numbers = true)]
    pub gyroscope_bias: Option<f64>,
    /// Constant error of every axis of the accelerometer in g, whatever the scenario says
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    pub accelerometer_bias: Option<f64>,
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

impl Arguments {
    /// Sensors with the rates and errors of the options, otherwise like `sensors`.
    pub fn sensors(&self, sensors: Sensors) -> Sensors {
        let errors = SensorErrors {
            rate_at_rest_deg_s: [self.gyroscope_bias.unwrap_or(0.0); 3],
            accelerometer_g: [self.accelerometer_bias.unwrap_or(0.0); 3],
            ..SensorErrors::default()
        };
        Sensors {
            errors: sensors.errors.or(errors),
            ..self.sensor_hz.map_or(sensors, Sensors::at)
        }
    }
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
    /// Obstacles that B2P2 clears by itself
    Clearance,
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

//! The command line.

use crate::robots::Kind;
use clap::{Parser, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

/// Runs the firmware nodes of a robot against simulated physics and reports what came out.
#[derive(Parser)]
#[command(name = "cargo demo", version)]
pub(super) struct Arguments {
    /// Scenario file; the robot's own when absent, for B2P2 the staircase of its paper
    #[arg(long, value_name = "FILE")]
    pub scenario: Option<PathBuf>,
    /// The robot whose scenario is run when none is named, or whose operators' suite is
    #[arg(long, value_enum, default_value = "b2p2", conflicts_with = "scenario")]
    pub robot: Kind,
    /// Runs a whole suite with native nodes instead of one scenario, and writes its table
    #[arg(long, value_enum, conflicts_with_all = ["scenario", "speed", "slcan"])]
    pub suite: Option<Suite>,
    /// Of the hazard suite: runs of each kind, hazardous and legitimate, to draw at random beside
    /// the named ones
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 200)]
    pub random: u64,
    /// Of the operators' suite: runs
    #[arg(long, value_name = "N", requires = "suite", default_value_t = 100)]
    pub runs: u64,
    /// What the nodes run on: the Cortex-M4F that QEMU emulates, or this computer
    #[arg(long, value_enum, default_value_t = Nodes::Qemu)]
    pub nodes: Nodes,
    /// Overrides the scenario: whether the guard's filter limits the operator
    #[arg(long, value_enum)]
    pub guard: Option<Switch>,
    /// Folder for summary.json, run.mcap, report.html and nodes.log; target/demo of the checkout
    /// when absent
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overrides the scenario: seed of all noise; of the suite: seed of the drawn runs, 1 when
    /// absent
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Maximum of virtual seconds per second; with --slcan 1 when absent
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub speed: Option<f64>,
    /// Lets CAN clients (python-can, slcan) take part through this TCP address; waits for the first
    /// one
    #[arg(long, value_name = "ADDR:PORT")]
    pub slcan: Option<String>,
    /// Maximum time to wait for the first client, 0 to begin without one; no limit when absent
    #[arg(long, value_name = "SECONDS", requires = "slcan", value_parser = seconds)]
    pub slcan_wait: Option<Duration>,
    /// Time that a node may take for an answer before the run ends
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = seconds)]
    pub node_timeout: Duration,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Nodes {
    Qemu,
    Native,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Switch {
    On,
    Off,
}

#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Suite {
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

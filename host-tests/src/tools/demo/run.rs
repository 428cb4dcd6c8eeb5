//! Runs the scenario with its nodes, writes the results and computes the exit status.

use super::arguments::Arguments;
use super::interrupt;
use super::output::Unwritten;
use super::preparation::Prepared;
use crate::results::summary::Summary;
use crate::simulator::run;
use crate::simulator::run::{Options, Progress, RunError};
use crate::simulator::slcan::SlcanPort;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::time::Duration;

/// Runs the scenario and writes its results. Returns the exit status.
pub(super) fn run(arguments: &Arguments, prepared: Prepared) -> Result<u8, String> {
    let Prepared {
        scenario,
        slcan,
        mut output,
    } = prepared;
    let board = arguments.nodes.board();
    println!("building the nodes (a minute or two the first time) ...");
    let programs = scenario
        .kind()
        .programs(board)
        .map_err(|error| error.to_string())?;
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

/// Prints where the results are and which are missing. Returns the exit status.
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

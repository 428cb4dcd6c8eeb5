//! Runs the scenario with its nodes, writes the results and computes the exit status.

use super::arguments::Arguments;
use super::output::Results;
use super::preparation::Prepared;
use super::{images, interrupt};
use crate::programs::Board;
use crate::results::summary::Summary;
use crate::simulator::record::{BusFrame, Sample};
use crate::simulator::run::{self, Options, RunError, Sink, Unwritten};
use crate::simulator::slcan::SlcanPort;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, Write};
use std::path::Path;
use std::time::Duration;

/// Runs the scenario and writes its results. Returns the exit status.
pub(super) fn run(arguments: &Arguments, prepared: Prepared) -> Result<u8, String> {
    let Prepared {
        scenario,
        slcan,
        output,
        flash,
        images,
    } = prepared;
    let board = arguments.nodes.board();
    if board != Board::Host || !images.is_empty() {
        say("building the nodes (a minute or two the first time) ...")?;
    }
    let programs = scenario
        .kind()
        .programs(board)
        .map_err(|error| error.to_string())?;
    let exchanged = images::programs(&images, scenario.kind().facts().guard_program)?;
    let interrupt = interrupt::flag().map_err(|error| format!("cannot catch Ctrl-C: {error}"))?;
    let folder = output.folder().to_owned();
    say(&format!("{}: {}", scenario.name, scenario.about))?;
    if let Some(port) = &slcan {
        announce(port, arguments.slcan_wait)?;
    }
    let results = output
        .begin(&scenario)
        .map_err(|error| format!("cannot write to --out {}: {error}", folder.display()))?;
    let mut watched = Watched {
        results,
        bar: bar(scenario.duration_s),
    };
    let options = Options {
        exchanged,
        speed: arguments.speed,
        slcan,
        slcan_wait: arguments.slcan_wait,
        node_timeout: Some(arguments.node_timeout),
        flash,
        blank: arguments.blank,
        interrupt: Some(interrupt),
        ..Options::default()
    };
    let ending = run::record(&scenario, &programs, options, &mut watched)
        .map_err(|error| error.to_string())?;
    watched.bar.finish_and_clear();
    let (summary, unwritten) = watched.results.finish(&scenario, &ending);
    let said = if summary.steps > 0 {
        say(&format!("\n{summary}"))
    } else {
        Ok(())
    };
    let status = report(&folder, &summary, ending.error.as_ref(), &unwritten)?;
    said.map(|()| status)
}

/// The results, with a bar that shows the progress of the run.
struct Watched {
    results: Results,
    bar: ProgressBar,
}

impl Sink for Watched {
    fn sample(&mut self, sample: Sample) -> Result<(), Unwritten> {
        let (time_s, received) = (sample.time_s, &sample.received);
        let (speed, state) = (received.passed_speed, &received.guard_state);
        self.bar.set_position((time_s * 1e3) as u64);
        self.bar
            .set_message(format!("{time_s:6.2} s  {speed:6.3} m/s  {state}"));
        self.results.sample(sample)
    }

    fn frame(&mut self, frame: &BusFrame) -> Result<(), Unwritten> {
        self.results.frame(frame)
    }

    fn log(&mut self, line: &str) -> Result<(), Unwritten> {
        self.results.log(line)
    }
}

/// Prints a line. Standard output may be a pipe that its reader has closed.
fn say(line: &str) -> Result<(), String> {
    writeln!(io::stdout(), "{line}")
        .map_err(|error| format!("cannot write to the standard output: {error}"))
}

fn announce(port: &SlcanPort, wait: Option<Duration>) -> Result<(), String> {
    let address = port.address().map(|address| address.to_string());
    let address = address.unwrap_or_else(|_| "the port".into());
    let then = match wait {
        None => "the run waits for the first one".to_owned(),
        Some(Duration::ZERO) => "the run does not wait".to_owned(),
        Some(wait) => format!("the run waits {} s for the first one", wait.as_secs_f64()),
    };
    say(&format!("CAN clients can join at {address}; {then}"))
}

/// Prints where the results are and which are missing. Returns the exit status.
fn report(
    folder: &Path,
    summary: &Summary,
    broken: Option<&RunError>,
    unwritten: &[Unwritten],
) -> Result<u8, String> {
    let folder = folder.display();
    let complete = unwritten.is_empty() && !matches!(broken, Some(RunError::Unwritten(_)));
    let said = if complete {
        say(&format!(
            "\n{folder} has summary.json, run.mcap, report.html and nodes.log"
        ))
    } else {
        Ok(())
    };
    if let Some(why) = broken {
        let end = summary.simulated_s;
        eprintln!("error: {why}; the results end at {end:.2} s");
    }
    for unwritten in unwritten {
        eprintln!("error: {folder}/{unwritten}");
    }
    said.map(|()| match broken {
        Some(RunError::Interrupted) => interrupt::STATUS,
        Some(_) => 1,
        None => u8::from(!summary.expectation_met || !unwritten.is_empty()),
    })
}

fn bar(duration_s: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:32} {msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new((duration_s * 1e3) as u64).with_style(style)
}

//! Runs one scenario and computes its result from the samples.

use super::edges::Edges;
use super::known::{fingerprint, of_programs, text};
use super::{Commands, Row, Topple};
use crate::programs::Programs;
use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};
use crate::simulator::run::{Options, Outcome, run};
use crate::tools::suite::SuiteError;

/// Runs one scenario. Also returns whether the operator commanded anything before the robot
/// toppled.
///
/// # Errors
/// [`SuiteError::Run`] if the run fails.
pub fn operate(scenario: &Scenario, programs: &Programs) -> Result<(Row, bool), SuiteError> {
    let options = Options {
        end_when_toppled: true,
        ..Options::default()
    };
    let outcome = run(scenario, programs, options)
        .map_err(|error| SuiteError::Run(scenario.name.clone(), error))?;
    let samples = &outcome.samples;
    let armed_s = outcome.commands_s.first().copied();
    let topple = topple(scenario, samples);
    let operated = samples
        .iter()
        .skip_while(|sample| !is_armed(sample))
        .count();
    let armed = samples.iter().filter(|sample| is_armed(sample)).count();
    let commanded = armed_s.is_some_and(|armed| {
        let toppled_s = topple
            .as_ref()
            .map_or(f64::INFINITY, |topple| topple.time_s);
        armed < toppled_s
    });
    let row = Row {
        seed: 0,
        number: 0,
        drawn_again: 0,
        scenario: fingerprint(&text(scenario)),
        programs: of_programs(programs),
        about: scenario.about.clone(),
        topple,
        armed: armed > 0,
        armed_share: armed as f64 / operated.max(1) as f64,
        distance_m: distance_m(samples),
        commands: commands(&outcome),
        simulated_s: samples.last().map_or(0.0, |sample| sample.time_s),
    };
    Ok((row, commanded))
}

fn is_armed(sample: &Sample) -> bool {
    sample.received.guard_state == "armed"
}

/// The samples before the robot topples.
fn upright(samples: &[Sample]) -> impl Iterator<Item = &Sample> {
    samples.iter().take_while(|sample| !sample.truth.toppled)
}

fn distance_m(samples: &[Sample]) -> f64 {
    let period = 1.0 / f64::from(SAMPLE_HZ);
    upright(samples)
        .map(|sample| sample.truth.ground_speed.abs() * period)
        .sum()
}

fn topple(scenario: &Scenario, samples: &[Sample]) -> Option<Topple> {
    let mut edges = Edges::of(scenario);
    for sample in samples {
        edges.follow(sample.time_s, &sample.truth);
        if !sample.truth.toppled {
            continue;
        }
        let early = |before: &&Sample| before.time_s <= sample.time_s - 1.0;
        let before = samples.iter().take_while(early).last().unwrap_or(sample);
        let (truth, received) = (&before.truth, &before.received);
        let rounded = |value: f64| (value * 10.0).round() / 10.0;
        let degrees = |radians: f64| rounded(radians.to_degrees());
        return Some(Topple {
            time_s: sample.time_s,
            over_edge: edges.falling(),
            attitude_deg: [truth.pitch, truth.roll, truth.theta].map(degrees),
            commanded: [received.asked_speed, degrees(received.asked_theta)],
            verdict: received.verdict.clone(),
        });
    }
    None
}

/// Counts the commands by what the guard did with them until the next command or the topple.
fn commands(outcome: &Outcome) -> Commands {
    let mut commands = Commands::default();
    let times = &outcome.commands_s;
    for (index, from_s) in times.iter().enumerate() {
        let until_s = times.get(index + 1).copied().unwrap_or(f64::INFINITY);
        let meanwhile = upright(&outcome.samples).filter(|sample| {
            is_armed(sample) && sample.time_s > *from_s && sample.time_s <= until_s
        });
        let verdicts: Vec<&str> = meanwhile
            .map(|sample| sample.received.verdict.as_str())
            .collect();
        if verdicts
            .iter()
            .any(|verdict| verdict.starts_with("refused"))
        {
            commands.refused += 1;
        } else if verdicts.iter().any(|verdict| *verdict != "passed") {
            commands.scaled += 1;
        } else if !verdicts.is_empty() {
            commands.passed += 1;
        }
    }
    commands
}

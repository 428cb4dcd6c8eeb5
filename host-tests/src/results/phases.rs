//! When a robot has landed: it stands level behind the last nose.

use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};

/// A robot counts as landed behind the last nose when it stays this level, rad.
const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// How long it must stay so, samples.
const LEVEL_SAMPLES: usize = SAMPLE_HZ as usize / 2;
/// The climb begins when the pitch first exceeds this, rad.
const CLIMBING: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// A wheel that carries less than this does not stand, N.
const LEAST_LOAD: f64 = 0.1;

/// First sample of a level stand behind the last nose. A robot with wheels stands when all of them are there and carry load.
pub fn landing(scenario: &Scenario, samples: &[Sample]) -> Option<usize> {
    let nose = scenario.terrain.last_nose_m()?;
    let behind = |sample: &Sample| {
        if scenario.kind().facts().stands_on_wheels {
            all(sample, "_x_m", nose) && all(sample, "_load_n", LEAST_LOAD)
        } else {
            sample.truth.cog[0] > nose
        }
    };
    let stands = |sample: &Sample| {
        let truth = &sample.truth;
        let level = truth.pitch.abs() < LEVEL && truth.roll.abs() < LEVEL;
        level && !truth.toppled && behind(sample)
    };
    samples
        .windows(LEVEL_SAMPLES)
        .position(|window| window.iter().all(stands))
}

/// Whether there are channels with this ending, and all of them are above a value.
fn all(sample: &Sample, ending: &str, least: f64) -> bool {
    let channels = sample.truth.channels.iter();
    let mut values = channels
        .filter(|(name, _)| name.ends_with(ending))
        .map(|(_, value)| *value)
        .peekable();
    values.peek().is_some() && values.all(|value| value > least)
}

/// The samples from the first nose to the landing, or to the end; none when the robot never climbed.
pub(crate) fn climb(scenario: &Scenario, samples: &[Sample]) -> std::ops::Range<usize> {
    let end = landing(scenario, samples).unwrap_or(samples.len());
    let start = samples[..end]
        .iter()
        .position(|sample| sample.truth.pitch > CLIMBING);
    start.unwrap_or(end)..end
}

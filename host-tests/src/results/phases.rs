//! Finds the climb of a run and its landing: the robot stands level behind the last nose (front
//! edge of a step).

use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};

/// Pitch and roll of a robot that has landed stay below this, rad.
const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Number of samples for which a robot that has landed stays level: half a second.
const LEVEL_SAMPLES: usize = SAMPLE_HZ as usize / 2;
/// The climb begins when the pitch first exceeds this, rad.
const CLIMBING: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// A wheel that carries less than this does not count as standing, N.
const LEAST_LOAD: f64 = 0.1;

/// Index of the sample at which the robot lands: from there it stands level behind the last nose
/// for half a second. A robot with wheels stands there when all its wheels are behind the nose and
/// carry load; another robot when its centre of gravity is behind the nose. `None` without a
/// landing, or without a nose in the terrain.
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

/// Whether there are channels whose names end with `ending`, and all their values are above
/// `least`.
fn all(sample: &Sample, ending: &str, least: f64) -> bool {
    let channels = sample.truth.channels.iter();
    let mut values = channels
        .filter(|(name, _)| name.ends_with(ending))
        .map(|(_, value)| *value)
        .peekable();
    values.peek().is_some() && values.all(|value| value > least)
}

/// The samples of the climb: from the first pitch above 8 degrees to the landing, or to the end of
/// the run. Empty if the robot never climbed.
pub(crate) fn climb(scenario: &Scenario, samples: &[Sample]) -> std::ops::Range<usize> {
    let end = landing(scenario, samples).unwrap_or(samples.len());
    let start = samples[..end]
        .iter()
        .position(|sample| sample.truth.pitch > CLIMBING);
    start.unwrap_or(end)..end
}

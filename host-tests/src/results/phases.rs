//! Finds the climb of a run and its landing: the robot stands level behind the last nose (front
//! edge of a step).

use crate::scenario::Scenario;
use crate::simulator::record::{SAMPLE_HZ, Sample};
use std::collections::VecDeque;

/// Pitch and roll of a robot that has landed stay below this, rad.
const LEVEL: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Number of samples for which a robot that has landed stays level: half a second.
const LEVEL_SAMPLES: usize = SAMPLE_HZ as usize / 2;
/// The climb begins when the pitch first exceeds this, rad.
const CLIMBING: f64 = 8.0 * std::f64::consts::PI / 180.0;
/// A wheel that carries less than this does not count as standing, N.
const LEAST_LOAD: f64 = 0.1;

/// Boundary between two parts of a run: it is between two samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Boundary {
    /// Number of samples before it.
    pub index: usize,
    /// Time of the sample after it, s.
    pub time_s: f64,
    /// Time of the sample before it, s; 0 without one.
    pub before_s: f64,
}

/// Finds the climb and the landing of a run, sample by sample.
///
/// The climb lasts from the first pitch above 8 degrees to the landing, or to the end of the run.
/// From the landing on, the robot stands level behind the last nose for half a second. A robot with
/// wheels stands there when all its wheels are behind the nose and carry load; another robot when
/// its centre of gravity is behind the nose. Without a nose in the terrain no robot lands.
///
/// A landing is known half a second late. Until then it is open whether the samples of this half
/// second belong to the climb ([`Self::decided`]).
pub struct Phases {
    nose: Option<f64>,
    stands_on_wheels: bool,
    /// End of the samples so far; its `time_s` has no meaning.
    end: Boundary,
    /// Boundary since which the robot stands level behind the nose.
    standing: Option<Boundary>,
    climb: Option<Boundary>,
    landing: Option<Boundary>,
}

impl Phases {
    /// Begins a run of this scenario.
    pub fn new(scenario: &Scenario) -> Self {
        Self {
            nose: scenario.terrain.last_nose_m(),
            stands_on_wheels: scenario.kind().facts().stands_on_wheels,
            end: Boundary::default(),
            standing: None,
            climb: None,
            landing: None,
        }
    }

    /// Adds the next sample.
    pub fn add(&mut self, sample: &Sample) {
        let here = Boundary {
            time_s: sample.time_s,
            ..self.end
        };
        self.end.index += 1;
        self.end.before_s = sample.time_s;
        if self.landing.is_some() {
            return;
        }
        if sample.truth.pitch > CLIMBING {
            self.climb = self.climb.or(Some(here));
        }
        self.standing = self.stands(sample).then(|| self.standing.unwrap_or(here));
        let landed = |since: &Boundary| self.end.index - since.index >= LEVEL_SAMPLES;
        self.landing = self.standing.filter(landed);
    }

    fn stands(&self, sample: &Sample) -> bool {
        let truth = &sample.truth;
        let level = truth.pitch.abs() < LEVEL && truth.roll.abs() < LEVEL;
        let behind = |nose: f64| {
            if self.stands_on_wheels {
                all(sample, "_x_m", nose) && all(sample, "_load_n", LEAST_LOAD)
            } else {
                truth.cog[0] > nose
            }
        };
        level && !truth.toppled && self.nose.is_some_and(behind)
    }

    /// End of the samples so far. Its `time_s` has no meaning.
    pub fn end(&self) -> Boundary {
        self.end
    }

    /// Start of the climb.
    pub fn climb(&self) -> Option<Boundary> {
        self.climb
    }

    /// The landing, which ends the climb.
    pub fn landing(&self) -> Option<Boundary> {
        self.landing
    }

    /// Number of samples, from the first one, of which it is certain whether they belong to the
    /// climb. It is at most half a second behind the samples so far.
    pub fn decided(&self) -> usize {
        match (self.landing, self.standing) {
            (None, Some(since)) => since.index,
            _ => self.end.index,
        }
    }

    /// Whether this sample belongs to the climb; of a sample that is not decided, whether it does
    /// if the run ends now.
    pub fn climbs(&self, index: usize) -> bool {
        let begun = self.climb.is_some_and(|climb| climb.index <= index);
        begun && self.landing.is_none_or(|landing| index < landing.index)
    }
}

/// Values of samples that wait until it is decided whether they belong to the climb.
pub struct Undecided<T>(VecDeque<(usize, T)>);

impl<T> Default for Undecided<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> Undecided<T> {
    /// Adds the value of a sample. The samples come in order.
    pub fn add(&mut self, index: usize, value: T) {
        self.0.push_back((index, value));
    }

    /// Removes the values of the samples before `until`, and returns those that belong to the
    /// climb.
    pub fn take(&mut self, phases: &Phases, until: usize) -> impl Iterator<Item = T> {
        let ready = self.0.partition_point(|(index, _)| *index < until);
        let ready = self.0.drain(..ready);
        ready.filter_map(move |(index, value)| phases.climbs(index).then_some(value))
    }
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

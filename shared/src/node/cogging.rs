//! Search for the current that cancels the cogging torque, in a drive's node: on request, while a
//! client turns the shaft in bench mode.

use crate::bus::cia402::State;
use crate::math::{Turns, to_i16, to_i32};
use crate::motor::cogging::{Progress, Search, Wave};
use crate::node::axle::{Inputs, Outputs};
use crate::settings::{Setting, Settings};

/// Part of the calibration's current that the search tries.
const TEST: f32 = 0.2;

/// State of the search, as object 0x2066 shows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum SearchState {
    /// None was requested since power-up.
    #[default]
    None = 0,
    /// It is under way.
    UnderWay = 1,
    /// It has found a current, which is in use until power off.
    Done = 2,
    /// It has found none, or something has ended it. The current of the settings is in use.
    Failed = 3,
}

/// State and results, as the objects 0x2066 to 0x2069 show them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Report {
    /// State of the search.
    pub state: SearchState,
    /// Values of the settings `cogging_cosine` and `cogging_sine`, mA.
    pub current: [i32; 2],
    /// Ripple that is left, 1e-3 of the ripple without a current.
    pub residual: i16,
}

/// Search of one node.
#[derive(Clone, Debug)]
pub struct CoggingSearch {
    periods: i32,
    test: f32,
    stored: Wave,
    running: Option<Search>,
    applied: Wave,
    report: Report,
}

/// Returns the periods in an electrical turn and the current of the settings.
pub fn stored(settings: &Settings) -> (i32, Wave) {
    let wave = Wave {
        cosine: settings.si(Setting::CoggingCosine),
        sine: settings.si(Setting::CoggingSine),
    };
    (settings.get(Setting::CoggingPeriods), wave)
}

impl CoggingSearch {
    /// Creates the search of a node with these settings, which are in use.
    pub fn new(settings: &Settings) -> Self {
        let (periods, stored) = stored(settings);
        Self {
            periods,
            test: TEST * settings.si(Setting::CalibrationCurrent),
            stored,
            running: None,
            applied: stored,
            report: Report::default(),
        }
    }

    /// Returns state and results.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Returns whether a search is under way.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Runs one control period. `requested`: a client requests a search. Returns the periods and
    /// the current that the current loop uses from now on, if they change.
    pub fn tick(
        &mut self,
        requested: bool,
        inputs: &Inputs,
        outputs: &Outputs,
        position: Turns,
    ) -> Option<(i32, Wave)> {
        if self.running.is_none() {
            if !requested {
                return None;
            }
            self.running = Some(Search::new(self.periods, self.test));
            self.report = Report {
                state: SearchState::UnderWay,
                ..Report::default()
            };
        }
        let operates =
            State::from_statusword(outputs.status.statusword) == Some(State::OperationEnabled);
        let allowed = requested && operates && outputs.bench_mode && self.periods != 0;
        let progress = match (&mut self.running, inputs.electrical.angle) {
            (Some(search), Some(angle)) if allowed => search.tick(angle, position),
            _ => Progress::Failed,
        };
        let wave = match progress {
            Progress::Apply(wave) => wave,
            Progress::Done(wave, residual) => {
                self.running = None;
                self.report = Report {
                    state: SearchState::Done,
                    current: [wave.cosine, wave.sine].map(|amperes| to_i32(amperes * 1e3)),
                    residual: to_i16(residual * 1e3),
                };
                wave
            }
            Progress::Failed => {
                self.running = None;
                self.report.state = SearchState::Failed;
                self.stored
            }
        };
        if wave == self.applied {
            return None;
        }
        self.applied = wave;
        Some((self.periods, wave))
    }
}

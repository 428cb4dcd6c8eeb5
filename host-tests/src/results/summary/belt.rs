//! Computes strain and slack of a belt that a screw keeps taut.

use super::percentile::Largest;
use crate::results::phases::{Phases, Undecided};
use crate::simulator::record::Sample;
use serde::Serialize;

/// Strain or slack of the belt during the climb, m; zero if the robot never climbed.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct TensionError {
    /// 99th percentile of the samples.
    pub p99: f64,
    /// Maximum.
    pub max: f64,
}

/// Strain and slack of the belt so far.
#[derive(Default)]
pub(super) struct Belt {
    undecided: Undecided<f64>,
    errors: Largest,
}

impl Belt {
    /// Adds the sample that `phases` has last.
    pub fn add(&mut self, sample: &Sample, phases: &Phases) {
        let index = phases.end().index - 1;
        self.undecided.add(index, sample.truth.tension_error);
        self.add_decided(phases, phases.decided());
    }

    fn add_decided(&mut self, phases: &Phases, until: usize) {
        for error in self.undecided.take(phases, until) {
            self.errors.add(error);
        }
    }

    /// The figures of a run that ends now.
    pub fn figures(mut self, phases: &Phases) -> TensionError {
        self.add_decided(phases, usize::MAX);
        TensionError {
            p99: self.errors.percentile(99),
            max: self.errors.percentile(100),
        }
    }
}

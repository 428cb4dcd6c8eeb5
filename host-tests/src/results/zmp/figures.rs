//! Computes mean and peak of `|ZMP - CoG|`.

use super::Moment;
use serde::Serialize;

/// `|ZMP - CoG|` in percent of the robot's length.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Figures {
    /// As computed at each sample, without smoothing.
    pub raw: MeanAndPeak,
    /// Smoothed over [`super::SMOOTHING_S`].
    pub smoothed: MeanAndPeak,
}

/// Mean and peak of one series, %.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct MeanAndPeak {
    /// Mean.
    pub mean: f64,
    /// Maximum.
    pub peak: f64,
}

/// Absolute values of a series.
#[derive(Clone, Copy, Debug, Default)]
struct Series {
    sum: f64,
    peak: f64,
    count: usize,
}

impl Series {
    fn add(&mut self, value: f64) {
        self.sum += value.abs();
        self.peak = self.peak.max(value.abs());
        self.count += 1;
    }

    /// Mean and peak, each multiplied by `unit`; `None` without values.
    fn figures(&self, unit: f64) -> Option<MeanAndPeak> {
        (self.count > 0).then(|| MeanAndPeak {
            mean: unit * self.sum / self.count as f64,
            peak: unit * self.peak,
        })
    }
}

/// Moments of a climb, added up.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    raw: Series,
    smoothed: Series,
}

impl Sums {
    pub fn add(&mut self, moment: &Moment) {
        if let Some(difference) = moment.difference() {
            self.raw.add(difference);
        }
        if let Some(smoothed) = moment.smoothed {
            self.smoothed.add(smoothed);
        }
    }

    /// The figures; `None` without moments. `unit` converts a difference in m to percent.
    pub fn figures(&self, unit: f64) -> Option<Figures> {
        Some(Figures {
            raw: self.raw.figures(unit)?,
            smoothed: self.smoothed.figures(unit)?,
        })
    }
}

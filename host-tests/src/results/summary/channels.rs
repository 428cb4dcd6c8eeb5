//! Computes the figures of robot-specific channels.

use crate::simulator::record::{SAMPLE_HZ, Sample};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};

/// Length of the period at the end of a run over which a channel's settled value is averaged, s.
pub const SETTLED_S: u32 = 5;

/// Minimum and maximum of a series.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Range {
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
}

/// Figures of one channel of [`crate::world::truth::Truth::channels`].
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ChannelFigures {
    /// Minimum.
    pub min: f64,
    /// Maximum.
    pub max: f64,
    /// Mean over the last [`SETTLED_S`] seconds.
    pub settled: f64,
}

impl Range {
    /// Extends the range of `before`, if there is one, to a value.
    pub(super) fn with(before: Option<Self>, value: f64) -> Self {
        let Self { min, max } = before.unwrap_or(Self {
            min: value,
            max: value,
        });
        Self {
            min: min.min(value),
            max: max.max(value),
        }
    }
}

/// The channels so far.
#[derive(Default)]
pub(super) struct Channels {
    ranges: BTreeMap<&'static str, Range>,
    /// The channels of the last [`SETTLED_S`] seconds.
    last: VecDeque<BTreeMap<&'static str, f64>>,
}

impl Channels {
    pub fn add(&mut self, sample: &Sample) {
        let channels = &sample.truth.channels;
        for (name, value) in channels {
            let before = self.ranges.get(name).copied();
            self.ranges.insert(name, Range::with(before, *value));
        }
        if self.last.len() == (SETTLED_S * SAMPLE_HZ) as usize {
            self.last.pop_front();
        }
        self.last.push_back(channels.clone());
    }

    pub fn figures(&self) -> BTreeMap<&'static str, ChannelFigures> {
        let of = |(name, range): (&&'static str, &Range)| {
            let values = || self.last.iter().filter_map(|channels| channels.get(name));
            let settled = values().sum::<f64>() / values().count().max(1) as f64;
            let Range { min, max } = *range;
            (*name, ChannelFigures { min, max, settled })
        };
        self.ranges.iter().map(of).collect()
    }
}

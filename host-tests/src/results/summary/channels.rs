//! Computes the figures of robot-specific channels.

use crate::simulator::record::{SAMPLE_HZ, Sample};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

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

pub(super) fn channels(samples: &[Sample]) -> BTreeMap<&'static str, ChannelFigures> {
    let last = samples
        .len()
        .saturating_sub((SETTLED_S * SAMPLE_HZ) as usize);
    let keys = samples
        .iter()
        .flat_map(|sample| sample.truth.channels.keys());
    let names: BTreeSet<&'static str> = keys.copied().collect();
    let of = |name: &'static str| {
        let values = |from: usize| {
            samples[from..]
                .iter()
                .filter_map(move |sample| sample.truth.channels.get(name).copied())
        };
        let Range { min, max } = range(values(0));
        let settled = values(last).sum::<f64>() / values(last).count().max(1) as f64;
        (name, ChannelFigures { min, max, settled })
    };
    names.into_iter().map(of).collect()
}

pub(super) fn range(values: impl Iterator<Item = f64>) -> Range {
    values
        .map(|value| Range {
            min: value,
            max: value,
        })
        .reduce(|a, b| Range {
            min: a.min.min(b.min),
            max: a.max.max(b.max),
        })
        .unwrap_or_default()
}

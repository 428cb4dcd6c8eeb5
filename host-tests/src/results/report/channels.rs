//! Makes the plots of a robot's own channels. Channels that differ only in their place on the robot
//! share a plot.
//!
//! `front_left_load_n` is the curve "front left" of the plot "Load" in N: the last word is the
//! unit, and the words of place name the curve.

use crate::results::channel::Channel;
use crate::results::summary::{ChannelFigures, Summary};
use crate::simulator::record::Sample;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A column of the page: name, value of one step, values. The page stores values as whole numbers
/// of steps.
pub type Column = (String, f64, Vec<Option<f64>>);

/// Maximum number of curves in one plot: more cannot be told apart.
const MOST_CURVES: usize = 8;

/// Every name that occurs in any sample, in alphabetical order: a channel may be absent at first.
fn names(samples: &[&Sample]) -> BTreeSet<&'static str> {
    let names = samples
        .iter()
        .flat_map(|sample| sample.truth.channels.keys());
    names.copied().collect()
}

/// The columns of all channels, and of the currents of `drives` drives.
pub fn columns(samples: &[&Sample], drives: usize) -> Vec<Column> {
    let channels = names(samples).into_iter().map(|name| {
        let values = samples
            .iter()
            .map(|sample| sample.truth.channels.get(name).copied());
        let values: Vec<_> = values.collect();
        let largest = values
            .iter()
            .flatten()
            .fold(1e-6, |most, value| f64::max(most, value.abs()));
        // The step is 10^-4 of the largest value's power of ten.
        let one = libm::exp10(libm::floor(libm::log10(largest)) - 4.0);
        (name.to_owned(), one, values)
    });
    let currents = (0..drives).map(|drive| {
        let values = samples
            .iter()
            .map(|sample| sample.received.currents.get(drive).copied());
        (current(drive), 0.01, values.collect())
    });
    channels.chain(currents).collect()
}

/// The plots of a robot's channels and of its drives' currents, in the form that the page reads.
pub fn plots(samples: &[&Sample], drives: &[&str]) -> Vec<Value> {
    let mut groups: Vec<(Channel, Vec<Value>)> = Vec::new();
    for name in names(samples) {
        let channel = Channel::new(name);
        let label = if channel.place.is_empty() {
            "truth"
        } else {
            &channel.place
        };
        let curve = json!([label, name]);
        match groups
            .iter_mut()
            .find(|(first, _)| first.title == channel.title && first.unit == channel.unit)
        {
            Some((_, curves)) => curves.push(curve),
            None => groups.push((channel, vec![curve])),
        }
    }
    let mut plots = Vec::new();
    for (first, curves) in groups {
        for part in curves.chunks(MOST_CURVES) {
            plots.push(json!({ "title": first.title, "unit": first.unit, "curves": part }));
        }
    }
    plots.extend(currents(drives));
    plots
}

/// The plots of the currents: one plot for up to [`MOST_CURVES`] drives, otherwise one for each
/// kind of drive. The last word of a drive's name is its kind.
fn currents(drives: &[&str]) -> Vec<Value> {
    let split = drives.len() > MOST_CURVES;
    let mut groups: Vec<(String, Vec<Value>)> = Vec::new();
    for (drive, name) in drives.iter().enumerate() {
        let (place, kind) = name.rsplit_once('_').unwrap_or((name, name));
        let (title, label) = if split {
            (format!("Motor currents, {kind}"), place)
        } else {
            ("Motor currents".to_owned(), *name)
        };
        let curve = json!([label.replace('_', " "), current(drive)]);
        match groups.iter_mut().find(|(first, _)| *first == title) {
            Some((_, curves)) => curves.push(curve),
            None => groups.push((title, vec![curve])),
        }
    }
    let plot = |(title, curves): (String, Vec<Value>)| {
        let part =
            |part: &[Value]| json!({ "title": title, "unit": "A", "zero": true, "curves": part });
        curves.chunks(MOST_CURVES).map(part).collect::<Vec<_>>()
    };
    groups.into_iter().flat_map(plot).collect()
}

fn current(drive: usize) -> String {
    format!("current{drive}")
}

/// The summary's headline channels as name, settled value, unit and range.
pub fn figures(summary: &Summary) -> Vec<Value> {
    let figure = |(channel, found): (Channel, ChannelFigures)| {
        let range = [found.min, found.max];
        json!([channel.name(), found.settled, channel.unit, range])
    };
    summary.headlines().map(figure).collect()
}

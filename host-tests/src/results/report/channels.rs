//! Makes the plots of a robot's own channels. Channels that differ only in their place on the robot
//! share a plot.
//!
//! `front_left_load_n` is the curve "front left" of the plot "Load" in N: the last word is the
//! unit, and the words of place name the curve.

use super::columns::Column;
use super::decimation::Span;
use crate::results::channel::Channel;
use crate::results::summary::{ChannelFigures, Summary};
use serde_json::{Value, json};

/// Maximum number of curves in one plot: more cannot be told apart.
const MOST_CURVES: usize = 8;

/// The column of a channel. One step is 10^-4 of the largest value's power of ten.
pub(super) fn column(length: usize, spans: &[Span]) -> Column {
    let ends = spans.iter().flat_map(|span| [span.least, span.most]);
    let largest = ends.fold(1e-6, |most, value| f64::max(most, value.abs()));
    Column::curve(
        libm::exp10(libm::floor(libm::log10(largest)) - 4.0),
        length,
        spans,
    )
}

/// The column of a drive's current, with its name.
pub(super) fn current_column(drive: usize, length: usize, spans: &[Span]) -> (String, Column) {
    (current(drive), Column::curve(0.01, length, spans))
}

/// The plots of a robot's channels, in alphabetical order, and of its drives' currents, in the form
/// that the page reads.
pub(super) fn plots<'a>(names: impl Iterator<Item = &'a str>, drives: &[&str]) -> Vec<Value> {
    let mut groups: Vec<(Channel, Vec<Value>)> = Vec::new();
    for name in names {
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

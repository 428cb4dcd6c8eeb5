//! Defines the curves of the page and packs them into columns of integers, each with the value of
//! one step. That takes about a quarter of the size of rounded decimals.

use super::decimation::Span;
use crate::results::zmp::Moment;
use crate::simulator::record::Sample;
use serde::Serialize;
use tautrack::stability::support::NO_EDGE;

/// Name in the page, value of one step, source.
pub type Source<T> = (&'static str, f64, fn(&T) -> Option<f64>);

/// The guard's margin to one edge of the support; `None` if it knows none or that edge does not
/// exist.
fn edge(sample: &Sample, edge: usize) -> Option<f64> {
    let margin = sample.received.margins.map(|margins| margins[edge]);
    margin.filter(|margin| *margin < f64::from(NO_EDGE))
}

/// The curves of every robot. Angles become degrees.
pub(super) const CURVES: &[Source<Sample>] = &[
    ("pitch", 0.01, |s| Some(s.truth.pitch.to_degrees())),
    ("back", 1e-3, |s| s.truth.backward_margin),
    ("front", 1e-3, |s| s.truth.forward_margin),
    ("guardBack", 1e-3, |s| edge(s, 0)),
    ("guardFront", 1e-3, |s| edge(s, 1)),
    ("receivedPitch", 0.01, |s| {
        Some(s.received.pitch.to_degrees())
    }),
    ("askedSpeed", 1e-3, |s| Some(s.received.asked_speed)),
    ("passedSpeed", 1e-3, |s| Some(s.received.passed_speed)),
    ("speed", 1e-3, |s| Some(s.truth.ground_speed)),
    ("busLoad", 0.1, |s| Some(s.received.bus_load * 100.0)),
];

/// The curves of Fig. 8 of Paillat et al. Distances are measured from `P1`, axle 1.
pub(super) const BALANCE_CURVES: &[Source<Moment>] = &[
    ("p1", 1e-3, |moment| Some(moment.axles[0])),
    ("p2", 1e-3, |moment| Some(moment.axles[1])),
    ("p3", 1e-3, |moment| Some(moment.axles[2])),
    ("cogAlong", 1e-4, |moment| Some(moment.cog)),
    ("zmpAlong", 1e-4, |moment| moment.zmp),
    ("zmpOff", 1e-5, Moment::difference),
    ("zmpOffSmoothed", 1e-5, |moment| moment.smoothed),
];

/// A column of the page. The page stores values as whole numbers of steps.
#[derive(Serialize)]
pub struct Column {
    /// Value of one step.
    one: f64,
    /// First value of each interval; `None` if it has none.
    values: Vec<Option<i32>>,
    /// How far the minimum of each interval is below its first value; absent if an interval is one
    /// sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    below: Option<Vec<u32>>,
    /// How far the maximum of each interval is above its first value.
    #[serde(skip_serializing_if = "Option::is_none")]
    above: Option<Vec<u32>>,
}

impl Column {
    /// A column without minima and maxima.
    pub(super) fn plain(one: f64, values: impl Iterator<Item = f64>) -> Self {
        Self {
            one,
            values: values.map(|value| Some(steps(value, one))).collect(),
            below: None,
            above: None,
        }
    }

    /// A curve of intervals with `length` samples each.
    pub(super) fn curve(one: f64, length: usize, spans: &[Span]) -> Self {
        let first = |span: &Span| (!span.first.is_nan()).then(|| steps(span.first, one));
        let beyond = |end: fn(&Span) -> f64| {
            let distance = |span: &Span| steps(end(span), one).abs_diff(steps(span.first, one));
            (length > 1).then(|| spans.iter().map(distance).collect())
        };
        Self {
            one,
            values: spans.iter().map(first).collect(),
            below: beyond(|span| span.least),
            above: beyond(|span| span.most),
        }
    }
}

/// Converts a value to steps of `one`; NaN becomes 0.
pub(super) fn steps(value: f64, one: f64) -> i32 {
    (value / one).round() as i32
}

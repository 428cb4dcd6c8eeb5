//! Samples as columns of integers, each with the value of one: about a quarter of the size of rounded decimals.

use super::channels;
use crate::balance::{Balance, Moment, PAPER_PERCENT, length};
use crate::machines::{self, Kind};
use crate::record::Sample;
use crate::scenario::Scenario;
use crate::summary::{Summary, intervenes};
use serde_json::{Map, Value, json};
use tautrack::stability::support::NO_EDGE;

/// The guard's margin to an edge that is there.
fn edge(sample: &Sample, edge: usize) -> Option<f64> {
    let margin = sample.heard.margins.map(|margins| margins[edge]);
    margin.filter(|margin| *margin < f64::from(NO_EDGE))
}

/// A longer run shows every n-th sample, so that the page stays below 2 MB; `run.mcap` has them all.
const MOST_SAMPLES: usize = 6_000;
/// Marks beyond these are counted, not shown.
const MOST_MARKS: usize = 300;

type Column = (&'static str, f64, fn(&Sample) -> Option<f64>);

/// Name in the page, value of one, source. Angles become degrees.
const COLUMNS: &[Column] = &[
    ("t", 1e-3, |s| Some(s.time_s)),
    ("x", 1e-4, |s| Some(s.truth.axle_1[0])),
    ("z", 1e-4, |s| Some(s.truth.axle_1[2])),
    ("pitch", 0.01, |s| Some(s.truth.pitch.to_degrees())),
    ("cogX", 1e-3, |s| Some(s.truth.cog[0])),
    ("cogZ", 1e-3, |s| Some(s.truth.cog[2])),
    ("back", 1e-3, |s| s.truth.backward_margin),
    ("front", 1e-3, |s| s.truth.forward_margin),
    ("guardBack", 1e-3, |s| edge(s, 0)),
    ("guardFront", 1e-3, |s| edge(s, 1)),
    ("heardPitch", 0.01, |s| Some(s.heard.pitch.to_degrees())),
    ("odometry", 1e-4, |s| Some(s.heard.odometry)),
    ("askedSpeed", 1e-3, |s| Some(s.heard.asked_speed)),
    ("passedSpeed", 1e-3, |s| Some(s.heard.passed_speed)),
    ("speed", 1e-3, |s| Some(s.truth.ground_speed)),
    ("busLoad", 0.1, |s| Some(s.heard.bus_load * 100.0)),
];

/// What only B2P2 has.
const B2P2_COLUMNS: &[Column] = &[
    ("theta", 0.01, |s| Some(s.truth.theta.to_degrees())),
    ("extension", 1e-4, |s| Some(s.truth.extension)),
    ("tension", 0.01, |s| Some(s.truth.tension_error * 1e3)),
    ("askedTheta", 0.01, |s| {
        Some(s.heard.asked_theta.to_degrees())
    }),
    ("passedTheta", 0.01, |s| {
        Some(s.heard.passed_theta.to_degrees())
    }),
    ("leftCurrent", 0.01, |s| s.heard.currents.first().copied()),
    ("rightCurrent", 0.01, |s| s.heard.currents.get(1).copied()),
    ("chassisCurrent", 0.01, |s| s.heard.currents.get(2).copied()),
    ("screwCurrent", 0.01, |s| s.heard.currents.get(3).copied()),
];

type BalanceColumn = (&'static str, f64, fn(&Moment) -> Option<f64>);

/// As [`COLUMNS`], of Fig. 8; `P1` is the zero of the others.
const BALANCE_COLUMNS: &[BalanceColumn] = &[
    ("p1", 1e-3, |moment| Some(moment.axles[0])),
    ("p2", 1e-3, |moment| Some(moment.axles[1])),
    ("p3", 1e-3, |moment| Some(moment.axles[2])),
    ("cogAlong", 1e-4, |moment| Some(moment.cog)),
    ("zmpAlong", 1e-4, |moment| moment.zmp),
    ("zmpOff", 1e-5, Moment::difference),
    ("zmpOffSmoothed", 1e-5, |moment| moment.smoothed),
];

/// Everything that the page draws from.
pub(super) fn pack(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> Value {
    let stride = samples.len().div_ceil(MOST_SAMPLES).max(1);
    let shown = || samples.iter().step_by(stride);
    let column = |name: &str, one: f64, values: Vec<Option<i64>>| {
        (name.to_owned(), json!({ "one": one, "values": values }))
    };
    let source = |(name, one, source): &Column| {
        let values = shown().map(|sample| quantise(source(sample), *one));
        column(name, *one, values.collect())
    };
    let mut columns: Map<_, _> = COLUMNS.iter().map(source).collect();
    let kind = scenario.kind();
    let drawn = (kind != Kind::B2p2).then(|| machines::machine(scenario).plant.sketch());
    let balance = if drawn.is_some() {
        Balance::default()
    } else {
        columns.extend(B2P2_COLUMNS.iter().map(source));
        Balance::new(scenario, samples)
    };
    if drawn.is_none() {
        columns.extend(BALANCE_COLUMNS.iter().map(|(name, one, source)| {
            let moments = balance.moments.iter().step_by(stride);
            let values = moments.map(|moment| quantise(moment.as_ref().and_then(source), *one));
            column(name, *one, values.collect())
        }));
    }
    let sketch = drawn.as_ref().map(|sketch| {
        let nodes: Vec<_> = summary.nodes.iter().map(|node| node.name.as_str()).collect();
        let drives = &nodes[..nodes.len().saturating_sub(1)];
        let shown: Vec<_> = shown().collect();
        columns.extend(
            channels::columns(&shown, drives.len())
                .into_iter()
                .map(|(name, one, values)| {
                    let values = values.into_iter().map(|value| quantise(value, one));
                    column(&name, one, values.collect())
                }),
        );
        json!({
            "circles": sketch.circles,
            "lines": sketch.lines,
            "points": shown.iter().map(|sample| flat(&sample.truth.points, 1e-3)).collect::<Vec<_>>(),
            "plots": channels::plots(&shown, drives),
            "figures": channels::figures(summary),
            "note": kind.plots_note(),
            "origin": kind.origin(),
        })
    });
    let areas: Vec<Value> = ["A1", "A2", "A3"]
        .iter()
        .zip(&balance.areas)
        .filter_map(|(name, area)| {
            let [first, last] = [area.clone().next()?, area.clone().next_back()?];
            Some(json!([name, samples[first].time_s, samples[last].time_s]))
        })
        .collect();
    let (least_x, most_x) = samples
        .iter()
        .map(|sample| sample.truth.axle_1[0])
        .fold((0.0, 0.0), |(least, most), x| {
            (f64::min(least, x), f64::max(most, x))
        });
    let end = scenario.terrain.last_nose_m().unwrap_or(0.0).max(most_x) + 1.2;
    let begin = least_x.min(0.0) - 0.6;
    let terrain = match &drawn {
        None => scenario.terrain.ground().section(begin, end),
        Some(sketch) => clipped(&sketch.ground, begin, end),
    };
    // A small robot's contacts are near each other.
    let contact_one = if drawn.is_some() { 1e-3 } else { 1e-2 };
    let (marks, marks_left_out) = marks(scenario, summary, samples);
    json!({
        "about": scenario.about,
        "guardOn": scenario.guard,
        "friction": scenario.friction,
        "robot": scenario.robot,
        "l1": scenario.parameters().l1,
        "l2": scenario.parameters().l2,
        "terrain": terrain,
        "sketch": sketch,
        "summary": summary,
        "stride": stride,
        "columns": columns,
        "areas": areas,
        "length": length(&scenario.parameters()),
        "paperZmpPercent": PAPER_PERCENT,
        "contactOne": contact_one,
        "contacts": shown().map(|sample| contacts(sample, contact_one)).collect::<Vec<_>>(),
        "guardState": changes(shown().map(|sample| sample.heard.guard_state.as_str())),
        "verdict": changes(shown().map(|sample| sample.heard.verdict.as_str())),
        "marks": marks,
        "marksLeftOut": marks_left_out,
    })
}

/// The part of a line of points (x, z) with ascending x that is between two x.
fn clipped(line: &[[f64; 2]], begin: f64, end: f64) -> Vec<[f64; 2]> {
    let mut part = Vec::new();
    for pair in line.windows(2) {
        let [[x0, z0], [x1, z1]] = [pair[0], pair[1]];
        let [from, to] = [x0.max(begin), x1.min(end)];
        if from <= to {
            let at = |x: f64| {
                if x1 > x0 {
                    z0 + (z1 - z0) * (x - x0) / (x1 - x0)
                } else {
                    z1
                }
            };
            // A step up or down has two heights at one x.
            let first = if x1 > x0 { at(from) } else { z0 };
            part.extend([[from, first], [to, at(to)]]);
        }
    }
    part.dedup();
    part
}

/// In steps of `one`; what is not a number is absent.
fn quantise(value: Option<f64>, one: f64) -> Option<i64> {
    value
        .filter(|value| value.is_finite())
        .map(|value| (value / one).round() as i64)
}

/// Contacts in the side view, in steps of `one` (m); left and right fall together.
fn contacts(sample: &Sample, one: f64) -> Vec<i64> {
    let places = flat(&sample.truth.contacts, one);
    let mut points: Vec<_> = places.chunks_exact(2).collect();
    points.sort_unstable();
    points.dedup();
    points.concat()
}

/// x and z of places one after the other, in steps of `one` (m).
fn flat(places: &[[f64; 3]], one: f64) -> Vec<i64> {
    let steps = |metres: f64| (metres / one).round() as i64;
    places
        .iter()
        .flat_map(|[x, _, z]| [steps(*x), steps(*z)])
        .collect()
}

/// Index and new text wherever a text changes.
fn changes<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<Value> {
    let mut before = None;
    let mut found = Vec::new();
    for (index, text) in texts.enumerate() {
        if before != Some(text) {
            found.push(json!([index, text]));
            before = Some(text);
        }
    }
    found
}

/// Moments worth a line, in order of time: what the guard changed, what was broken, what became known, how it ended.
/// Also how many were left out; what was broken and how it ended never is.
fn marks(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> (Vec<Value>, usize) {
    let mark = |time_s: f64, kind: &str, text: &str| {
        (time_s, json!({ "t": time_s, "kind": kind, "text": text }))
    };
    let mut found = Vec::new();
    let mut verdict = "";
    for sample in samples {
        if sample.heard.verdict != verdict {
            verdict = &sample.heard.verdict;
            if intervenes(verdict) {
                found.push(mark(sample.time_s, "guard", verdict));
            }
        }
        for event in &sample.heard.events {
            found.push(mark(sample.time_s, "event", event));
        }
    }
    let left_out = found.len().saturating_sub(MOST_MARKS);
    found.truncate(MOST_MARKS);
    for fault in &scenario.faults {
        let node = fault
            .what
            .node()
            .map(|node| format!(": {node}"))
            .unwrap_or_default();
        let text = format!("Injected: {}{node}", fault.what.words());
        found.push(mark(fault.at_s, "fault", &text));
    }
    if let Some(time_s) = summary.landing_time_s {
        found.push(mark(time_s, "good", "Landed: level behind the last nose"));
    }
    if let Some(sample) = samples.iter().find(|sample| sample.truth.toppled) {
        found.push(mark(sample.time_s, "fault", "Toppled"));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    (found.into_iter().map(|(_, mark)| mark).collect(), left_out)
}

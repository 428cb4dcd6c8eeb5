//! Packs a run into the JSON data of the page.
//!
//! Samples become columns of integers, each with the value of one step. That takes about a quarter
//! of the size of rounded decimals.

use super::channels;
use super::path::{Bounds, Camera, GROUND_ONE, Path};
use crate::results::summary::{Summary, intervenes};
use crate::results::zmp::{Balance, Moment, PAPER_PERCENT, length};
use crate::robots::Kind;
use crate::robots::b2p2::plant::B2p2Parameters;
use crate::robots::b2p2::section::B2p2;
use crate::scenario::Scenario;
use crate::simulator::record::{Level, Sample};
use crate::world::truth::Sketch;
use serde_json::{Map, Value, json};
use tautrack::stability::support::NO_EDGE;

/// The guard's margin to one edge of the support; `None` if it knows none or that edge does not
/// exist.
fn edge(sample: &Sample, edge: usize) -> Option<f64> {
    let margin = sample.received.margins.map(|margins| margins[edge]);
    margin.filter(|margin| *margin < f64::from(NO_EDGE))
}

/// Maximum number of samples in the page. The page of a longer run shows every n-th sample, so that
/// a browser can still open it (`an_hour_makes_no_bigger_page_than_a_browser_can_bear`); `run.mcap`
/// has all samples.
const MOST_SAMPLES: usize = 6_000;
/// Maximum number of marks of interventions and bus events in the page. Further ones are only
/// counted.
const MOST_MARKS: usize = 300;

type Column = (&'static str, f64, fn(&Sample) -> Option<f64>);

/// The columns of every robot: name in the page, value of one step, source. Angles become degrees.
const COLUMNS: &[Column] = &[
    ("t", 1e-3, |s| Some(s.time_s)),
    ("pitch", 0.01, |s| Some(s.truth.pitch.to_degrees())),
    ("back", 1e-3, |s| s.truth.backward_margin),
    ("front", 1e-3, |s| s.truth.forward_margin),
    ("guardBack", 1e-3, |s| edge(s, 0)),
    ("guardFront", 1e-3, |s| edge(s, 1)),
    ("receivedPitch", 0.01, |s| {
        Some(s.received.pitch.to_degrees())
    }),
    ("odometry", 1e-4, |s| Some(s.received.odometry)),
    ("askedSpeed", 1e-3, |s| Some(s.received.asked_speed)),
    ("passedSpeed", 1e-3, |s| Some(s.received.passed_speed)),
    ("speed", 1e-3, |s| Some(s.truth.ground_speed)),
    ("busLoad", 0.1, |s| Some(s.received.bus_load * 100.0)),
];

/// The columns that only B2P2 has.
const B2P2_COLUMNS: &[Column] = &[
    ("theta", 0.01, |s| Some(s.truth.theta.to_degrees())),
    ("extension", 1e-4, |s| Some(s.truth.extension)),
    ("tension", 0.01, |s| Some(s.truth.tension_error * 1e3)),
    ("askedTheta", 0.01, |s| {
        Some(s.received.asked_theta.to_degrees())
    }),
    ("passedTheta", 0.01, |s| {
        Some(s.received.passed_theta.to_degrees())
    }),
    ("leftCurrent", 0.01, |s| {
        s.received.currents.first().copied()
    }),
    ("rightCurrent", 0.01, |s| {
        s.received.currents.get(1).copied()
    }),
    ("chassisCurrent", 0.01, |s| {
        s.received.currents.get(2).copied()
    }),
    ("screwCurrent", 0.01, |s| {
        s.received.currents.get(3).copied()
    }),
];

type BalanceColumn = (&'static str, f64, fn(&Moment) -> Option<f64>);

/// The columns of B2P2's Fig. 8, as in [`COLUMNS`]. Distances are measured from `P1`, axle 1.
const BALANCE_COLUMNS: &[BalanceColumn] = &[
    ("p1", 1e-3, |moment| Some(moment.axles[0])),
    ("p2", 1e-3, |moment| Some(moment.axles[1])),
    ("p3", 1e-3, |moment| Some(moment.axles[2])),
    ("cogAlong", 1e-4, |moment| Some(moment.cog)),
    ("zmpAlong", 1e-4, |moment| moment.zmp),
    ("zmpOff", 1e-5, Moment::difference),
    ("zmpOffSmoothed", 1e-5, |moment| moment.smoothed),
];

/// Packs all data that the page draws.
pub(super) fn pack(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> Value {
    let stride = samples.len().div_ceil(MOST_SAMPLES).max(1);
    let shown: Vec<&Sample> = samples.iter().step_by(stride).collect();
    let column = |name: &str, one: f64, values: Vec<Option<i64>>| {
        (name.to_owned(), json!({ "one": one, "values": values }))
    };
    let source = |(name, one, source): &Column| {
        let values = shown.iter().map(|sample| quantise(source(sample), *one));
        column(name, *one, values.collect())
    };
    let mut columns: Map<_, _> = COLUMNS.iter().map(source).collect();
    let kind = scenario.kind();
    // For another robot B2P2's nominal parameters fill these fields; its page shows none of them.
    let robot = scenario.robot.b2p2().cloned().unwrap_or_else(B2p2::nominal);
    let parameters = robot.parameters(scenario.friction);
    let plant = scenario.plant();
    let drawn = (kind != Kind::B2p2).then(|| plant.sketch());
    let path = Path::new(shown.clone());
    let side = side_view(&parameters, &path, &shown, drawn.as_ref());
    columns.extend(side.columns.iter().map(|(name, one, values)| {
        let values = values.iter().map(|value| quantise(Some(*value), *one));
        column(name, *one, values.collect())
    }));
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
        let nodes: Vec<_> = summary
            .nodes
            .iter()
            .map(|node| node.name.as_str())
            .collect();
        let drives = &nodes[..nodes.len().saturating_sub(1)];
        columns.extend(channels::columns(&shown, drives.len()).into_iter().map(
            |(name, one, values)| {
                let values = values.into_iter().map(|value| quantise(value, one));
                column(&name, one, values.collect())
            },
        ));
        let points = |(index, sample): (usize, &&Sample)| {
            let places = sample.truth.points.iter();
            flat(places.map(|place| path.project(index, *place)), 1e-3)
        };
        json!({
            "circles": sketch.circles,
            "lines": sketch.lines,
            "points": shown.iter().enumerate().map(points).collect::<Vec<_>>(),
            "plots": channels::plots(&shown, drives),
            "figures": channels::figures(summary),
            "note": kind.facts().plots_note,
            "origin": kind.facts().origin,
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
    // Finer steps for the other robots: the contacts of a small robot are close to each other.
    let contact_one = if drawn.is_some() { 1e-3 } else { 1e-2 };
    let contacts = |(index, sample): (usize, &&Sample)| {
        let places = sample.truth.contacts.iter();
        contacts(places.map(|place| path.project(index, *place)), contact_one)
    };
    let (marks, marks_left_out) = marks(scenario, summary, samples);
    let camera = &side.camera;
    json!({
        "about": scenario.about,
        "guardOn": scenario.guard,
        "friction": scenario.friction,
        "robot": robot,
        "l1": parameters.l1,
        "l2": parameters.l2,
        "ground": path.ground(plant.as_ref(), camera.wide()[0], side.sides),
        "groundOne": GROUND_ONE,
        "view": { "scale": camera.scale, "wide": camera.wide(), "narrow": camera.narrow() },
        "sketch": sketch,
        "summary": summary,
        "resolution": resolution(stride),
        "columns": columns,
        "areas": areas,
        "length": length(&parameters),
        "paperZmpPercent": PAPER_PERCENT,
        "contactOne": contact_one,
        "contacts": shown.iter().enumerate().map(contacts).collect::<Vec<_>>(),
        "guardState": changes(shown.iter().map(|sample| sample.received.guard_state.as_str())),
        "verdict": changes(shown.iter().map(|sample| sample.received.verdict.as_str())),
        "marks": marks,
        "marksLeftOut": marks_left_out,
    })
}

/// A sentence that says which samples the curves leave out; empty for a short run.
fn resolution(stride: usize) -> String {
    if stride > 1 {
        format!("Curves show one sample in {stride}; run.mcap has all of them.")
    } else {
        String::new()
    }
}

/// The robot in the plane of the side view.
struct SideView {
    /// Columns of the page.
    columns: Vec<(&'static str, f64, Vec<f64>)>,
    camera: Camera,
    /// Distance to the left (positive) and to the right (negative) of the centre of gravity at
    /// which the robot stands, m.
    sides: [f64; 2],
}

fn side_view(
    p: &B2p2Parameters,
    path: &Path,
    shown: &[&Sample],
    sketch: Option<&Sketch>,
) -> SideView {
    let places = |index: usize, sample: &Sample| -> Vec<[f64; 2]> {
        let truth = &sample.truth;
        if sketch.is_some() {
            let points = truth.points.iter();
            return points.map(|place| path.project(index, *place)).collect();
        }
        let along = |[x, z]: [f64; 2], length: f64, angle: f64| {
            [x + length * libm::cos(angle), z + length * libm::sin(angle)]
        };
        let axle_1 = path.project(index, truth.axle_1);
        let axle_2 = along(axle_1, p.l1, truth.pitch);
        let front = truth.pitch + truth.theta;
        let axle_3 = along(axle_2, p.l2 + truth.extension, front);
        vec![axle_1, axle_2, axle_3]
    };
    let radius = sketch.map_or(p.pulley_radius, |sketch| {
        let radii = sketch.circles.iter().map(|(_, radius)| *radius);
        radii.fold(0.0, f64::max)
    });
    let bounds = |(index, sample): (usize, &&Sample)| -> Bounds {
        let mut places = places(index, sample);
        places.push(path.project(index, sample.truth.cog));
        [0, 1].map(|axis: usize| {
            let values = || places.iter().map(|place| place[axis]);
            [
                values().fold(f64::INFINITY, f64::min) - radius,
                values().fold(f64::NEG_INFINITY, f64::max) + radius,
            ]
        })
    };
    let bounds: Vec<Bounds> = shown.iter().enumerate().map(bounds).collect();
    let camera = path.camera(&bounds);
    let project = |place: fn(&Sample) -> [f64; 3], axis: usize| -> Vec<f64> {
        let samples = shown.iter().enumerate();
        samples
            .map(|(index, sample)| path.project(index, place(sample))[axis])
            .collect()
    };
    let half = 0.5 * (p.width - p.belt_width);
    let sides = shown.first().filter(|_| sketch.is_some()).map(|sample| {
        let truth = &sample.truth;
        let (sine, cosine) = libm::sincos(truth.yaw);
        let to_left = |place: &[f64; 3]| {
            (place[1] - truth.cog[1]) * cosine - (place[0] - truth.cog[0]) * sine
        };
        let offsets = || truth.points.iter().map(to_left);
        [offsets().fold(0.0, f64::max), offsets().fold(0.0, f64::min)]
    });
    SideView {
        columns: vec![
            ("x", 1e-4, project(|sample| sample.truth.axle_1, 0)),
            ("z", 1e-4, project(|sample| sample.truth.axle_1, 1)),
            ("cogX", 1e-3, project(|sample| sample.truth.cog, 0)),
            ("cogZ", 1e-3, project(|sample| sample.truth.cog, 1)),
            ("viewX", 1e-3, camera.centres[0].clone()),
            ("viewZ", 1e-3, camera.centres[1].clone()),
        ],
        camera,
        sides: sides.unwrap_or([half, -half]),
    }
}

/// Converts a value to steps of `one`; `None` if it is absent or not finite.
fn quantise(value: Option<f64>, one: f64) -> Option<i64> {
    value
        .filter(|value| value.is_finite())
        .map(|value| (value / one).round() as i64)
}

/// Contacts in the side view, in steps of `one` (m). Left and right contacts that coincide there
/// become one.
fn contacts(places: impl Iterator<Item = [f64; 2]>, one: f64) -> Vec<i64> {
    let places = flat(places, one);
    let mut points: Vec<_> = places.chunks_exact(2).collect();
    points.sort_unstable();
    points.dedup();
    points.concat()
}

/// Coordinates of all places in one list, in steps of `one` (m).
fn flat(places: impl Iterator<Item = [f64; 2]>, one: f64) -> Vec<i64> {
    let steps = |metres: f64| (metres / one).round() as i64;
    places.flat_map(|place| place.map(steps)).collect()
}

/// Index and new text of every change in a series of texts.
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

/// Collects the marks of the time line, in order of time: interventions of the guard, events on the
/// bus, injected faults, landing, toppling. Also returns how many marks were left out. Injected
/// faults, landing and toppling are never left out.
fn marks(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> (Vec<Value>, usize) {
    let mark = |time_s: f64, kind: &str, text: &str| {
        (time_s, json!({ "t": time_s, "kind": kind, "text": text }))
    };
    let mut found = Vec::new();
    let mut verdict = "";
    for sample in samples {
        if sample.received.verdict != verdict {
            verdict = &sample.received.verdict;
            if intervenes(verdict) {
                found.push(mark(sample.time_s, "guard", verdict));
            }
        }
        // An injected fault gets its own mark below.
        for event in sample
            .received
            .events
            .iter()
            .filter(|event| !event.injected)
        {
            let kind = match event.level {
                Level::Info => "event",
                Level::Warning => "warning",
                Level::Error => "error",
            };
            found.push(mark(sample.time_s, kind, &event.text));
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

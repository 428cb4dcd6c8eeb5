//! Packs a run into the JSON data of the page.

use super::channels;
use super::columns::{BALANCE_CURVES, CURVES, Column};
use super::decimation::{Decimated, Span};
use super::marks::Mark;
use super::page::{Drawing, Page, Shown};
use super::path::{Bounds, Camera, GROUND_ONE, Pose, Section, camera, ground};
use crate::results::summary::Summary;
use crate::results::zmp::{Balance, PAPER_PERCENT};
use crate::scenario::Scenario;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// The data that the page draws.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Data<'a> {
    about: &'a str,
    guard_on: bool,
    friction: f64,
    own: Option<&'a Value>,
    note: &'static str,
    origin: &'static str,
    ground: Vec<Section>,
    ground_one: f64,
    view: Value,
    scene: String,
    points: Vec<&'a [i32]>,
    sketch: Option<DrawnSketch<'a>>,
    summary: &'a Summary,
    resolution: String,
    columns: BTreeMap<String, Column>,
    areas: Vec<(&'static str, f64, f64)>,
    length: Option<f64>,
    paper_zmp_percent: f64,
    contact_one: f64,
    contacts: Vec<&'a [i32]>,
    guard_state: Vec<(usize, &'a str)>,
    verdict: Vec<(usize, &'a str)>,
    marks: Vec<Mark>,
    marks_left_out: usize,
}

/// The sketch of a robot, with its plots.
#[derive(Serialize)]
struct DrawnSketch<'a> {
    circles: &'a [(usize, f64)],
    lines: &'a [Vec<usize>],
    plots: Vec<Value>,
    figures: Vec<Value>,
}

/// Packs all data that the page draws.
pub(super) fn pack<'a>(
    page: &'a mut Page,
    scenario: &'a Scenario,
    summary: &'a Summary,
) -> Data<'a> {
    let length = page.balance.as_ref().map(Balance::length_m);
    let areas = page.finish_balance();
    let page = &*page;
    let shown = page.shown.intervals();
    let plant = scenario.plant();
    let bounds: Vec<Bounds> = shown.iter().map(|shown| shown.bounds).collect();
    let poses: Vec<Pose> = shown.iter().map(|shown| shown.pose).collect();
    let period_s = shown
        .get(1)
        .map_or(f64::INFINITY, |second| second.time_s - shown[0].time_s);
    let camera = camera(&bounds, period_s);
    Data {
        about: &scenario.about,
        guard_on: scenario.guard,
        friction: scenario.friction,
        own: match &page.drawing {
            Drawing::Own(own) => Some(&own.data),
            Drawing::Sketch(_) => None,
        },
        note: scenario.kind().facts().plots_note,
        origin: scenario.kind().facts().origin,
        ground: ground(&poses, plant.as_ref(), camera.wide()[0], page.sides),
        ground_one: GROUND_ONE,
        view: json!({
            "scale": camera.scale, "wide": camera.wide(), "narrow": camera.narrow(),
        }),
        scene: page.pictures.pack(scenario, plant.as_ref()),
        points: shown.iter().map(|shown| &shown.points[..]).collect(),
        sketch: sketch(page, scenario, summary),
        summary,
        resolution: resolution(page.shown.length()),
        columns: columns(page, &camera),
        areas,
        length,
        paper_zmp_percent: PAPER_PERCENT,
        contact_one: page.contact_one,
        contacts: shown.iter().map(|shown| &shown.contacts[..]).collect(),
        guard_state: changes(shown.iter().map(|shown| &shown.guard_state[..])),
        verdict: changes(shown.iter().map(|shown| &shown.verdict[..])),
        marks: page.marks.all(scenario, summary),
        marks_left_out: page.marks.left_out,
    }
}

fn sketch<'a>(
    page: &'a Page,
    scenario: &'a Scenario,
    summary: &'a Summary,
) -> Option<DrawnSketch<'a>> {
    let Drawing::Sketch(sketch) = &page.drawing else {
        return None;
    };
    let nodes = scenario.nodes();
    let drives = nodes[..page.drives].iter().map(|node| node.name.as_str());
    let mut channels = page.channels.clone();
    channels.sort_unstable();
    Some(DrawnSketch {
        circles: &sketch.circles,
        lines: &sketch.lines,
        plots: channels::plots(channels.into_iter(), &drives.collect::<Vec<_>>()),
        figures: channels::figures(summary),
    })
}

/// All columns of the page by name.
fn columns(page: &Page, camera: &Camera) -> BTreeMap<String, Column> {
    let shown = page.shown.intervals();
    let length = page.shown.length();
    let plain = |name: &str, one: f64, value: fn(&Shown) -> f64| {
        (name.to_owned(), Column::plain(one, shown.iter().map(value)))
    };
    let mut columns = BTreeMap::from([
        plain("t", 1e-3, |shown| shown.time_s),
        plain("odometry", 1e-4, |shown| shown.odometry_m),
        plain("x", 1e-4, |shown| shown.axle_1[0]),
        plain("z", 1e-4, |shown| shown.axle_1[1]),
        plain("cogX", 1e-3, |shown| shown.cog[0]),
        plain("cogZ", 1e-3, |shown| shown.cog[1]),
    ]);
    for (name, centres) in ["viewX", "viewZ"].into_iter().zip(&camera.centres) {
        let column = Column::plain(1e-3, centres.iter().copied());
        columns.insert(name.to_owned(), column);
    }
    // An interval before the first occurrence of a channel does not have it.
    let absent = Span::new(None);
    let curve = |index: usize| -> Vec<Span> {
        let curves = shown.iter().map(|shown| shown.curves.get(index));
        curves.map(|span| *span.unwrap_or(&absent)).collect()
    };
    let own = match &page.drawing {
        Drawing::Own(own) => own.curves,
        Drawing::Sketch(_) => &[],
    };
    for (index, (name, one, _)) in CURVES.iter().chain(own).enumerate() {
        let column = Column::curve(*one, length, &curve(index));
        columns.insert((*name).to_owned(), column);
    }
    for drive in 0..page.drives {
        let spans = curve(CURVES.len() + drive);
        columns.extend([channels::current_column(drive, length, &spans)]);
    }
    for (index, name) in page.channels.iter().enumerate() {
        let spans = curve(CURVES.len() + page.drives + index);
        columns.insert((*name).to_owned(), channels::column(length, &spans));
    }
    if !page.moments.intervals().is_empty() {
        columns.extend(balance_columns(&page.moments));
    }
    columns
}

fn balance_columns(moments: &Decimated<Vec<Span>>) -> impl Iterator<Item = (String, Column)> {
    let curves = BALANCE_CURVES.iter().enumerate();
    curves.map(|(index, (name, one, _))| {
        let intervals = moments.intervals().iter();
        let spans: Vec<Span> = intervals.map(|spans| spans[index]).collect();
        let column = Column::curve(*one, moments.length(), &spans);
        ((*name).to_owned(), column)
    })
}

/// A sentence that says which samples the curves show; empty for a short run.
fn resolution(length: usize) -> String {
    if length > 1 {
        format!(
            "Curves show minimum and maximum of every {length} samples; the picture and the \
             numbers beside the curves show one sample in {length}. run.mcap has all of them."
        )
    } else {
        String::new()
    }
}

/// Index and new text of every change in a series of texts.
fn changes<'a>(texts: impl Iterator<Item = &'a str>) -> Vec<(usize, &'a str)> {
    let mut found: Vec<(usize, &str)> = Vec::new();
    for (index, text) in texts.enumerate() {
        if found.last().map(|(_, last)| *last) != Some(text) {
            found.push((index, text));
        }
    }
    found
}

//! `cargo demo --compare`: runs a scenario with the guard's filter on and off, and makes one page
//! that shows both runs.

use crate::live::{Drive, scene};
use crate::results::scene::pack::{packed, round};
use crate::results::scene::{SCRIPTS, ground, still};
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use crate::simulator::run::{Sink, Unwritten};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the file.
const FILE: &str = "compare.html";
/// Number of steps between two states that the page shows.
const EVERY: u64 = 40;
/// Number of steps for which a run goes on after the robot has toppled.
const AFTER_TOPPLING: u64 = 2_000;
/// Distance by which the ground extends beyond the robots' paths, m.
const AROUND: f64 = 2.5;
/// Distance of two lines of the ground, m.
const CELL: f64 = 0.1;

/// Runs the scenario twice and writes the page into a folder. Returns its path.
///
/// # Errors
/// A text for the user.
pub fn write(scenario: &Scenario, folder: &Path) -> Result<PathBuf, String> {
    let mut area = [[0.0_f64; 2]; 2];
    let mut runs = Vec::new();
    for guard in [true, false] {
        let mut description = scenario.description();
        description.guard = guard;
        description.expect.guard_intervenes = None;
        let scenario = Scenario::checked(description).map_err(|error| error.to_string())?;
        runs.push(run(&scenario, &mut area)?);
    }
    let drive = Drive::start(scenario, false)?;
    let area = area.map(|[from, to]| [from - AROUND, to + AROUND]);
    let data = json!({
        "still": still(scenario, drive.plant()),
        "ground": ground(drive.plant(), area, CELL),
        "runs": runs,
    });
    let data = packed(data.to_string().as_bytes());
    let [gl, robot] = SCRIPTS;
    let parts = [
        ("{{style}}", include_str!("compare.css")),
        ("{{data}}", &data),
        ("{{gl}}", gl),
        ("{{robot}}", robot),
        ("{{compare}}", include_str!("compare.js")),
        // A name may contain the mark of another part.
        ("{{title}}", &escaped(&scenario.name)),
    ];
    let page = include_str!("compare.html").to_owned();
    let page = parts
        .iter()
        .fold(page, |page, (place, text)| page.replace(place, text));
    let path = folder.join(FILE);
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&path, page))
        .map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(path)
}

/// Runs a scenario. Returns its states, and extends the area to the robot's path.
fn run(scenario: &Scenario, area: &mut [[f64; 2]; 2]) -> Result<Value, String> {
    let mut drive = Drive::start(scenario, false)?;
    let mut end = (scenario.duration_s * 1e3) as u64;
    let mut states = Vec::new();
    while drive.steps() < end {
        drive
            .step(&mut Nothing)
            .map_err(|error| error.to_string())?;
        let truth = drive.plant().truth();
        if truth.toppled || truth.came_off.is_some() {
            end = end.min(drive.steps() + AFTER_TOPPLING);
        }
        if drive.steps().is_multiple_of(EVERY) || drive.steps() == end {
            let place = drive.plant().truth().cog;
            for ([from, to], place) in area.iter_mut().zip(place) {
                (*from, *to) = (from.min(place), to.max(place));
            }
            let mut state = scene::state(&mut drive);
            round(&mut state);
            states.push(state);
        }
    }
    let truth = drive.plant().truth();
    let outcome = if truth.toppled {
        "toppled"
    } else {
        "did not topple"
    };
    Ok(json!({ "states": states, "hash": drive.hash(), "outcome": outcome }))
}

/// Keeps nothing.
struct Nothing;

impl Sink for Nothing {
    fn sample(&mut self, _: Sample) -> Result<(), Unwritten> {
        Ok(())
    }
}

/// Writes text for HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

//! The 3-D scene of the pages: its scripts, and what does not change during a run.

pub mod pack;

use crate::robots::Posture;
use crate::scenario::Scenario;
use crate::world::truth::Part;
use crate::world::{Plant, grid};
use serde_json::{Value, json};
use tautrack::settings::Setting;

/// Scripts of the scene, in the order in which a page needs them.
pub const SCRIPTS: [&str; 2] = [include_str!("gl.js"), include_str!("robot.js")];
/// Maximum number of cells of the ground along each axis.
const MOST_CELLS: f64 = 400.0;

/// What does not change during a run.
pub fn still(scenario: &Scenario, plant: &dyn Plant) -> Value {
    let facts = scenario.kind().facts();
    let part = |part: &Part| match *part {
        Part::Box { centre, size } => json!({ "box": size, "centre": centre }),
        Part::Wheel {
            centre,
            radius,
            width,
        } => json!({ "wheel": [radius, width], "centre": centre }),
    };
    let bodies = plant.bodies();
    let bodies = bodies.iter().map(
        |body| json!({ "name": body.name, "parts": body.parts.iter().map(part).collect::<Vec<_>>() }),
    );
    let nodes = scenario.nodes();
    let nodes = nodes.iter().map(
        |node| json!({ "name": node.name, "id": node.id, "role": node.role.name(), "motor": node.motor.is_some() }),
    );
    let posture = match scenario.robot.section().posture() {
        Posture::None => json!({ "kind": "none" }),
        Posture::ChassisAngle { travel } => {
            json!({ "kind": "chassis", "travel_deg": travel.map(f64::to_degrees) })
        }
        Posture::Clearance { first_m } => json!({ "kind": "clearance", "first_m": first_m }),
        Posture::Step => json!({ "kind": "step" }),
    };
    json!({
        "robot": scenario.kind().argument(),
        "robot_name": facts.name,
        "name": scenario.name,
        "about": scenario.about,
        "duration_s": scenario.duration_s,
        "guard": scenario.guard,
        "sketch": plant.sketch(),
        "bodies": bodies.collect::<Vec<_>>(),
        "nodes": nodes.collect::<Vec<_>>(),
        "posture": posture,
        "levels": levels(scenario),
        "extent": scenario.robot.section().extent(&scenario.terrain),
        "front_m": scenario.robot.section().front_m(),
        "description": **scenario,
    })
}

/// The guard's levels of a margin, m.
fn levels(scenario: &Scenario) -> Value {
    let nodes = scenario.nodes();
    let guard = nodes.last().map_or(&[][..], |guard| &guard.settings);
    let metres = |setting: Setting| {
        let given = guard.iter().rev().find(|(of, _)| *of == setting);
        let micrometres = given.map_or(setting.description().default, |(_, value)| *value);
        f64::from(micrometres) * 1e-6
    };
    json!({
        "caution": metres(Setting::CautionMargin),
        "stop": metres(Setting::StopMargin),
        "trip": metres(Setting::TripMargin),
    })
}

/// The ground in an area: lines of x and of y, and the height at each of their crossings.
pub fn ground(plant: &dyn Plant, area: [[f64; 2]; 2], cell: f64) -> Value {
    let [xs, ys] = &grid::lines(plant, area, cell, MOST_CELLS);
    let heights = xs
        .iter()
        .flat_map(|x| ys.iter().map(|y| plant.ground_height([*x, *y])));
    // A tenth of a millimetre is enough for a picture.
    let heights = heights.map(|height| (height * 1e4).round() * 1e-4);
    json!({ "x": xs, "y": ys, "z": heights.collect::<Vec<_>>() })
}

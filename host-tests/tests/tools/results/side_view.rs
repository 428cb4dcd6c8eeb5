//! Tests the report's side view: the robot is inside the picture and stands on the real ground.

use super::{SCENARIOS, carried, facts, scenario};
use serde_json::Value;
use tautrack_host_tests::results::report;
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::robots::crawler::plant::ground::Ground;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::world::terrain::Terrain;

/// The JSON data inside the page of a run.
fn page(scenario: &Scenario, samples: &[Sample]) -> Value {
    let summary = Summary::new(scenario, &facts(scenario), samples);
    let page = report::html(scenario, &summary, samples).unwrap();
    let begin = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").unwrap();
    serde_json::from_str(&page[begin..end]).unwrap()
}

fn column(page: &Value, name: &str) -> Vec<f64> {
    let column = &page["columns"][name];
    let one = column["one"].as_f64().unwrap();
    let values = column["values"].as_array().unwrap().iter();
    values.map(|value| value.as_f64().unwrap() * one).collect()
}

/// Converts numbers in steps of `one` to pairs.
fn pairs(values: &Value, one: f64) -> Vec<[f64; 2]> {
    let values: Vec<f64> = values
        .as_array()
        .unwrap()
        .iter()
        .map(|value| value.as_f64().unwrap() * one)
        .collect();
    values.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Distance of a place from the scenario's ground, computed from the terrain's own equations, m. A
/// point on the face of a step is on the ground.
fn off_ground(scenario: &Scenario, [x, y, z]: [f64; 3]) -> f64 {
    if scenario.kind() == Kind::Hylos {
        return (scenario.terrain.hillside().height([x, y]) - z).abs();
    }
    if scenario.kind() == Kind::Crawler {
        let ground = Ground::new(&scenario.terrain.profile());
        return ground.height([x, y, z].into()).0.abs();
    }
    let beyond = match scenario.terrain {
        Terrain::Stairs { width_m, .. } => y.abs() - 0.5 * width_m,
        _ => f64::NEG_INFINITY,
    };
    // Beside the stairs the ground is level; at their side both heights are on the ground.
    if beyond > 1e-3 {
        return z.abs();
    }
    let level = if beyond > -1e-3 {
        z.abs()
    } else {
        f64::INFINITY
    };
    let section = scenario.terrain.ground().section(x - 1.0, x + 1.0);
    let distance = |pair: &[[f64; 2]]| {
        let [dx, dz] = [0, 1].map(|axis| pair[1][axis] - pair[0][axis]);
        let share = ((x - pair[0][0]) * dx + (z - pair[0][1]) * dz) / (dx * dx + dz * dz);
        let share = share.clamp(0.0, 1.0);
        (x - pair[0][0] - share * dx).hypot(z - pair[0][1] - share * dz)
    };
    section.windows(2).map(distance).fold(level, f64::min)
}

#[test]
fn every_robot_is_inside_the_view_at_every_sample() {
    for name in SCENARIOS {
        let scenario = scenario(name);
        let page = page(&scenario, &carried(&scenario));
        let centres = [column(&page, "viewX"), column(&page, "viewZ")];
        let cogs = [column(&page, "cogX"), column(&page, "cogZ")];
        let axles = [column(&page, "x"), column(&page, "z")];
        let size: Vec<f64> = page["view"]["narrow"]
            .as_array()
            .unwrap()
            .iter()
            .map(|side| side.as_f64().unwrap())
            .collect();
        let wide: Vec<f64> = page["view"]["wide"]
            .as_array()
            .unwrap()
            .iter()
            .map(|side| side.as_f64().unwrap())
            .collect();
        assert!(wide[0] >= size[0] && wide[1] >= size[1], "{name}");
        for index in 0..centres[0].len() {
            let mut points = vec![
                [cogs[0][index], cogs[1][index]],
                [axles[0][index], axles[1][index]],
            ];
            if page["sketch"] != Value::Null {
                points.extend(pairs(&page["points"][index], 1e-3));
            }
            points.extend(pairs(
                &page["contacts"][index],
                page["contactOne"].as_f64().unwrap(),
            ));
            for point in points {
                for axis in [0, 1] {
                    let off = (point[axis] - centres[axis][index]).abs();
                    assert!(
                        off <= 0.5 * size[axis],
                        "{name}, sample {index}: {point:?} is not in the view"
                    );
                }
            }
        }
        // The robot drives around a circle with a radius of 2 m, so the view must have moved.
        assert!(centres[0].last().unwrap() - centres[0][0] > 2.0, "{name}");
    }
}

#[test]
fn the_ground_of_the_view_is_the_terrain_along_the_path() {
    for name in SCENARIOS {
        let scenario = scenario(name);
        let samples = carried(&scenario);
        let page = page(&scenario, &samples);
        let sections = page["ground"].as_array().unwrap();
        let one = page["groundOne"].as_f64().unwrap();
        let along = column(&page, "cogX");
        assert_eq!(sections[0]["from"], 0, "{name}");
        let mut checked = 0;
        for section in sections {
            let from = section["from"].as_u64().unwrap() as usize;
            let truth = &samples[from].truth;
            let (sine, cosine) = truth.yaw.sin_cos();
            for [place, height] in pairs(&section["middle"], one) {
                let went = place - along[from];
                let point = [
                    truth.cog[0] + went * cosine,
                    truth.cog[1] + went * sine,
                    height,
                ];
                let off = off_ground(&scenario, point);
                assert!(off < 3e-3, "{name}: {point:?} is {off} m off the ground");
                checked += 1;
            }
        }
        assert!(checked >= 2 * sections.len(), "{name}");
    }
}

#[test]
fn the_wheels_stand_on_the_ground_of_the_view() {
    for name in SCENARIOS {
        let scenario = scenario(name);
        let samples = carried(&scenario);
        let page = page(&scenario, &samples);
        let sections = page["ground"].as_array().unwrap();
        let one = page["groundOne"].as_f64().unwrap();
        let along = column(&page, "cogX");
        for (index, sample) in samples.iter().enumerate() {
            let section = sections
                .iter()
                .rfind(|section| section["from"].as_u64().unwrap() as usize <= index)
                .unwrap();
            let (sine, cosine) = sample.truth.yaw.sin_cos();
            for contact in &sample.truth.contacts {
                let [x, y] = [0, 1].map(|axis| contact[axis] - sample.truth.cog[axis]);
                let place = along[index] + x * cosine + y * sine;
                let left = y * cosine - x * sine;
                let line = match (section.get("left"), left) {
                    (Some(_), left) if left > 0.01 => &section["left"],
                    (Some(_), left) if left < -0.01 => &section["right"],
                    _ => &section["middle"],
                };
                let points = pairs(line, one);
                // The distance is to the nearest point of the line, because a contact may be on the
                // face of a step.
                let distance = |pair: &[[f64; 2]]| {
                    let [dx, dz] = [0, 1].map(|axis| pair[1][axis] - pair[0][axis]);
                    let [px, pz] = [place - pair[0][0], contact[2] - pair[0][1]];
                    let share = (px * dx + pz * dz) / (dx * dx + dz * dz).max(1e-12);
                    let share = share.clamp(0.0, 1.0);
                    (px - share * dx).hypot(pz - share * dz)
                };
                let drawn = points
                    .windows(2)
                    .map(distance)
                    .fold(f64::INFINITY, f64::min);
                // A line is used until the robot is 8 mm beside it or has turned by 0.02 rad; the
                // steepest ground has a slope of 0.9.
                assert!(
                    drawn < 0.03,
                    "{name}, sample {index}: {contact:?} is {drawn} m off the drawn ground"
                );
            }
        }
    }
}

#[test]
fn no_plot_has_more_than_eight_curves_and_every_drive_has_one() {
    for name in SCENARIOS {
        let scenario = scenario(name);
        let samples = carried(&scenario);
        let page = page(&scenario, &samples);
        let Some(plots) = page["sketch"]["plots"].as_array() else {
            continue; // B2P2's plots are in plots.js, with at most five curves.
        };
        let mut currents = Vec::new();
        for plot in plots {
            let curves = plot["curves"].as_array().unwrap();
            assert!((1..=8).contains(&curves.len()), "{name}: {plot}");
            let names = curves.iter().map(|curve| curve[1].as_str().unwrap());
            currents.extend(names.filter(|name| name.starts_with("current")));
        }
        currents.sort_unstable();
        currents.dedup();
        assert_eq!(currents.len(), facts(&scenario).nodes.len() - 1, "{name}");
    }
}

#[test]
fn play_is_above_the_figures_and_every_tick_has_a_text() {
    let scenario = scenario("flat");
    let summary = Summary::new(&scenario, &facts(&scenario), &[]);
    let page = report::html(&scenario, &summary, &[]).unwrap();
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(place("id=\"play\"") < place("id=\"figures\""));
    assert!(place("id=\"tick-text\" role=\"status\"") < place("id=\"figures\""));
    for text in [
        "tick.title = text",
        "tick.setAttribute(\"aria-label\", text)",
        "tick.onpointerenter = tick.onfocus = tell",
    ] {
        place(text);
    }
}

//! Tests the results of a run: run.mcap, the facts in the summary, the side view of the report,
//! and long runs.

mod facts;
mod long;
mod recording;
mod side_view;

use std::path::Path;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::facts::{NodeFacts, RunFacts};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::world::truth::Truth;

/// The default scenarios of the four robots.
const SCENARIOS: [&str; 4] = [
    "staircase",
    "crawler/slope",
    "hylos/loop",
    "rt-mover/step-10",
];

fn scenario(name: &str) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios")
        .join(name)
        .with_extension("toml");
    Scenario::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// The runner's facts about a run with all nodes of the scenario.
fn facts(scenario: &Scenario) -> RunFacts {
    let nodes = scenario.nodes();
    RunFacts {
        nodes: nodes
            .iter()
            .map(|node| NodeFacts {
                name: node.name,
                role: format!("{:?}", node.role),
                board: "host".into(),
                node_id: node.id,
                program_sha256: String::new(),
            })
            .collect(),
        ..RunFacts::default()
    }
}

/// Samples of a constructed path at 10 Hz: straight ahead, then around a circle to the left. The
/// plant's shape at power-up is moved along the path and put on the ground, with its contacts.
fn carried(scenario: &Scenario) -> Vec<Sample> {
    let plant = scenario.plant();
    let still = plant.truth();
    let radius = plant.sketch().circles.first().map_or(0.05, |wheel| wheel.1);
    let [x0, y0, z0] = still.cog;
    let below = plant.ground_height([x0, y0]);
    (0..400)
        .map(|index| {
            let time_s = 0.1 * f64::from(index);
            // Straight ahead for 15 s, then around a circle with a radius of 2 m.
            let (ahead, yaw) = if time_s < 15.0 {
                (0.1 * time_s, 0.0)
            } else {
                (1.5, 0.05 * (time_s - 15.0))
            };
            let (sine, cosine) = yaw.sin_cos();
            let place = [x0 + ahead + 2.0 * sine, y0 + 2.0 * (1.0 - cosine)];
            let up = plant.ground_height(place) - below;
            let carry = |point: [f64; 3]| {
                let [x, y] = [point[0] - x0, point[1] - y0];
                [
                    place[0] + x * cosine - y * sine,
                    place[1] + x * sine + y * cosine,
                    point[2] + up,
                ]
            };
            let wheels = if still.points.is_empty() {
                vec![still.axle_1]
            } else {
                still.points.clone()
            };
            // The contacts are directly below the lowest points of the robot.
            let least = wheels
                .iter()
                .fold(f64::INFINITY, |least, p| least.min(p[2]));
            let low = wheels.iter().filter(|p| p[2] < least + 0.5 * radius);
            let contacts = low.map(|point| {
                let [x, y, _] = carry(*point);
                [x, y, plant.ground_height([x, y])]
            });
            Sample {
                time_s,
                truth: Truth {
                    axle_1: carry(still.axle_1),
                    cog: carry([x0, y0, z0]),
                    yaw,
                    theta: still.theta,
                    extension: still.extension,
                    points: still.points.iter().map(|point| carry(*point)).collect(),
                    contacts: contacts.collect(),
                    channels: still.channels.clone(),
                    ..Truth::default()
                },
                bodies: plant.poses(),
                ..Sample::default()
            }
        })
        .collect()
}

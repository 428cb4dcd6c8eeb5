//! Tests run.mcap by reading it with the `mcap` package of Python.

use super::{SCENARIOS, carried, facts, scenario};
use crate::python;
use serde_json::Value;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::process::Command;
use tautrack::can::Frame;
use tautrack_host_tests::results::mcap::Recording;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::record::{BusFrame, DriveState, Event, Level, Sample};

/// A Python program that prints a JSON object with the metadata, and for every topic the name of
/// its schema and all messages with their times.
const READER: &str = r#"
import json, sys
from mcap.reader import make_reader

with open(sys.argv[1], "rb") as stream:
    reader = make_reader(stream, validate_crcs=True)
    summary = reader.get_summary()
    found = {
        "metadata": [[record.name, record.metadata] for record in reader.iter_metadata()],
        "counted": {summary.channels[number].topic: count
                    for number, count in summary.statistics.channel_message_counts.items()},
        "topics": {},
    }
    for schema, channel, message in reader.iter_messages():
        of_topic = found["topics"].setdefault(channel.topic, {"schema": schema.name, "messages": []})
        json.loads(schema.data)
        of_topic["messages"].append([message.log_time, json.loads(message.data)])
json.dump(found, sys.stdout)
"#;

/// A constructed path with states of drives, frames, and events of each level.
fn recorded(scenario: &Scenario) -> (Vec<Sample>, Vec<BusFrame>) {
    let mut samples = carried(scenario);
    let drives = facts(scenario).nodes.len() - 1;
    for (index, sample) in samples.iter_mut().enumerate() {
        // The first sample of a run is not at power-up.
        sample.time_s += 0.1;
        sample.drives = (0..drives)
            .map(|drive| {
                // The last drive loses its power.
                let alive = drive + 1 < drives || index < 200;
                alive.then_some(DriveState {
                    position_rad: index as f64 + 0.25 * drive as f64,
                    speed_radps: -0.5 * drive as f64,
                    torque_nm: 0.125 * index as f64,
                })
            })
            .collect();
    }
    for (index, level) in [(10, Level::Info), (20, Level::Warning), (30, Level::Error)] {
        samples[index].received.events.push(Event {
            level,
            injected: index == 20,
            text: format!("event {index}"),
        });
    }
    let frames = (0..500_u16)
        .map(|index| BusFrame {
            time_us: 1_000 * u64::from(index) + 1_000,
            sender: usize::from(index) % (drives + 2),
            frame: Frame::new(0x180 + index % 64, &index.to_le_bytes()).unwrap(),
        })
        .collect();
    (samples, frames)
}

/// Writes a recording and reads it with Python; `None` without Python.
fn read(scenario: &Scenario, name: &str) -> Option<(Vec<Sample>, Vec<BusFrame>, Value)> {
    let interpreter = python::python("python-mcap", &["mcap==1.2.2"])?;
    let (samples, frames) = recorded(scenario);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.mcap"));
    let out = BufWriter::new(File::create(&file).unwrap());
    let mut recording = Recording::new(scenario, out).unwrap();
    for frame in &frames {
        recording.frame(frame).unwrap();
    }
    for sample in &samples {
        recording.sample(sample).unwrap();
    }
    recording.finish().unwrap();
    let output = Command::new(interpreter)
        .args(["-c", READER])
        .arg(&file)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let found = serde_json::from_slice(&output.stdout).unwrap();
    Some((samples, frames, found))
}

fn messages<'a>(found: &'a Value, topic: &str, schema: &str) -> &'a Vec<Value> {
    let of_topic = &found["topics"][topic];
    assert_eq!(of_topic["schema"], schema, "{topic}");
    let messages = of_topic["messages"].as_array().unwrap();
    assert_eq!(found["counted"][topic], messages.len(), "{topic}");
    messages
}

#[test]
fn python_finds_scenario_seed_frames_drives_and_event_levels_of_every_robot() {
    for (number, name) in SCENARIOS.into_iter().enumerate() {
        let scenario = scenario(name);
        let Some((samples, frames, found)) = read(&scenario, &format!("recording-{number}")) else {
            return;
        };
        let [record, texts] = [0, 1].map(|i| &found["metadata"][0][i]);
        assert_eq!(record, "scenario");
        assert_eq!(texts["seed"], scenario.seed.to_string());
        let again = Scenario::parse(texts["toml"].as_str().unwrap(), "metadata").unwrap();
        assert_eq!(again.description(), scenario.description(), "{name}");

        let can = messages(&found, "/can", "tautrack.CanFrame");
        assert_eq!(can.len(), frames.len());
        let facts = facts(&scenario);
        for (message, sent) in can.iter().zip(&frames) {
            assert_eq!(message[0], sent.time_us * 1_000);
            assert_eq!(message[1]["id"], sent.frame.id());
            assert_eq!(message[1]["data"], serde_json::json!(sent.frame.data()));
            let sender = facts.nodes.get(sent.sender);
            let sender = sender.map_or("operator".into(), |node| node.name.to_string());
            assert_eq!(message[1]["sender"], sender);
        }

        let drives = messages(&found, "/drives", "tautrack.Drives");
        assert_eq!(drives.len(), samples.len());
        for (message, sample) in drives.iter().zip(&samples) {
            for (node, state) in facts.nodes.iter().zip(&sample.drives) {
                let found = &message[1][node.name.as_str()];
                match state {
                    Some(state) => {
                        assert_eq!(found["position_rad"], state.position_rad);
                        assert_eq!(found["speed_radps"], state.speed_radps);
                        assert_eq!(found["torque_nm"], state.torque_nm);
                    }
                    None => assert!(found.is_null()),
                }
            }
        }

        let events = messages(&found, "/events", "foxglove.Log");
        // Levels of Foxglove: 2 is information, 3 a warning, 4 an error.
        let levels: Vec<_> = events.iter().map(|event| &event[1]["level"]).collect();
        assert_eq!(levels, [2, 3, 4]);
        assert_eq!(events[1][1]["name"], "scenario");
        assert_eq!(
            messages(&found, "/truth", "tautrack.Truth").len(),
            samples.len()
        );
        assert_eq!(
            messages(&found, "/bus", "tautrack.Received").len(),
            samples.len()
        );
    }
}

fn vector(value: &Value) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| value[axis].as_f64().unwrap())
}

#[test]
fn the_scene_has_the_ground_and_moves_every_body() {
    for (number, name) in SCENARIOS.into_iter().enumerate() {
        let scenario = scenario(name);
        let Some((samples, _, found)) = read(&scenario, &format!("scene-{number}")) else {
            return;
        };
        let plant = scenario.plant();
        let shapes = plant.bodies();
        assert_eq!(shapes.len(), plant.poses().len(), "{name}");
        let scene = messages(&found, "/scene", "foxglove.SceneUpdate");
        let entities = scene[0][1]["entities"].as_array().unwrap();
        let triangles = &entities[0]["triangles"][0];
        assert_eq!(entities[0]["frame_id"], "world");
        let points: Vec<_> = triangles["points"]
            .as_array()
            .unwrap()
            .iter()
            .map(vector)
            .collect();
        for [x, y, z] in &points {
            // The rounded position of a corner may be on either side of a step's face.
            let sides = [-1e-4, 0.0, 1e-4];
            let off = |(dx, dy): (f64, f64)| (plant.ground_height([x + dx, y + dy]) - z).abs();
            let around = sides.iter().flat_map(|dx| sides.map(|dy| (*dx, dy)));
            let least = around.map(off).fold(f64::INFINITY, f64::min);
            assert!(least < 1e-3, "{name}: {x} {y} {z}");
        }
        for sample in &samples {
            let [x, y, _] = sample.truth.cog;
            let near = |place: &[f64; 3]| (place[0] - x).hypot(place[1] - y) < 0.3;
            assert!(points.iter().any(near), "{name}: no ground at {x} {y}");
        }
        let corners = triangles["indices"].as_array().unwrap();
        assert!(
            corners
                .iter()
                .all(|corner| (corner.as_u64().unwrap() as usize) < points.len())
        );

        let transforms = messages(&found, "/tf", "foxglove.FrameTransforms");
        assert!(transforms.len() * 4 >= samples.len(), "{name}");
        for shape in &shapes {
            let entity = entities
                .iter()
                .find(|entity| entity["frame_id"] == shape.name);
            let entity = entity.unwrap_or_else(|| panic!("{name}: no {}", shape.name));
            let drawn = ["cubes", "cylinders"].map(|kind| entity[kind].as_array().unwrap().len());
            assert_eq!(drawn[0] + drawn[1], shape.parts.len());
        }
        for (message, sample) in transforms.iter().zip(samples.iter().step_by(4)) {
            let moved = message[1]["transforms"].as_array().unwrap();
            assert_eq!(moved.len(), shapes.len(), "{name}");
            for ((transform, shape), pose) in moved.iter().zip(&shapes).zip(&sample.bodies) {
                assert_eq!(transform["child_frame_id"], shape.name);
                let place = vector(&transform["translation"]);
                for (drawn, true_place) in place.iter().zip(&pose.place) {
                    assert!((drawn - true_place).abs() < 1e-4, "{name}");
                }
            }
        }
    }
}

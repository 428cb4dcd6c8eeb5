//! Tests summary, recording and report page of a constructed climb.

use mcap::read::LinearReader;
use mcap::records::Record;
use std::collections::BTreeMap;
use std::path::Path;
use tautrack_host_tests::results::mcap::Recording;
use tautrack_host_tests::results::report;
use tautrack_host_tests::results::summary::{Largest, Summary};
use tautrack_host_tests::robots::NodeName;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::facts::{FaultFacts, NodeFacts, RunFacts};
use tautrack_host_tests::simulator::record::{Event, Level, Received, Sample};
use tautrack_host_tests::world::truth::Truth;

fn scenario(name: &str) -> Scenario {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenarios")
        .join(name);
    Scenario::load(&path).unwrap()
}

fn error(text: &str) -> Event {
    Event {
        level: Level::Error,
        injected: false,
        text: text.into(),
    }
}

fn smooth(x: f64, from: f64, to: f64) -> f64 {
    let s = ((x - from) / (to - from)).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// A constructed path of the robot up the stairs. It is not physics, but the contacts are on the
/// ground.
fn climb(scenario: &Scenario, seconds: u32) -> Vec<Sample> {
    let radius = scenario.robot.b2p2().unwrap().pulley_radius_m;
    let noses: Vec<[f64; 2]> = scenario
        .terrain
        .ground()
        .section(-1.0, 8.0)
        .windows(2)
        .filter(|pair| pair[1][1] > pair[0][1])
        .map(|pair| pair[1])
        .collect();
    let last = noses.last().map_or(9.0, |nose| nose[0]);
    let floor = |x: f64| {
        noses
            .iter()
            .filter(|nose| nose[0] <= x)
            .map(|nose| nose[1])
            .fold(0.0, f64::max)
    };
    (0..seconds * 100)
        .map(|index| {
            let time_s = f64::from(index + 1) / 100.0;
            let x = 0.13 * (time_s - 2.0).clamp(0.0, 24.0);
            let swing = (x * std::f64::consts::TAU / 0.28).sin() * 6.0 * smooth(x, 1.2, 1.5);
            let up = smooth(x, 0.95, 1.35) * (1.0 - smooth(x, last - 0.30, last - 0.22));
            let pitch = ((33.0 + swing) * up).to_radians();
            let theta = (45.0 * smooth(x, 0.02, 0.2) * (1.0 - smooth(x, 1.05, 1.3))
                - 30.0
                    * smooth(x, last - 0.45, last - 0.36)
                    * (1.0 - smooth(x, last - 0.22, last - 0.15)))
            .to_radians();
            let reach =
                (1.232_f64.powi(2) - 0.32_f64.powi(2)) / (2.0 * (1.232 + 0.32 * theta.cos()));
            let lift =
                |nose: &[f64; 2]| nose[1] - (nose[0] - x) * pitch.tan() + radius / pitch.cos();
            let under = noses
                .iter()
                .filter(|nose| nose[0] > x && nose[0] < x + 0.7 * pitch.cos());
            let z = under.clone().map(lift).fold(floor(x) + radius, f64::max);
            let contacts: Vec<[f64; 3]> = under
                .filter(|nose| z - lift(nose) < 0.01)
                .map(|nose| [nose[0], 0.2, nose[1]])
                .chain((z - floor(x) - radius < 0.01).then_some([x, 0.2, floor(x)]))
                .chain((pitch < 0.01).then_some([x + 0.32, -0.2, floor(x)]))
                .collect();
            let cog = [x + 0.26 * pitch.cos(), 0.0, z + 0.26 * pitch.sin()];
            let rear = contacts.iter().map(|point| point[0]).reduce(f64::min);
            let front = contacts.iter().map(|point| point[0]).reduce(f64::max);
            let noise = f64::from(index * 7919 % 1000) / 1000.0 - 0.5;
            let held = (11.0..11.8).contains(&time_s);
            let speed = if x > 0.0 && time_s < 26.0 { 0.13 } else { 0.0 };
            Sample {
                time_s,
                truth: Truth {
                    axle_1: [x, 0.0, z],
                    pitch,
                    theta,
                    extension: reach - 0.23,
                    tension_error: 0.0008 * noise + 0.0005 * swing.to_radians(),
                    cog,
                    ground_speed: speed,
                    backward_margin: rear.map(|rear| cog[0] - rear),
                    forward_margin: front.map(|front| front - cog[0]),
                    contacts,
                    ..Truth::default()
                },
                received: Received {
                    asked_speed: if time_s > 2.0 && time_s < 26.0 {
                        0.13
                    } else {
                        0.0
                    },
                    passed_speed: if held { 0.06 } else { speed },
                    asked_theta: theta,
                    passed_theta: theta,
                    odometry: x / pitch.cos().max(0.8),
                    pitch: pitch + 0.01 * noise,
                    margins: (time_s > 1.5).then_some([0.2 + 0.05 * noise, 0.3, 0.2, 0.2]),
                    guard_state: if time_s < 2.0 { "homing" } else { "armed" }.into(),
                    verdict: if held {
                        "scaled: backward margin"
                    } else {
                        "passed"
                    }
                    .into(),
                    currents: vec![
                        1.5 + noise + 2.0 * pitch,
                        1.4 - noise + 2.0 * pitch,
                        3.0 * theta,
                        0.4 + 0.2 * noise,
                    ],
                    bus_load: 0.30 + 0.02 * noise,
                    events: Vec::from_iter(
                        (index == 1400)
                            .then(|| error("screw: heartbeat of chassis_joint late </script>")),
                    ),
                    ..Received::default()
                },
                ..Sample::default()
            }
        })
        .collect()
}

fn facts() -> RunFacts {
    let node = |name, role: &str, node_id| NodeFacts {
        name,
        role: role.into(),
        board: "mps2".into(),
        node_id,
        program_sha256: "ab".repeat(32),
    };
    RunFacts {
        wall_s: 4.0,
        steps: 30_000,
        nodes: vec![
            node(NodeName::LEFT_TRACK, "axle", 1),
            node(NodeName::RIGHT_TRACK, "axle", 2),
            node(NodeName::CHASSIS_JOINT, "axle", 3),
            node(NodeName::SCREW, "screw", 4),
            node(NodeName::GUARD, "guard", 10),
        ],
        frames: 81_000,
        worst_latency_ms: 1.25,
        faults: vec![],
        state_hash: "0123456789abcdef".into(),
    }
}

#[test]
fn the_summary_of_a_good_climb_says_so() {
    let scenario = scenario("staircase.toml");
    let samples = climb(&scenario, 30);
    let summary = Summary::new(&scenario, &facts(), &samples);
    assert!(
        summary.landed && !summary.toppled && summary.stopped && summary.expectation_met,
        "{summary}"
    );
    assert!((summary.realtime_factor - 7.5).abs() < 1e-9);
    assert_eq!(
        (
            summary.guard.interventions,
            summary.guard.scaled,
            summary.guard.refused
        ),
        (1, 1, 0)
    );
    let last_nose = scenario.terrain.last_nose_m().unwrap();
    let landing = samples
        .iter()
        .find(|sample| (sample.time_s - summary.landing_time_s.unwrap()).abs() < 1e-9)
        .unwrap();
    assert!(landing.truth.cog[0] > last_nose && landing.truth.pitch < 0.0873);
    let text = summary.to_string();
    assert!(
        text.contains("expectation   met") && text.contains("landed at"),
        "{text}"
    );
    assert_eq!(serde_json::to_value(&summary).unwrap()["steps"], 30_000);
}

#[test]
fn the_belt_error_is_that_of_the_climb_alone_and_its_percentile_is_right() {
    let scenario = scenario("staircase.toml");
    let mut samples = climb(&scenario, 30);
    // A large slack before the climb and strain from the landing on, which must not count. In the
    // half second after the landing it is still open whether the robot has landed.
    let landing = Summary::new(&scenario, &facts(), &samples).landing_time_s;
    let landed = samples
        .iter()
        .position(|sample| Some(sample.time_s) == landing);
    samples[10].truth.tension_error = -0.5;
    for after in [0, 20, 49] {
        samples[landed.unwrap() + after].truth.tension_error = 0.5;
    }
    samples[2990].truth.tension_error = 0.5;
    let summary = Summary::new(&scenario, &facts(), &samples);
    let landing = summary.landing_time_s.unwrap();
    let begin = samples
        .iter()
        .find(|sample| sample.truth.pitch.to_degrees() > 8.0)
        .unwrap()
        .time_s;
    let climbing: Vec<f64> = samples
        .iter()
        .filter(|s| s.time_s >= begin && s.time_s < landing)
        .map(|s| s.truth.tension_error.abs())
        .collect();
    // Computed by counting instead of sorting: the smallest value that at least 99 % do not exceed.
    let at_most = |value: f64| climbing.iter().filter(|other| **other <= value).count() * 100;
    let expected = climbing
        .iter()
        .copied()
        .filter(|value| at_most(*value) >= climbing.len() * 99)
        .reduce(f64::min)
        .unwrap();
    assert_eq!(summary.tension_error_m.unwrap().p99, expected);
    assert_eq!(
        summary.tension_error_m.unwrap().max,
        climbing.iter().copied().fold(0.0, f64::max)
    );
}

/// The largest values of a series.
fn largest(values: impl Iterator<Item = f64>) -> Largest {
    let mut largest = Largest::default();
    values.for_each(|value| largest.add(value));
    largest
}

#[test]
fn percentiles_agree_with_counting() {
    for length in 1..=101_usize {
        let values: Vec<f64> = (0..length)
            .map(|index| ((index * index * 37) % 101 / 3) as f64)
            .collect();
        let largest = largest(values.iter().copied());
        for percent in 0..=100_usize {
            let enough = |value: f64| {
                values.iter().filter(|other| **other <= value).count() * 100 >= percent * length
            };
            let candidates = values.iter().copied().filter(|value| enough(*value));
            let expected = candidates.reduce(f64::min).unwrap();
            assert_eq!(
                largest.percentile(percent),
                expected,
                "{percent} % of {length}"
            );
        }
    }
    assert_eq!(Largest::default().percentile(99), 0.0);
}

#[test]
fn the_99th_percentile_is_exact_for_hours_of_samples_and_never_too_small() {
    // Numbers below a million, in an order that repeats none of them before all have occurred.
    let mixed = |count: u64| (0..count).map(|index| (index * 618_033 % 1_000_000) as f64);
    // Ten hours: 3.6 million samples are the million numbers three times, and 600 000 again.
    let count = 3_600_000;
    let mut sorted: Vec<f64> = mixed(count).collect();
    sorted.sort_by(f64::total_cmp);
    let exact = sorted[count as usize / 100 * 99 - 1];
    assert_eq!(largest(mixed(count)).percentile(99), exact);
    // A day: the value is one that fewer samples exceed.
    let day = largest(mixed(8_000_000));
    let found = day.percentile(99);
    assert!((989_999.0..=999_999.0).contains(&found), "{found}");
    assert_eq!(day.percentile(100), 999_999.0);
}

#[test]
fn every_unmet_expectation_is_a_sentence() {
    let staircase = scenario("staircase.toml");
    let mut samples = climb(&staircase, 12);
    samples.last_mut().unwrap().truth.toppled = true;
    for sample in &mut samples {
        sample.received.guard_state = "ready".to_owned();
    }
    let mut description = staircase.description();
    description.expect.guard_intervenes = Some(false);
    description.expect.stopped = Some(true);
    description.expect.tension_error_below_m = Some(1e-5);
    let scenario = description.check().unwrap();
    let summary = Summary::new(&scenario, &facts(), &samples);
    assert!(!summary.expectation_met);
    let text = summary.unmet.join("\n");
    for sentence in [
        "The robot was never armed; expected: was armed.",
        "The robot did not land; expected: landed.",
        "The robot toppled; expected: did not topple.",
        "The robot was moving at the end; expected: stood still at the end.",
        "The guard intervened 1 time; expected: none.",
        "The belt was off by 0.",
    ] {
        assert!(text.contains(sentence), "no {sentence:?} in\n{text}");
    }
    assert_eq!(summary.unmet.len(), 6, "{text}");
}

#[test]
fn a_fault_that_nobody_notices_in_time_is_unmet() {
    let scenario = scenario("node-dies-mid-climb.toml");
    let samples = climb(&scenario, 25);
    let unmet = |noticed: Option<f64>| {
        let fault = FaultFacts {
            time_s: 15.0,
            node: Some(NodeName::LEFT_TRACK),
            what: "node dead".into(),
            noticed_by: noticed.map(|_| "guard".into()),
            after_ms: noticed,
        };
        let summary = Summary::new(
            &scenario,
            &RunFacts {
                faults: vec![fault],
                ..facts()
            },
            &samples,
        );
        summary
            .unmet
            .into_iter()
            .filter(|sentence| sentence.starts_with("Fault"))
            .collect::<Vec<_>>()
    };
    assert_eq!(unmet(Some(150.0)), Vec::<String>::new());
    assert_eq!(
        unmet(Some(151.0)),
        ["Fault \"node dead: left_track\" was noticed after 151 ms; expected: 150 ms."]
    );
    assert_eq!(
        unmet(None),
        ["Fault \"node dead: left_track\" was never noticed; expected: within 150 ms."]
    );
}

#[test]
fn a_run_without_samples_has_a_summary_and_a_page() {
    let scenario = scenario("flat.toml");
    let summary = Summary::new(&scenario, &RunFacts::default(), &[]);
    assert!(!summary.stopped && !summary.expectation_met && summary.realtime_factor == 0.0);
    assert!(
        report::html(&scenario, &summary, &[])
            .unwrap()
            .contains("</html>")
    );
}

#[test]
fn the_log_holds_every_sample_and_event_and_says_what_its_fields_are() {
    let scenario = scenario("staircase.toml");
    let samples = climb(&scenario, 30);
    let mut bytes = Vec::new();
    let mut recording = Recording::new(&scenario, &mut bytes).unwrap();
    for sample in &samples {
        recording.sample(sample).unwrap();
    }
    recording.finish().unwrap();
    let mut schemas = BTreeMap::new();
    let mut topics = BTreeMap::new();
    let mut of_topic = BTreeMap::<String, Vec<(u64, serde_json::Value)>>::new();
    for record in LinearReader::new(&bytes).unwrap() {
        let Record::Chunk { data, .. } = record.unwrap() else {
            continue;
        };
        for record in LinearReader::sans_magic(&data) {
            match record.unwrap() {
                Record::Schema { header, data } => {
                    let schema: serde_json::Value = serde_json::from_slice(&data).unwrap();
                    schemas.insert(header.id, schema);
                }
                Record::Channel(channel) => {
                    topics.insert(channel.id, (channel.topic, channel.schema_id));
                }
                Record::Message { header, data } => {
                    let (topic, schema) = &topics[&header.channel_id];
                    let value: serde_json::Value = serde_json::from_slice(&data).unwrap();
                    if topic != "/drives" {
                        for name in value.as_object().unwrap().keys() {
                            assert!(
                                !schemas[schema]["properties"][name]["type"].is_null(),
                                "{name} is not in the schema of {topic}"
                            );
                        }
                    }
                    let messages = of_topic.entry(topic.clone()).or_default();
                    messages.push((header.log_time, value));
                }
                other => panic!("{other:?} in a chunk"),
            }
        }
    }
    assert_eq!(
        of_topic.keys().collect::<Vec<_>>(),
        ["/bus", "/drives", "/events", "/scene", "/tf", "/truth"]
    );
    assert_eq!(of_topic["/truth"].len(), samples.len());
    assert_eq!(of_topic["/bus"].len(), samples.len());
    assert_eq!(of_topic["/events"].len(), 1);
    let (time, truth) = &of_topic["/truth"][1499];
    assert_eq!(*time, 15_000_000_000);
    let pitch = samples[1499].truth.pitch;
    assert!((truth["pitch"].as_f64().unwrap() - pitch).abs() <= 5e-9 * pitch.abs());
    assert_eq!(
        of_topic["/events"][0].1["message"],
        samples[1400].received.events[0].text
    );
    assert_eq!(of_topic["/bus"][0].1["margins"], serde_json::Value::Null);
}

/// The JSON data inside the page.
pub fn embedded(page: &str) -> serde_json::Value {
    let begin = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    let end = begin + page[begin..].find("</script>").unwrap();
    serde_json::from_str(&page[begin..end]).unwrap()
}

#[test]
fn the_page_needs_nothing_but_itself_and_holds_the_data() {
    let scenario = scenario("staircase.toml");
    let samples = climb(&scenario, 30);
    let page = report::html(
        &scenario,
        &Summary::new(&scenario, &facts(), &samples),
        &samples,
    )
    .unwrap();
    if let Some(path) = std::env::var_os("TAUTRACK_SHOW_REPORT") {
        std::fs::write(path, &page).unwrap();
    }
    // The only address in the page is the name of the SVG namespace, which no browser loads.
    let addresses =
        page.matches("http").count() - page.matches("\"http://www.w3.org/2000/svg\"").count();
    assert_eq!(addresses, 0);
    for load in ["src=", "href=", "@import", "url(", "fetch(", "import("] {
        assert!(!page.contains(load), "the page contains {load:?}");
    }
    assert!(!page.contains("{{"), "a place was not filled");
    assert_eq!(
        page.matches("</script>").count(),
        2,
        "an event closed the script element"
    );
    let data = embedded(&page);
    let pitch = &data["columns"]["pitch"];
    let drawn = pitch["values"][1499].as_f64().unwrap() * pitch["one"].as_f64().unwrap();
    assert!((drawn - samples[1499].truth.pitch.to_degrees()).abs() <= 0.005 + 1e-9);
    assert_eq!(
        data["columns"]["guardBack"]["values"][0],
        serde_json::Value::Null
    );
    let texts: Vec<_> = data["marks"]
        .as_array()
        .unwrap()
        .iter()
        .map(|mark| mark["text"].as_str().unwrap())
        .collect();
    assert_eq!(
        texts,
        [
            "scaled: backward margin",
            "screw: heartbeat of chassis_joint late </script>",
            "Landed: level behind the last nose"
        ]
    );
    for said in [
        "This is a simulation.",
        "pulley radius",
        "battery",
        "No figure here was measured on a real one",
    ] {
        assert!(page.contains(said), "the page does not say {said:?}");
    }
}

#[test]
fn the_page_of_an_hour_has_a_megabyte() {
    let scenario = scenario("staircase.toml");
    let mut samples = climb(&scenario, 3600);
    for sample in &mut samples {
        sample.received.events = vec![error("guard: heartbeat of screw lost")];
    }
    let page = report::html(
        &scenario,
        &Summary::new(&scenario, &facts(), &samples),
        &samples,
    )
    .unwrap();
    assert!(page.len() < 1_200_000, "{} bytes", page.len());
    assert!(embedded(&page)["marksLeftOut"].as_u64().unwrap() > 300_000);
}

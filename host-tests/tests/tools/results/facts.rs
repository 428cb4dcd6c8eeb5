//! Tests that sentences and figures of summary, recording and page are true.

use super::{facts, scenario};
use std::path::{Path, PathBuf};
use tautrack::bus::pdo::{GuardPassed, GuardState, Payload, transmit};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack_host_tests::results::report;
use tautrack_host_tests::results::summary::Summary;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::facts::RunFacts;
use tautrack_host_tests::simulator::record::{Event, Level, Received, Sample};
use tautrack_host_tests::simulator::run::listener::Listener;
use tautrack_host_tests::world::truth::Truth;

const WHEELS: [&str; 4] = ["front_left", "front_right", "rear_left", "rear_right"];

/// Samples of RT-Mover, level and still behind the step, with its rear right wheel raised until
/// `down_s`.
fn on_three_wheels(down_s: f64) -> Vec<Sample> {
    let name = |wheel: usize, ending: &str| -> &'static str {
        Box::leak(format!("{}{ending}", WHEELS[wheel]).into_boxed_str())
    };
    let [loads, places] = ["_load_n", "_x_m"].map(|ending| [0, 1, 2, 3].map(|i| name(i, ending)));
    (0..800)
        .map(|index| {
            let time_s = 60.0 + 0.01 * f64::from(index);
            let mut truth = Truth {
                axle_1: [1.5, 0.0, 0.3],
                ..Truth::default()
            };
            for wheel in 0..4 {
                let load = if wheel == 3 && time_s < down_s {
                    0.0
                } else {
                    50.0
                };
                truth.channels.insert(loads[wheel], load);
                truth.channels.insert(places[wheel], 1.4);
            }
            Sample {
                time_s,
                truth,
                ..Sample::default()
            }
        })
        .collect()
}

#[test]
fn rt_mover_has_not_landed_while_a_wheel_carries_nothing() {
    let scenario = scenario("rt-mover/step-10");
    let summary = Summary::new(&scenario, &facts(&scenario), &on_three_wheels(65.0));
    let landing_s = summary.landing_time_s.unwrap();
    assert!((65.0..65.02).contains(&landing_s), "{landing_s}");
    let never = Summary::new(&scenario, &facts(&scenario), &on_three_wheels(1e9));
    assert!(!never.landed);
}

#[test]
fn a_robot_without_support_has_no_margin_instead_of_minus_one() {
    let scenario = scenario("rt-mover/step-10");
    let mut plant = scenario.plant();
    let margin = |truth: &Truth| truth.channels.get("support_margin_m").copied();
    // At power-up no wheel carries load yet.
    assert_eq!(margin(plant.truth()), None);
    let mut least = f64::INFINITY;
    for _ in 0..1_000 {
        plant.step(&[None; 9]);
        if let Some(margin) = margin(plant.truth()) {
            least = least.min(margin);
        }
    }
    // The wheels are at most 0.5 m apart, so the centre of gravity is never farther than that from
    // the wheels that stand.
    assert!((-0.5..0.3).contains(&least), "{least}");
    assert!(margin(plant.truth()).unwrap() > 0.05);
}

#[test]
fn posture_has_the_name_and_unit_of_its_robot() {
    for (kind, name, asked) in [
        (
            Kind::B2p2,
            "asked_chassis_rad",
            380.0 / 65_536.0 * std::f64::consts::TAU,
        ),
        (Kind::Hylos, "asked_clearance_m", 0.38),
        (Kind::RtMover, "asked_step_m", 0.38),
    ] {
        let scenario = match kind {
            Kind::B2p2 => scenario("flat"),
            Kind::Hylos => scenario("hylos/loop"),
            _ => scenario("rt-mover/step-10"),
        };
        let nodes = scenario.nodes();
        let guard = nodes.last().unwrap().id;
        let mut listener = Listener::new(&nodes, &scenario.robot);
        let passed = GuardPassed {
            asked_posture: 380,
            ..GuardPassed::default()
        };
        listener.receive(&passed.frame(transmit(4), guard), 1_000);
        let json = serde_json::to_value(listener.take()).unwrap();
        let found = json["posture"][name].as_f64().unwrap();
        assert!((found - asked).abs() < 1e-12, "{json}");
        assert!(json.get("asked_theta").is_none(), "{json}");
    }
}

/// An emergency frame of a node.
fn emergency(node: u8, fault: Fault) -> Frame {
    let [low, high] = fault.description().code.to_le_bytes();
    Frame::new(0x80 + u16::from(node), &[low, high, 1, 0, 0, 0, 0, 0]).unwrap()
}

#[test]
fn a_fault_is_listed_once_with_its_node() {
    let scenario = scenario("flat");
    let nodes = scenario.nodes();
    let (guard, screw) = (nodes[4].id, nodes[3].id);
    let named = |fault: Fault| {
        let state = GuardState {
            fault_node: screw,
            fault_code: fault.description().code,
            ..GuardState::default()
        };
        state.frame(transmit(2), guard)
    };
    let texts = |frames: &[Frame]| {
        let mut listener = Listener::new(&nodes, &scenario.robot);
        let mut texts = Vec::new();
        for (index, frame) in frames.iter().enumerate() {
            listener.receive(frame, 1_000 * index as u64);
            texts.extend(listener.take().events);
        }
        for _ in 0..20 {
            texts.extend(listener.take().events);
        }
        let faults = texts
            .into_iter()
            .filter(|event| event.level == Level::Error);
        faults.map(|event| event.text).collect::<Vec<_>>()
    };
    let lost = "guard: node lost (0xff02) of screw";
    // The guard's emergency frame and its state name the same fault, in either order.
    let frames = [emergency(guard, Fault::NodeLost), named(Fault::NodeLost)];
    assert_eq!(texts(&frames), [lost]);
    assert_eq!(texts(&[frames[1], frames[0]]), [lost]);
    // The node's own emergency frame and the guard's state name the same fault.
    let frames = [emergency(screw, Fault::NodeLost), named(Fault::NodeLost)];
    assert_eq!(texts(&frames), ["screw: node lost (0xff02)"]);
    // A fault of the guard that names no node is also listed.
    assert_eq!(
        texts(&[emergency(guard, Fault::NodeLost)]),
        ["guard: node lost (0xff02)"]
    );
    // A second loss after the end of the first one is a second line.
    let over = GuardState::default().frame(transmit(2), guard);
    let again = [named(Fault::NodeLost), over, named(Fault::NodeLost)];
    assert_eq!(texts(&again), [lost, lost]);
}

#[test]
fn an_injected_fault_has_one_mark_in_the_page() {
    let scenario = scenario("node-dies-mid-climb");
    let mut samples = vec![Sample::default(); 2_000];
    for (index, sample) in samples.iter_mut().enumerate() {
        sample.time_s = 0.01 * index as f64;
    }
    samples[1_400].received.events.push(Event {
        level: Level::Warning,
        injected: true,
        text: "fault begins: left_track: node dead".into(),
    });
    let summary = Summary::new(&scenario, &facts(&scenario), &samples);
    let page = report::html(&scenario, &summary, &samples).unwrap();
    let marks = &page[page.find("\"marks\":").unwrap()..page.find("\"marksLeftOut\"").unwrap()];
    assert_eq!(
        marks.matches("node dead").count(),
        1,
        "the fault is listed twice: {marks}"
    );
}

fn held(seconds: u32, verdicts: &[&str]) -> Vec<Sample> {
    (0..100 * seconds)
        .map(|index| {
            let verdict = verdicts[index as usize % verdicts.len()];
            Sample {
                time_s: 0.01 * f64::from(index),
                received: Received {
                    verdict: verdict.into(),
                    ..Received::default()
                },
                ..Sample::default()
            }
        })
        .collect()
}

#[test]
fn one_is_not_a_plural() {
    let scenario = scenario("flat");
    let summary = |samples: &[Sample]| {
        let mut description = scenario.description();
        description.expect.guard_intervenes = Some(false);
        let scenario = description.check().unwrap();
        Summary::new(&scenario, &RunFacts::default(), samples).to_string()
    };
    let mut samples = held(1, &["passed"]);
    samples[50].received.verdict = "scaled: backward margin".into();
    let once = summary(&samples);
    assert!(once.contains("1 intervention,"), "{once}");
    assert!(once.contains("The guard intervened 1 time;"), "{once}");
    let often = summary(&held(1, &["passed", "scaled: backward margin"]));
    assert!(often.contains("50 interventions,"), "{often}");
}

#[test]
fn a_long_run_says_in_words_which_samples_its_curves_show() {
    let scenario = scenario("flat");
    let samples = held(130, &["passed"]);
    let summary = Summary::new(&scenario, &RunFacts::default(), &samples);
    let page = report::html(&scenario, &summary, &samples).unwrap();
    assert!(page.contains("Curves show minimum and maximum of every 8 samples;"));
    assert!(!page.contains("th sample"), "every 2th, every 3th");
}

#[test]
fn a_negative_margin_without_an_intervention_is_explained() {
    let mut description = scenario("staircase").description();
    let mut samples = held(2, &["passed"]);
    for sample in &mut samples {
        sample.received.guard_state = "armed".into();
        sample.received.margins = Some([0.042, 0.3, 0.2, 0.2]);
        sample.truth.backward_margin = Some(0.1);
    }
    samples[100].truth.backward_margin = Some(-0.012);
    let notes = |description: &tautrack_host_tests::scenario::Description, samples: &[Sample]| {
        let scenario = description.clone().check().unwrap();
        let summary = Summary::new(&scenario, &RunFacts::default(), samples);
        let page = report::html(&scenario, &summary, samples).unwrap();
        for note in &summary.notes {
            assert!(summary.to_string().contains(note) && page.contains(note));
        }
        summary.notes.join("\n")
    };
    let on = notes(&description, &samples);
    assert!(
        on.contains("-0.012 m") && on.contains("at least 0.042 m"),
        "{on}"
    );
    description.guard = false;
    let off = notes(&description, &samples);
    assert!(off.contains("filter is switched off"), "{off}");
    samples[100].truth.backward_margin = Some(0.02);
    assert_eq!(notes(&description, &samples), "");
}

/// All scenario files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| {
            if path.is_dir() {
                files(&path)
            } else {
                vec![path]
            }
        })
        .collect()
}

#[test]
fn no_scenario_says_what_the_guard_does_for_a_guard_that_may_be_switched_off() {
    let files = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios"));
    assert!(files.len() > 40);
    for file in files {
        let about = Scenario::load(&file).unwrap().about.to_lowercase();
        let about = about.replace("without the guard", "");
        for deed in ["holds", "keeps", "stops", "refuses", "limits", "saves"] {
            let said = about.contains(&format!("the guard {deed}"));
            assert!(!said, "{}: {about}", file.display());
        }
    }
}

//! Tests of a run that somebody drives: it is that of `cargo demo`, it can be repeated, and the
//! guard keeps visitors from toppling a robot.

use crate::parallel;
use crate::unchanged::complete;
use serde_json::{Value, json};
use std::fs;
use tautrack_host_tests::live::Session;
use tautrack_host_tests::programs::Programs;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::Scenario;
use tautrack_host_tests::simulator::run::{Options, run};
use tautrack_host_tests::tools::suite::draw::generator::Random;

fn text(file: &str) -> String {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    fs::read_to_string(root.join("host-tests/scenarios").join(file)).expect("a scenario")
}

/// The page's side of a session.
struct Page(Session);

impl Page {
    /// Starts a run of a shipped scenario.
    fn start(file: &str, changes: &Value, person: bool) -> Self {
        let mut page = Self(Session::default());
        page.ask(
            &json!({ "start": { "scenario": text(file), "changes": changes, "person": person } }),
        );
        page
    }

    fn ask(&mut self, request: &Value) -> Value {
        let answer = self.answer(request);
        assert!(answer.get("error").is_none(), "{request}: {answer}");
        answer
    }

    fn answer(&mut self, request: &Value) -> Value {
        let answer = self.0.answer(request.to_string().as_bytes());
        serde_json::from_slice(&answer).expect("JSON")
    }

    fn advance(&mut self, steps: u64) -> Value {
        self.ask(&json!({ "advance": steps }))
    }

    /// Arms the robot. Returns the first state in which it is armed; `None` if the guard refuses.
    fn tries_to_arm(&mut self) -> Option<Value> {
        self.ask(&json!({ "ask": "arm" }));
        let mut states = (0..120).map(|_| self.advance(100));
        states.find(|state| state["sample"]["received"]["guard_state"] == "armed")
    }

    fn arm(&mut self) -> Value {
        let armed = self.tries_to_arm();
        armed.unwrap_or_else(|| panic!("it is not armed: {}", self.advance(1)))
    }

    /// Saves the run. Returns scenario and hash.
    fn save(&mut self) -> (String, String) {
        let saved = self.ask(&json!("save"));
        let part = |key: &str| saved[key].as_str().expect(key).to_owned();
        (part("scenario"), part("hash"))
    }

    fn assert_repeats(&mut self, name: &str) {
        let (scenario, hash) = self.save();
        assert_eq!(hash_of(&scenario), hash, "{name}:\n{scenario}");
    }
}

/// Hash of the run of this scenario, as `cargo demo` computes it.
fn hash_of(text: &str) -> String {
    let scenario = Scenario::parse(text, "saved").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let programs = Programs::in_process(scenario.kind().facts().guard_program);
    let outcome = run(&scenario, &programs, Options::default());
    outcome
        .unwrap_or_else(|error| panic!("{error}"))
        .facts
        .state_hash
}

#[test]
fn the_page_plays_a_scenario_to_the_hash_of_the_demo() {
    let changes = json!({ "duration_s": 6.0, "expect": null });
    let mut page = Page::start("flat.toml", &changes, false);
    let end = page.advance(10_000);
    assert_eq!(end["ended"], true);
    let scenario = Scenario::parse(&text("flat.toml"), "flat").expect("it is shipped");
    let mut description = scenario.description();
    description.duration_s = 6.0;
    let scenario = description
        .check()
        .unwrap_or_else(|problem| panic!("{problem}"));
    let programs = Programs::in_process(Kind::B2p2.facts().guard_program);
    let outcome =
        run(&scenario, &programs, Options::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(page.save().1, outcome.facts.state_hash);
}

#[test]
fn a_driven_run_is_repeated_by_the_scenario_that_was_saved() {
    let payload = json!({ "mass_kg": 0.5, "place_m": [0.1, 0.0, 0.05], "declared": true });
    let changes = json!({ "robot": { "b2p2": { "payload": payload } } });
    let mut page = Page::start("staircase.toml", &changes, true);
    page.arm();
    let drive = |speed: f64, chassis: f64| json!({ "command": { "speed_mps": speed, "chassis_deg": chassis, "yaw_rate_deg_s": 3.3, "released": speed < 0.0 } });
    let mut armed = 0;
    for (index, steps) in [7, 340, 13, 501, 1, 260, 90, 333].into_iter().enumerate() {
        page.ask(&drive(0.15 - 0.05 * index as f64, 9.7 * index as f64));
        if index == 3 {
            page.ask(&json!({ "ask": "stop" }));
        }
        if index == 4 {
            page.ask(&json!({ "ask": "arm" }));
        }
        let state = page.advance(steps);
        armed += u32::from(state["sample"]["received"]["guard_state"] == "armed");
    }
    assert_eq!(armed, 8);
    page.assert_repeats("driven");
}

#[test]
fn faults_and_frames_of_the_visitor_are_repeated() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.arm();
    page.ask(&json!({ "command": { "speed_mps": 0.1 } }));
    page.advance(300);
    // Reads the identity of node 2.
    page.ask(&json!({ "listen": true }));
    page.ask(&json!({ "send": { "id": 0x602, "data": [0x40, 0x18, 0x10, 1, 0, 0, 0, 0] } }));
    let frames = page.ask(&json!({ "bus": 20 }));
    let answers = frames.as_array().expect("frames");
    assert!(answers.iter().any(|frame| frame[2] == 0x582), "{answers:?}");
    page.ask(&json!({ "break": { "encoder_frozen": "left_track" } }));
    page.advance(17);
    page.ask(&json!({ "mend": { "encoder_frozen": "left_track" } }));
    page.advance(100);
    page.ask(&json!({ "break": { "node_dead": "screw" } }));
    let state = page.advance(400);
    let dead: Vec<_> = state["powered"].as_array().expect("nodes").iter().collect();
    assert_eq!(
        dead.iter().filter(|power| **power == false).count(),
        1,
        "{dead:?}"
    );
    assert_eq!(state["sample"]["received"]["guard_state"], "held");
    page.ask(&json!({ "break": { "restart": "screw" } }));
    page.advance(500);
    page.assert_repeats("broken");
}

/// Saves a run at several moments before what its scenario holds for later.
#[test]
fn a_saved_run_leaves_out_what_was_not_due() {
    let load =
        json!({ "mass_kg": 0.5, "place_m": [0.0, 0.0, 0.1], "from_s": 4.0, "declared": true });
    let changes = json!({
        "operator": { "from_power_up": true, "speed_mps": 0.0 },
        "robot": { "b2p2": { "payload": load } },
        "fault": [
            {
                "what": { "encoder_frozen": "left_track" },
                "at_s": 0.4, "until_s": 9.0, "notice_within_ms": 60_000.0
            },
            { "what": { "node_dead": "screw" }, "at_s": 9.0 },
        ],
        "frame": [
            { "at_ms": 200, "id": 0x602, "data": [0x40, 0x18, 0x10, 1, 0, 0, 0, 0] },
            { "at_ms": 9_000, "id": 0x602, "data": [0x40, 0x18, 0x10, 1, 0, 0, 0, 0] },
        ],
        "hand": [
            { "at_s": 0.5, "within_s": 1.0, "lift_m": 0.2 },
            { "at_s": 2.5, "within_s": 1.0, "lift_m": 0.1 },
            { "at_s": 9.0, "within_s": 1.0 },
        ],
        "expect": { "toppled": true },
    });
    let mut page = Page::start("flat.toml", &changes, true);
    page.ask(&json!({ "listen": true }));
    for steps in [300, 600, 1_000, 1_000] {
        // The answer to a frame does not wait for the scenario's later frames.
        page.ask(&json!({ "send": { "id": 0x602, "data": [0x40, 0x18, 0x10, 1, 0, 0, 0, 0] } }));
        let frames = page.ask(&json!({ "bus": steps }));
        let frames = frames.as_array().expect("frames");
        assert!(frames.iter().any(|frame| frame[2] == 0x582), "{steps}");
        page.assert_repeats(&format!("after {steps} steps more"));
    }
    let mut page = Page::start("staircase.toml", &Value::Null, false);
    page.advance(3_000);
    page.assert_repeats("by the scenario's operator");
    let mut page = Page::start("hylos/loop.toml", &Value::Null, false);
    page.advance(3_000);
    page.assert_repeats("by an operator with events");
}

#[test]
fn a_run_that_is_too_short_for_a_scenario_is_not_saved() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.advance(50);
    let answer = page.answer(&json!("save"));
    let error = answer["error"].as_str().expect("an error");
    assert!(error.contains("duration_s"), "{error}");
    page.advance(50);
    // A fault of a run that has ended begins after its end.
    page.ask(&json!({ "break": { "node_dead": "screw" } }));
    page.assert_repeats("short");
}

#[test]
fn after_an_emergency_stop_a_reset_and_a_request_to_arm_let_the_visitor_go_on() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.arm();
    page.ask(&json!({ "command": { "speed_mps": 0.1 } }));
    page.advance(500);
    page.ask(&json!({ "ask": "emergency_stop" }));
    let state = page.advance(300);
    let verdict = &state["sample"]["received"]["verdict"];
    assert_eq!(verdict, "refused: emergency stop", "{state}");
    let speed = state["sample"]["truth"]["ground_speed"].as_f64();
    assert!(speed.is_some_and(|speed| speed.abs() < 0.01), "{state}");
    // One right after the other.
    page.ask(&json!({ "ask": "reset" }));
    page.arm();
    let state = page.advance(2_000);
    let speed = state["sample"]["received"]["passed_speed"].as_f64();
    assert!(speed.is_some_and(|speed| speed > 0.05), "{state}");
    page.assert_repeats("stopped");
}

#[test]
fn an_emergency_stop_is_sent_before_the_reset_that_follows_it() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.arm();
    page.ask(&json!({ "command": { "speed_mps": 0.1 } }));
    page.advance(500);
    page.ask(&json!({ "ask": "emergency_stop" }));
    page.ask(&json!({ "ask": "reset" }));
    let state = page.advance(20);
    assert_eq!(state["requested"], "emergency_stop");
    let state = page.advance(20);
    assert_eq!(state["requested"], "reset");
    page.assert_repeats("stopped");
}

#[test]
fn a_second_reset_counts_after_the_fault_has_ended() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.arm();
    page.ask(&json!({ "break": { "bus_cut": "screw" } }));
    page.advance(500);
    page.ask(&json!({ "ask": "reset" }));
    page.advance(500);
    page.ask(&json!({ "mend": { "bus_cut": "screw" } }));
    let state = page.advance(2_000);
    assert_eq!(state["sample"]["received"]["guard_state"], "held");
    page.ask(&json!({ "ask": "reset" }));
    page.advance(2_000);
    page.arm();
    page.assert_repeats("reset again");
}

#[test]
fn a_run_ends_before_the_robot_drives_off_the_ground() {
    let mut page = Page::start("hylos/loop.toml", &Value::Null, true);
    page.arm();
    page.ask(&json!({ "command": { "speed_mps": 0.3, "clearance_m": 0.29 } }));
    let mut ends = (0..40).map(|_| page.advance(1_000));
    let end = ends.find(|state| state["ended"] == true);
    let truth = &end.expect("the ground ends")["sample"]["truth"];
    assert_eq!(truth["toppled"], false, "{truth}");
    page.assert_repeats("edge");
}

#[test]
fn a_request_that_cannot_be_carried_out_is_an_error_and_changes_nothing() {
    let mut page = Page::start("flat.toml", &Value::Null, true);
    page.advance(50);
    for request in [
        json!({ "nonsense": 1 }),
        json!({ "break": { "node_dead": "nobody" } }),
        json!({ "break": { "encoder_frozen": "guard" } }),
        json!({ "send": { "id": 0x900, "data": [] } }),
        json!({ "start": { "scenario": "nonsense", "person": true } }),
    ] {
        let answer = page.answer(&request);
        assert!(answer["error"].is_string(), "{request}: {answer}");
    }
    page.command_of_any_size();
    page.assert_repeats("refused");
}

impl Page {
    /// Commands that are out of every bound are limited to those of a scenario.
    fn command_of_any_size(&mut self) {
        for command in [1e9, -1e9] {
            let command =
                json!({ "speed_mps": command, "yaw_rate_deg_s": command, "chassis_deg": command });
            self.ask(&json!({ "command": command }));
            self.advance(40);
        }
    }
}

/// The page asks for shapes, ground and forces of every robot.
#[test]
fn every_robot_has_a_scene() {
    for file in [
        "flat.toml",
        "crawler/arc.toml",
        "hylos/loop.toml",
        "rt-mover/step-10.toml",
    ] {
        let mut page = Page(Session::default());
        let still = page.ask(&json!({ "start": { "scenario": text(file), "person": true } }));
        let state = page.advance(200);
        let weight: f64 = state["forces"]
            .as_array()
            .expect("forces")
            .iter()
            .map(|force| force[1][2].as_f64().unwrap_or(0.0))
            .sum();
        assert!(weight > 20.0, "{file}: {weight} N");
        let bodies = still["bodies"].as_array().expect("shapes").len();
        assert_eq!(
            state["sample"]["bodies"].as_array().map(Vec::len),
            Some(bodies),
            "{file}"
        );
        let ground =
            page.ask(&json!({ "ground": { "area": [[-1.0, 1.0], [-1.0, 1.0]], "cell": 0.5 } }));
        let count = |key: &str| ground[key].as_array().map_or(0, Vec::len);
        assert_eq!(count("z"), count("x") * count("y"), "{file}");
    }
}

/// Grounds on which visitors drive, with the robot's section and the largest payload, kg.
const GROUNDS: [(&str, &str, f64); 8] = [
    ("staircase.toml", "b2p2", 1.0),
    ("flat.toml", "b2p2", 2.0),
    ("legitimate/ramp-25.toml", "b2p2", 1.0),
    ("hazards/curb-20-cm-front-up.toml", "b2p2", 1.0),
    ("crawler/slope.toml", "crawler", 0.3),
    ("crawler/arc.toml", "crawler", 0.5),
    ("rt-mover/step-10.toml", "rt_mover", 3.0),
    ("hylos/loop.toml", "", 0.0),
];

/// Lets a visitor press random keys for half a minute after arming. Returns the run, and whether it
/// toppled; `None` if the guard did not arm the robot.
fn visit(number: u64) -> (Page, Option<bool>) {
    let mut random = Random::new(&[2026, number]);
    let (file, robot, most_kg) = GROUNDS[number as usize % GROUNDS.len()];
    let changes = if robot.is_empty() {
        json!({ "seed": number })
    } else {
        let place = [
            random.between(-0.05, 0.05),
            random.between(-0.03, 0.03),
            random.between(0.0, 0.1),
        ];
        let mass = random.between(0.0, most_kg);
        json!({ "seed": number, "robot": { robot: { "payload":
            { "mass_kg": mass, "place_m": place, "declared": true } } } })
    };
    let mut page = Page::start(file, &changes, true);
    if page.tries_to_arm().is_none() {
        return (page, None);
    }
    let (mut chassis, mut clearance) = (0.0, 0.29);
    // Every other visitor of a ground lets B2P2 clear it by itself nearly all the time.
    let autonomous = if (number as usize / GROUNDS.len()).is_multiple_of(2) {
        0.05
    } else {
        0.95
    };
    let end = page.advance(0)["sample"]["time_s"]
        .as_f64()
        .expect("a time")
        + 30.0;
    loop {
        let key = |random: &mut Random| [-1.0, 0.0, 1.0, 1.0][random.below(4) as usize];
        let turn = [-25.0, 0.0, 0.0, 25.0][random.below(4) as usize];
        chassis = f64::clamp(chassis + random.between(-30.0, 30.0), -90.0, 90.0);
        clearance = f64::clamp(clearance + random.between(-0.05, 0.05), 0.1, 0.4);
        let speed = if robot.is_empty() { 0.3 } else { 0.15 };
        let command = json!({
            "speed_mps": speed * key(&mut random), "yaw_rate_deg_s": turn, "chassis_deg": chassis,
            "clearance_m": clearance, "step_m": if random.chance(0.2) { 0.1 } else { 0.0 },
            "released": random.chance(0.05), "autonomous": random.chance(autonomous),
        });
        page.ask(&json!({ "command": command }));
        match random.below(20) {
            0 => drop(page.ask(&json!({ "ask": "stop" }))),
            1 => drop(page.ask(&json!({ "ask": "emergency_stop" }))),
            2 | 3 => drop(page.ask(&json!({ "ask": "reset" }))),
            _ => drop(page.ask(&json!({ "ask": "arm" }))),
        }
        let state = page.advance(100 + random.below(1_500));
        let truth = &state["sample"]["truth"];
        let toppled = truth["toppled"] == true;
        if toppled
            || truth.get("came_off").is_some()
            || state["sample"]["time_s"].as_f64() > Some(end)
        {
            return (page, Some(toppled));
        }
    }
}

#[test]
fn no_visitor_topples_a_robot_on_fair_ground() {
    let visitors: Vec<u64> = (0..if complete() { 200 } else { 8 }).collect();
    let wrong = parallel::map(&visitors, |number| {
        let (mut page, toppled) = visit(*number);
        let what = match toppled {
            Some(false) => return None,
            Some(true) => "toppled",
            None => "was not armed",
        };
        let file = GROUNDS[*number as usize % GROUNDS.len()].0;
        Some(format!(
            "visitor {number} of {file} {what}:\n{}",
            page.save().0
        ))
    });
    let wrong: Vec<String> = wrong.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

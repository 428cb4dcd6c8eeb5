//! Tests scenario files: a valid one is the same after writing and reading it; a bad one is refused
//! with one sentence that names the bad key.

use clap::ValueEnum;
use std::path::{Path, PathBuf};
use tautrack::link::WindingModel;
use tautrack::settings::Setting;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::robots::{Kind, NodeName, NodeSpec};
use tautrack_host_tests::scenario::{BusView, OperatorRequest, Scenario, Script};

fn scenarios() -> PathBuf {
    checkout::root().unwrap().join("host-tests/scenarios")
}

fn staircase_text() -> String {
    std::fs::read_to_string(scenarios().join("staircase.toml")).unwrap()
}

/// The error for staircase.toml with `from` replaced by `to`.
fn refusal(from: &str, to: &str) -> String {
    let text = staircase_text();
    assert!(text.contains(from), "staircase.toml has no {from:?}");
    Scenario::parse(&text.replacen(from, to, 1), "bad.toml")
        .unwrap_err()
        .to_string()
}

/// The scenario files of a folder, without those of its subfolders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.retain(|path| path.is_file());
    files.sort();
    files
}

/// All shipped scenarios of the top folder and of the hazard suite.
fn shipped() -> Vec<PathBuf> {
    ["", "hazards", "legitimate"]
        .into_iter()
        .flat_map(|folder| files(&scenarios().join(folder)))
        .collect()
}

#[test]
fn every_shipped_scenario_is_good_and_named_like_its_file() {
    for path in shipped() {
        let scenario = Scenario::load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(path.file_stem().unwrap().to_str().unwrap(), scenario.name);
    }
    let mut names: Vec<_> = files(&scenarios())
        .iter()
        .map(|path| path.file_stem().unwrap().to_owned())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "bench",
            "client",
            "commissioning",
            "curb-30-cm-released",
            "curb-turned-and-folded",
            "flat",
            "node-dies-mid-climb",
            "staircase",
            "staircase-front-kept-up",
            "staircase-k080"
        ]
    );
}

#[test]
fn a_scenario_written_out_and_read_again_is_the_same() {
    for path in shipped() {
        let scenario = Scenario::load(&path).unwrap();
        let text = toml::to_string(&scenario).unwrap();
        assert_eq!(
            Scenario::parse(&text, "again.toml").unwrap_or_else(|error| panic!("{error}\n{text}")),
            scenario
        );
    }
}

#[test]
fn an_impossible_value_is_refused_with_key_value_and_bound() {
    let cases = [
        (
            "riser_m = 0.15",
            "riser_m = -0.15",
            "bad.toml:9:11: terrain.stairs.riser_m is -0.15; it must be at least 0.01 m",
        ),
        (
            "riser_m = 0.15",
            "riser_m = nan",
            "bad.toml:9:11: terrain.stairs.riser_m is NaN; it must be a finite number",
        ),
        (
            "run_m = 0.28",
            "run_m = -inf",
            "bad.toml:10:9: terrain.stairs.run_m is -inf; it must be a finite number",
        ),
        (
            "count = 5",
            "count = 0",
            "bad.toml:11:9: terrain.stairs.count is 0; it must be at least 1",
        ),
        (
            "friction = 1.0",
            "friction = 0",
            "bad.toml:6:12: friction is 0; it must be at least 0.05",
        ),
        (
            "duration_s = 30.0",
            "duration_s = 1e9",
            "bad.toml:5:14: duration_s is 1000000000; it must be at most 3600 s",
        ),
        (
            "first_nose_m = 1.6",
            "first_nose_m = 0.5",
            "bad.toml:13:16: terrain.stairs.first_nose_m is 0.5; it must be at least 0.826 m (the minimum is where the robot's front stands at the start)",
        ),
        (
            "k_m = 1.232",
            "k_m = 0.7799",
            "bad.toml:17:7: robot.b2p2.k_m is 0.7799; it must be at least 0.78 m (the minimum is L1 + 2 L2 and 2.4 L1 of the robot)",
        ),
        (
            "speed_mps = 0.13",
            "speed_mps = 13",
            "bad.toml:22:13: operator.speed_mps is 13; it must be at most 1 m/s",
        ),
        (
            "chassis_deg = 0.0",
            "chassis_deg = 361",
            "operator.event[0].chassis_deg is 361; it must be at most 100 deg (the travel of the chassis joint)",
        ),
        (
            "{ pitch_above_deg = 8.0 }",
            "{}",
            "operator.event[0].when names no condition; give at least one",
        ),
        (
            "{ pitch_above_deg = 8.0 }",
            "{ pitch_above_deg = 8.0, pitch_below_deg = 5.0 }",
            "operator.event[0].when asks for a pitch above and below that cannot hold at once",
        ),
        (
            "chassis_deg = 0.0\n",
            "\n",
            "operator.event[0] changes nothing; give chassis_deg, step_m, clearance_m, speed_mps, yaw_rate_deg_s, belts, clearance or request",
        ),
        (
            "[20.0, 28.0]",
            "[15.0, 41.0]",
            "expect.landing_between_s[1] is 41; it must be at most 30 s",
        ),
        (
            "landed = true",
            "landed = false",
            "expect.landing_between_s needs `landed = true` beside it",
        ),
        (
            "name = \"staircase\"",
            "name = \" \"",
            "bad.toml:2:8: name is empty",
        ),
    ];
    for (from, to, expected) in cases {
        refused(from, to, expected);
    }
}

#[test]
fn an_impossible_sensor_error_or_motion_of_the_hand_is_refused() {
    let cases = [
        (
            "[sensors.errors]\nmounting_deg = [0.0, 181.0, 0.0]",
            "sensors.errors.mounting_deg[1] is 181; it must be at most 180 deg",
        ),
        (
            "[sensors.errors]\nhard_iron_ut = [0.0, 0.0, -201.0]",
            "sensors.errors.hard_iron_ut[2] is -201; it must be at least -200 uT",
        ),
        (
            "[[hand]]\nat_s = 5.0\nwithin_s = 2.0\n[[hand]]\nat_s = 6.0\nwithin_s = 2.0",
            "hand[1].at_s is 6; it must be at least 7 s (the motion before ends there)",
        ),
    ];
    for (added, expected) in cases {
        refused("[expect]", &format!("{added}\n[expect]"), expected);
    }
}

/// Checks that the staircase with `to` instead of `from` is refused in one line.
fn refused(from: &str, to: &str, expected: &str) {
    let got = refusal(from, to);
    assert!(
        got.starts_with("bad.toml:") && got.ends_with(expected),
        "{to}\n  got      {got}\n  expected {expected}"
    );
    assert_eq!(got.lines().count(), 1, "not one line: {got}");
}

#[test]
fn an_impossible_fault_or_payload_is_refused() {
    let fault = |what: &str, rest: &str| {
        format!("[[fault]]\nwhat = {{ {what} }}\nat_s = 5.0\n{rest}\n[expect]")
    };
    let cases = [
        (
            fault("frame_loss = { probability = 1.5 }", ""),
            "fault[0].what.frame_loss.probability is 1.5; it must be at most 1",
        ),
        (
            fault("frame_flip = { frame = 1, bit = 64 }", ""),
            "fault[0].what.frame_flip.bit is 64; it must be at most 63",
        ),
        (
            fault("belt_off = \"screw\"", ""),
            "fault[0].what is for the tracks of B2P2",
        ),
        (
            fault(
                "slippery_track = { track = \"left_track\", friction = 4 }",
                "",
            ),
            "fault[0].what.slippery_track.friction is 4; it must be at most 3",
        ),
        (
            fault("encoder_frozen = \"guard\"", ""),
            "fault[0].what.encoder_frozen is the guard, which has no encoder",
        ),
        (
            fault("frame_flip = { id = 2048, frame = 1, bit = 6 }", ""),
            "fault[0].what.frame_flip.id is 2048; it must be at most 2047",
        ),
        (
            fault("forger = { id = 0x800, data = [], period_ms = 1 }", ""),
            "fault[0].what.forger.id is 2048; it must be at most 2047",
        ),
        (
            fault(
                "forger = { id = 1, data = [1, 2, 3, 4, 5, 6, 7, 8, 9], period_ms = 1 }",
                "",
            ),
            "fault[0].what.forger.data is 9; it must be at most 8 bytes",
        ),
        (
            fault("forger = { id = 1, data = [], period_ms = 0 }", ""),
            "fault[0].what.forger.period_ms is 0; it must be at least 1 ms",
        ),
        (
            fault(
                "switch_stuck = { node = \"guard\", switch = \"home\", closed = true }",
                "",
            ),
            "fault[0].what.switch_stuck.node is the guard, which has no switches",
        ),
        (
            fault("node_dead = \"screw\"", "until_s = 4.0"),
            "fault[0].until_s is 4; it must be at least 5 s (the fault begins there)",
        ),
        (
            fault("node_dead = \"screw\"", "notice_within_ms = 0.0"),
            "fault[0].notice_within_ms is 0; it must be at least 1 ms",
        ),
        (
            fault("node_dead = \"screw\"", "").replace("5.0", "50.0"),
            "fault[0].at_s is 50; it must be at most 30 s (the run ends there)",
        ),
        (
            fault("node_dead = \"seat_pitch\"", ""),
            "fault[0].what is about a node that this robot does not have",
        ),
        (
            "[robot.b2p2.payload]\nmass_kg = -1\nplace_m = [0, 0, 0]\ndeclared = true\n[expect]"
                .into(),
            "robot.b2p2.payload.mass_kg is -1; it must be at least 0 kg",
        ),
        (
            "[robot.b2p2.payload]\nmass_kg = 1\nplace_m = [0, 0, 9]\ndeclared = true\n[expect]"
                .into(),
            "robot.b2p2.payload.place_m[2] is 9; it must be at most 1 m",
        ),
    ];
    for (text, expected) in cases {
        let got = refusal("[expect]", &text);
        assert!(
            got.ends_with(expected),
            "{text}\n  got      {got}\n  expected {expected}"
        );
    }
}

#[test]
fn a_motor_of_the_scenario_is_simulated_and_known_to_its_node() {
    let text = staircase_text();
    let track = |changes: &str| {
        let text = text.replace("[expect]", &format!("{changes}\n[expect]"));
        Scenario::parse(&text, "bad.toml").map(|scenario| scenario.nodes().swap_remove(0))
    };
    let of = |node: &NodeSpec, wanted: Setting| {
        let found = node.settings.iter().find(|(setting, _)| *setting == wanted);
        found.map(|(_, value)| *value)
    };
    let node = track("[motor.left_track]\nkind = \"pmsm\"\nflux_wb = 0.004\ngear = 50.0").unwrap();
    let motor = node.motor.unwrap();
    let WindingModel::ThreePhase(winding) = motor.winding else {
        panic!("{motor:?}");
    };
    assert_eq!((winding.flux, winding.resistance), (0.004, 0.6));
    assert_eq!((motor.gear_ratio, motor.friction_torque), (50.0, 0.3));
    assert_eq!(of(&node, Setting::MotorKind), Some(1));
    assert_eq!(of(&node, Setting::TorqueConstant), Some(42_000));
    assert_eq!(of(&node, Setting::GearRatio), Some(50_000));
    let node =
        track("[motor.left_track]\nflux_wb = 0.05\n[settings.left_track]\ntorque_constant = 40000");
    let node = node.unwrap();
    assert_eq!(node.motor.unwrap().winding.torque_constant(), 0.05);
    assert_eq!(of(&node, Setting::TorqueConstant), Some(40_000));
    for (changes, expected) in [
        (
            "[motor.left_track]\nflux_wb = 0.0",
            "motor.left_track.flux_wb is 0; it must be at least 0.00001 Wb",
        ),
        (
            "[motor.left_track]\npole_pairs = 7",
            "motor.left_track.pole_pairs has no effect on a motor of the kind \"dc\"",
        ),
        (
            "[motor.guard]\ngear = 50.0",
            "motor.guard is the guard, which has no motor",
        ),
        (
            "[motor.seat_pitch]\ngear = 50.0",
            "motor.seat_pitch is a node that this robot does not have",
        ),
    ] {
        let got = track(changes).unwrap_err().to_string();
        assert!(got.ends_with(expected), "{got}");
    }
}

#[test]
fn a_node_is_told_the_settings_of_the_scenario_instead_of_its_robot_s() {
    let text = staircase_text();
    let told = |changes: &str| {
        let text = text.replace("[expect]", &format!("{changes}\n[expect]"));
        Scenario::parse(&text, "bad.toml").map(|scenario| {
            let guard = scenario.nodes().pop().unwrap();
            (guard.name, guard.settings)
        })
    };
    let (name, settings) = told("[settings.guard]\nk = 1300000\nstop_margin = 60000").unwrap();
    assert_eq!(name, NodeName::GUARD);
    let of = |wanted: Setting| -> Vec<i32> {
        let found = settings.iter().filter(|(setting, _)| *setting == wanted);
        found.map(|(_, value)| *value).collect()
    };
    assert_eq!(of(Setting::LengthK), [1_300_000]);
    assert_eq!(of(Setting::StopMargin), [60_000]);
    for (changes, expected) in [
        (
            "[settings.guard]\nkk = 1",
            "settings.guard.kk is no setting; docs/settings.md has them all",
        ),
        (
            "[settings.guard]\nstop_margin = -1",
            "settings.guard.stop_margin is -1; it must be at least 1000 um",
        ),
        (
            "[settings.guard]\nfilter_active = 0",
            "settings.guard.filter_active is what the scenario and its robot say elsewhere",
        ),
        (
            "[settings.seat_pitch]\nk = 1",
            "settings.seat_pitch is a node that this robot does not have",
        ),
    ] {
        let got = told(changes).unwrap_err().to_string();
        assert!(got.ends_with(expected), "{got}");
    }
}

#[test]
fn a_posture_of_another_robot_is_refused() {
    for (key, value) in [("step_m", "0.1"), ("clearance_m", "0.3")] {
        let got = refusal("chassis_deg = 0.0", &format!("{key} = {value}"));
        assert!(got.ends_with("is no posture of this robot"), "{key}: {got}");
    }
    let got = refusal("chassis_deg = 45.0", "chassis_deg = 45.0\nstep_m = 0.1");
    assert!(
        got.ends_with("operator.step_m is no posture of this robot"),
        "{got}"
    );
}

#[test]
fn a_hand_is_refused_where_the_plant_has_none() {
    let path = scenarios().join("crawler/slope.toml");
    let text = std::fs::read_to_string(path).unwrap();
    let text = format!("{text}\n[[hand]]\nat_s = 1.0\nwithin_s = 1.0\n");
    let got = Scenario::parse(&text, "bad.toml").unwrap_err().to_string();
    assert!(got.ends_with("hand cannot hold this robot"), "{got}");
}

#[test]
fn every_terrain_fault_and_load_can_be_written() {
    let stairs = staircase_text();
    let (begin, end) = (
        stairs.find("[terrain.stairs]").unwrap(),
        stairs.find("# Assumed, because").unwrap(),
    );
    let landing = "landed = true\ntoppled = false\nlanding_between_s = [20.0, 28.0]";
    for (terrain, last_nose) in [
        ("[terrain.curb]\nheight_m = 0.2\nnose_m = 1.2\n", Some(1.2)),
        ("[terrain.slope]\nangle_deg = -20\n", None),
    ] {
        let text = stairs
            .replace(&stairs[begin..end], terrain)
            .replace(landing, "");
        let scenario =
            Scenario::parse(&text, "terrain.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.terrain.last_nose_m(), last_nose);
    }
    for what in [
        "{ node_dead = \"guard\" }",
        "{ encoder_frozen = \"chassis_joint\" }",
        "{ bus_cut = \"screw\" }",
        "{ restart = \"guard\" }",
        "{ frame_loss = { probability = 0.01 } }",
        "\"operator_lost\"",
        "{ belt_off = \"left_track\" }",
        "{ slippery_track = { track = \"right_track\", friction = 0.2 } }",
        "{ frame_flip = { frame = 100, bit = 7 } }",
        "{ sensor = { chip = \"magnetometer\", fault = \"half_rate\" } }",
    ] {
        let text = stairs.replace("[expect]", &format!("[[fault]]\nwhat = {what}\nat_s = 3\nuntil_s = 4\n[robot.b2p2.payload]\nmass_kg = 2\nplace_m = [0.1, 0, 0.25]\ndeclared = false\n[expect]"));
        let scenario =
            Scenario::parse(&text, "fault.toml").unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(scenario.faults.len(), 1);
        assert_eq!(
            scenario
                .robot
                .b2p2()
                .unwrap()
                .payload
                .as_ref()
                .unwrap()
                .place_m,
            [0.1, 0.0, 0.25]
        );
        let again = Scenario::parse(&toml::to_string(&scenario).unwrap(), "again.toml").unwrap();
        assert_eq!(again, scenario);
    }
}

#[test]
fn a_file_of_the_wrong_shape_is_refused_with_its_place() {
    let cases = [
        (
            "friction = 1.0",
            "frction = 1.0",
            "bad.toml:6:1: ",
            "unknown field `frction`",
        ),
        (
            "friction = 1.0",
            "friction = \"much\"",
            "bad.toml:6:12: friction: ",
            "invalid type: string \"much\", expected f64",
        ),
        (
            "riser_m = 0.15",
            "riser_m = true",
            "bad.toml:9:11: terrain.stairs.riser_m: ",
            "invalid type",
        ),
        (
            "friction = 1.0",
            "",
            "bad.toml:1:1: ",
            "missing field `friction`",
        ),
        ("friction = 1.0", "friction = ", "bad.toml:6:", "expected"),
        (
            "seed = 1",
            "seed = -1",
            "bad.toml:4:8: seed: ",
            "invalid value",
        ),
        (
            "[terrain.stairs]",
            "[terrain.escalator]",
            "bad.toml:8:",
            "unknown variant `escalator`",
        ),
        (
            "pitch_above_deg = 8.0",
            "pitch_deg = 8.0",
            "bad.toml:",
            "unknown field `pitch_deg`",
        ),
        (
            "[expect]",
            "[[fault]]\nwhat = { node_dead = \"left_wing\" }\nat_s = 1.0\n[expect]",
            "bad.toml:",
            "no robot has a node `left_wing`",
        ),
    ];
    for (from, to, place, what) in cases {
        let got = refusal(from, to);
        assert!(
            got.starts_with(place) && got.contains(what),
            "{to}\n  got      {got}\n  expected {place}...{what}"
        );
        assert_eq!(got.lines().count(), 1, "not one line: {got}");
    }
}

#[test]
fn an_empty_or_absent_file_is_refused() {
    for text in ["", "\n \n", "# nothing\n"] {
        let got = Scenario::parse(text, "empty.toml").unwrap_err().to_string();
        assert_eq!(
            got,
            "empty.toml: is empty; scenarios/flat.toml shows the minimum that a scenario needs"
        );
    }
    let got = Scenario::load(Path::new("no-such.toml"))
        .unwrap_err()
        .to_string();
    assert!(got.starts_with("no-such.toml: cannot be read: "), "{got}");
}

#[test]
fn the_plant_gets_what_the_file_says() {
    let text = staircase_text()
        .replace("k_m = 1.232", "k_m = 0.9")
        .replace("com_offset_m = 0.0", "com_offset_m = -0.02")
        .replace("friction = 1.0", "friction = 0.7");
    let scenario = Scenario::parse(&text, "plant.toml").unwrap();
    let robot = scenario.robot.b2p2().unwrap();
    let parameters = robot.parameters(scenario.friction);
    let got = [
        parameters.k,
        parameters.body_1_com_height,
        parameters.friction,
        parameters.pulley_radius,
    ];
    assert_eq!(got, [0.9, -0.02, 0.7, 0.05]);
    // L2 + L3 of the straight robot is (K - L1) / 2, which must be within the screw's travel.
    let straight = (0.9 - 0.32) / 2.0 - 0.23;
    assert!(parameters.screw_travel[0] < straight && straight < parameters.screw_travel[1]);
    let section = scenario.terrain.ground().section(0.0, 4.0);
    let highest = section.iter().map(|corner| corner[1]).fold(0.0, f64::max);
    assert!(
        (highest - 0.75).abs() < 1e-12
            && (scenario.terrain.last_nose_m().unwrap() - 2.72).abs() < 1e-12
    );
}

#[test]
fn a_client_can_be_the_operator_instead_of_a_script() {
    let text = std::fs::read_to_string(scenarios().join("client.toml")).unwrap();
    let scenario = Scenario::parse(&text, "client.toml").unwrap();
    assert!(scenario.operator.client);
    let written = toml::to_string(&scenario).unwrap();
    assert!(written.contains("operator = \"client\""), "{written}");
    assert_eq!(Scenario::parse(&written, "again").unwrap(), scenario);

    let script = Scenario::load(&scenarios().join("staircase.toml")).unwrap();
    assert!(!script.operator.client);

    let line = text.lines().position(|line| line.starts_with("operator"));
    let place = format!("bad.toml:{}:", line.unwrap() + 1);
    for bad in ["operator = \"clint\"", "operator = 1", "operator = []"] {
        let refusal = Scenario::parse(&text.replace("operator = \"client\"", bad), "bad.toml");
        let refusal = refusal.unwrap_err().to_string();
        assert!(refusal.starts_with(&place), "{refusal}");
        assert!(refusal.contains("or \"client\""), "{refusal}");
    }
}

#[test]
fn the_operator_lowers_the_front_at_the_first_nose_and_again_past_the_last() {
    let scenario = Scenario::load(&scenarios().join("staircase.toml")).unwrap();
    let armed = BusView {
        time_s: 2.0,
        odometry_m: -0.3,
        ..BusView::default()
    };
    let mut script = Script::new(&scenario.operator, armed, 0.0);
    let mut now = armed;
    let mut run = |script: &mut Script, seconds: f64, pitch_deg: f64| {
        let mut ask = script.tick(now);
        for _ in 0..(seconds * 100.0).round() as u32 {
            now.time_s += 0.01;
            now.odometry_m += 0.0013;
            now.pitch = pitch_deg.to_radians();
            ask = script.tick(now);
        }
        ask
    };
    let ask = run(&mut script, 1.0, 0.0);
    assert!(
        (ask.theta.to_degrees() - 28.6).abs() < 1e-6,
        "the front rises at its rate: {}",
        ask.theta.to_degrees()
    );
    assert!((run(&mut script, 5.0, 7.9).theta.to_degrees() - 45.0).abs() < 1e-9);
    assert_eq!(script.events_done(), 0);
    assert!(run(&mut script, 2.0, 8.1).theta.abs() < 1e-9);
    assert!(
        run(&mut script, 10.0, 30.0).theta.abs() < 1e-9,
        "1.56 m since the first nose is not yet the last"
    );
    assert!((run(&mut script, 2.0, 30.0).theta.to_degrees() + 30.0).abs() < 1e-9);
    assert!(run(&mut script, 2.0, 0.0).theta.abs() < 1e-9);
    assert_eq!(run(&mut script, 3.0, 0.0).speed_mps, 0.0);
    assert_eq!(script.events_done(), scenario.operator.events.len());
}

#[test]
fn the_operator_steers_back_to_the_heading_it_began_with_the_short_way_round() {
    let scenario = Scenario::load(&scenarios().join("flat.toml")).unwrap();
    let armed = BusView {
        heading: 3.1,
        ..BusView::default()
    };
    let mut script = Script::new(&scenario.operator, armed, 0.0);
    let ask = script.tick(BusView {
        time_s: 0.01,
        heading: -3.1,
        ..armed
    });
    let expected = 2.0 * (3.1 - std::f64::consts::PI);
    assert!(
        (ask.yaw_rate - expected).abs() < 1e-12,
        "{} instead of {expected}",
        ask.yaw_rate
    );
    let ask = script.tick(BusView {
        time_s: 0.02,
        heading: 1.0,
        ..armed
    });
    assert_eq!(ask.yaw_rate, Script::MOST_YAW_RATE);
}

#[test]
fn node_names_are_written_as_they_are_read() {
    for kind in Kind::value_variants() {
        for (name, _) in kind.facts().nodes {
            let written = serde_json::to_value(name).unwrap();
            assert_eq!(written, name.as_str());
            assert_eq!(serde_json::from_value::<NodeName>(written).unwrap(), *name);
        }
    }
    let unknown = serde_json::from_value::<NodeName>("tail".into()).unwrap_err();
    assert_eq!(unknown.to_string(), "no robot has a node `tail`");
}

#[test]
fn an_operators_request_stays_until_the_next_and_is_to_arm_before_the_first() {
    let text = staircase_text();
    let begin = text.find("[[operator.event]]").unwrap();
    let end = text.find("[expect]").unwrap();
    let events = "[[operator.event]]\nwhen = { after_s = 1.0 }\nrequest = \"emergency_stop\"\n\
                  [[operator.event]]\nwhen = { after_s = 1.0 }\nspeed_mps = 0.2\n\
                  [[operator.event]]\nwhen = { after_s = 1.0 }\nrequest = \"reset\"\n";
    let text = text.replace(&text[begin..end], events);
    let scenario = Scenario::parse(&text, "request.toml").unwrap();
    let mut script = Script::new(&scenario.operator, BusView::default(), 0.0);
    let mut at = |time_s: f64| {
        let ask = script.tick(BusView {
            time_s,
            ..BusView::default()
        });
        (ask.request, ask.speed_mps)
    };
    assert_eq!(at(0.9), (OperatorRequest::Arm, 0.13));
    assert_eq!(at(1.0), (OperatorRequest::EmergencyStop, 0.13));
    assert_eq!(at(2.0), (OperatorRequest::EmergencyStop, 0.2));
    assert_eq!(at(3.0), (OperatorRequest::Reset, 0.2));
}

#[test]
fn belts_of_a_robot_without_a_screw_are_refused() {
    let changed = |key: &str| refusal("chassis_deg = 0.0", key);
    let got = changed("belts = \"loose\"");
    assert!(got.contains("loose") && got.contains("released"), "{got}");
    let path = scenarios().join("crawler/slope.toml");
    let text = std::fs::read_to_string(path).expect("a scenario");
    for key in ["belts = \"released\"\n", "belts = \"taut\"\n"] {
        let text = text.replacen("speed_mps", &format!("{key}speed_mps"), 1);
        let got = Scenario::parse(&text, "bad.toml").unwrap_err().to_string();
        assert!(
            got.contains("operator") && got.contains("is for a robot with a screw"),
            "{got}"
        );
    }
    let text = text.replacen("speed_mps", "clearance = \"autonomous\"\nspeed_mps", 1);
    let got = Scenario::parse(&text, "bad.toml").unwrap_err().to_string();
    assert!(
        got.contains("operator.clearance") && got.contains("is for B2P2"),
        "{got}"
    );
}

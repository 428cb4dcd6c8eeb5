//! Runs small samples of the suites. `cargo demo --suite hazards` and `--suite operators` run them
//! completely.

use crate::unchanged::{self, cases};
use std::path::Path;
use tautrack_host_tests::programs::{Board, Programs};
use tautrack_host_tests::robots;
use tautrack_host_tests::robots::payload::Payload;
use tautrack_host_tests::scenario::{Scenario, Sensors};
use tautrack_host_tests::tools::suite::draw::Kind;
use tautrack_host_tests::tools::suite::drawn_runs;
use tautrack_host_tests::tools::suite::evaluation::{Finding, Thoroughness, hazard};
use tautrack_host_tests::tools::suite::operators::{Plan, Row, operate, operators};
use tautrack_host_tests::world::terrain::Terrain;

/// Native nodes of B2P2.
fn programs() -> Programs {
    robots::Kind::B2p2
        .programs(Board::Host)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Runs a test of whole runs, unless it has passed with the same programs.
fn unless_unchanged(name: &str, test: impl FnOnce()) {
    unchanged::unless_unchanged(name, unchanged::nodes(&programs()), test);
}

#[test]
fn a_few_drawn_hazards_are_held_and_a_few_drawn_legitimate_runs_pass() {
    unless_unchanged("suite-drawn", || {
        let programs = programs();
        let count = if unchanged::complete() { 3 } else { 1 };
        for kind in Kind::ALL {
            let drawn = drawn_runs(kind, count, 1, Sensors::default(), &programs, &|_| {})
                .expect("they run");
            assert_eq!(drawn.rows.len() as u64, count);
            for row in &drawn.rows {
                assert!(
                    row.unmet.is_empty(),
                    "{}: {}: {:?}, {:?}",
                    row.scenario.name,
                    row.scenario.about,
                    row.unmet,
                    row.finding
                );
                if let Finding::Hazard {
                    toppled_s,
                    toppled_with_guard,
                    acted_s,
                    savable_until_s,
                    ..
                } = row.finding
                {
                    let toppled = toppled_s.expect("else it would have been drawn again");
                    assert!(!toppled_with_guard && acted_s.is_some_and(|acted| acted < toppled));
                    assert!(savable_until_s < toppled);
                }
            }
        }
    });
}

/// The slope is too steep for the robot while it homes, so it rolls over before any command.
#[test]
fn a_robot_that_topples_before_anything_is_commanded_is_no_hazard() {
    let programs = programs();
    let file = "scenarios/hazards/side-slope-60-front-raised.toml";
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
    let mut description = Scenario::load(&path).expect("shipped").description();
    description.terrain = Terrain::Slope {
        angle_deg: 0.0,
        side_deg: 68.0,
    };
    description.robot.b2p2_mut().payload = Some(Payload {
        mass_kg: 4.0,
        place_m: [0.15, 0.0, 0.3],
        from_s: 0.0,
        declared: true,
    });
    let scenario = Scenario::checked(description).expect("within the bounds");
    let row = hazard(&scenario, Thoroughness::Quick, &programs).expect("it runs");
    assert!(matches!(
        row.finding,
        Finding::Hazard {
            toppled_s: Some(_),
            ..
        }
    ));
    assert!(!row.is_of_its_kind(), "{:?}", row.unmet);
}

#[test]
fn a_random_operator_never_topples_b2p2_on_fair_ground() {
    unless_unchanged("suite-operators", || {
        let programs = programs();
        let plan = Plan {
            robot: robots::Kind::B2p2,
            guard: true,
            runs: cases(20) as u64,
            seed: 3,
            sensors: Sensors::default(),
        };
        let rows = operators(&plan, &programs, &[], &|_, _| {}).expect("they run");
        assert_eq!(rows.len(), cases(20));
        for row in &rows {
            assert!(
                !row.failed(),
                "run {} ({}): {:?}",
                row.number,
                row.about,
                row.topple
            );
        }
        // The operators really drive.
        let driven_m: f64 = rows.iter().map(|row| row.distance_m).sum();
        let armed = rows.iter().filter(|row| row.armed_share > 0.5).count();
        assert!(
            driven_m > cases(20) as f64 && armed + 1 >= cases(20),
            "{driven_m} m, {armed} armed"
        );
        // Known results are not computed again.
        let none = |row: &Row, _: &Scenario| panic!("run {} again", row.number);
        let known = operators(&plan, &programs, &rows, &none).expect("nothing runs");
        assert_eq!(known, rows);
    });
}

/// Drives without power let the robot go; with the guard the drives hold it.
#[test]
fn on_stairs_a_restart_or_a_reset_is_a_hazard_and_the_drives_hold_the_robot() {
    unless_unchanged("suite-interruptions", || {
        let programs = programs();
        for name in ["guard-restart-on-stairs", "reset-on-stairs"] {
            let file = format!("scenarios/hazards/{name}.toml");
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
            let scenario = Scenario::load(&path).expect("shipped");
            let row = hazard(&scenario, Thoroughness::Quick, &programs).expect("it runs");
            println!("{name}: {:?}, {:?}", row.finding, row.unmet);
            assert!(row.is_of_its_kind(), "{name}: {:?}", row.finding);
            let Finding::Interruption { interrupted_s, .. } = row.finding else {
                panic!("{name}: {:?}", row.finding);
            };
            assert!((12.0..14.0).contains(&interrupted_s), "{name}");
            assert!(row.unmet.is_empty(), "{name}: {:?}", row.unmet);
        }
    });
}

/// Tests the manoeuvres nose down, on stairs, backward and turning. The nose-down robot comes to
/// rest on its raised front.
#[test]
fn each_manoeuvre_topples_the_robot_after_the_operators_command_when_nothing_holds_it_back() {
    unless_unchanged("suite-manoeuvres", || {
        let programs = programs();
        for name in [
            "nose-down-front-raised",
            "folded-down-on-stairs",
            "backward-off-the-stairs",
            "spin-on-a-slope",
        ] {
            let file = format!("scenarios/hazards/{name}.toml");
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(file);
            let mut description = Scenario::load(&path).expect("shipped").description();
            description.guard = false;
            let scenario = Scenario::checked(description).expect("within the bounds");
            let (row, commanded) = operate(&scenario, &programs).expect("it runs");
            assert!(row.failed() && commanded, "{name}: {row:?}");
            let events = scenario.operator.events.len() as u64;
            assert_eq!(row.commands.passed, events + 1, "{name}: {row:?}");
        }
    });
}

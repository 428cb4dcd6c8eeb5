//! Tests docs/scenarios.md and the pages of the robots: they have every key of a scenario file, its
//! examples are valid, and its bounds are those of the check.

use clap::ValueEnum;
use std::collections::BTreeSet;
use std::path::Path;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::robots::Kind;
use tautrack_host_tests::scenario::Scenario;
use toml::{Table, Value};

fn page() -> String {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let path = root.join("docs/scenarios.md");
    std::fs::read_to_string(path).expect("docs/scenarios.md")
}

/// The page, and those of the robots.
fn pages() -> String {
    let folder = checkout::root().expect("it was found").join("docs/robots");
    let files = std::fs::read_dir(folder).expect("docs/robots");
    let paths = files.map(|file| file.expect("a file").path());
    let pages = paths.filter(|path| path.extension().is_some_and(|ending| ending == "md"));
    pages.fold(page(), |all, page| {
        all + &std::fs::read_to_string(page).expect("a page")
    })
}

/// The examples of the page. Keys of a partial example replace those of the first one, which is
/// complete.
fn examples() -> Vec<String> {
    let page = page();
    let blocks: Vec<Table> = page
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or_default())
        .map(|text| {
            text.parse()
                .unwrap_or_else(|error| panic!("{error}\n{text}"))
        })
        .collect();
    let whole = blocks[0].clone();
    blocks
        .into_iter()
        .map(|block| {
            let mut text = whole.clone();
            text.extend(block);
            text.to_string()
        })
        .collect()
}

/// Collects every key in `value`; a list of tables counts as one table.
fn keys(value: &Value, into: &mut BTreeSet<String>) {
    match value {
        Value::Table(table) => {
            for (key, value) in table {
                into.insert(key.clone());
                keys(value, into);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| keys(item, into)),
        _ => {}
    }
}

/// Every part of the keys in the pages' tables.
fn documented() -> BTreeSet<String> {
    pages()
        .lines()
        .filter_map(|line| line.strip_prefix("| `")?.split('`').next())
        .flat_map(|key| key.split('.').map(str::to_owned).collect::<Vec<_>>())
        .collect()
}

#[test]
fn every_example_is_a_good_scenario() {
    let examples = examples();
    assert_eq!(examples.len(), 11);
    for text in examples {
        Scenario::parse(&text, "example").unwrap_or_else(|error| panic!("{error}\n{text}"));
    }
}

#[test]
// The parser lists the keys that it knows in its error for an unknown key.
fn every_key_that_the_parser_knows_has_a_row_and_an_example() {
    let mut shown = BTreeSet::new();
    for text in examples() {
        keys(
            &Value::Table(text.parse().expect("it parsed before")),
            &mut shown,
        );
    }
    // Written as texts, not as keys.
    shown.extend(["flat", "operator_lost"].map(str::to_owned));
    let examples = examples();
    let unknown_in = [
        (1, "seed =", "nonsense = 1\nseed ="),
        (1, "[terrain.stairs]", "[terrain.nonsense]"),
        (1, "riser_m", "nonsense = 1\nriser_m"),
        (2, "height_m", "nonsense = 1\nheight_m"),
        (3, "angle_deg", "nonsense = 1\nangle_deg"),
        (4, "foot_m", "nonsense = 1\nfoot_m"),
        (6, "acceleration_mps2", "nonsense = 1\nacceleration_mps2"),
        (6, "cohesion_pa", "nonsense = 1\ncohesion_pa"),
        (7, "slope_deg", "nonsense = 1\nslope_deg"),
        (7, "posture_control", "nonsense = 1\nposture_control"),
        (1, "k_m", "nonsense = 1\nk_m"),
        (1, "mass_kg", "nonsense = 1\nmass_kg"),
        (1, "chassis_rate_deg_s", "nonsense = 1\nchassis_rate_deg_s"),
        (1, "yaw_rate_deg_s", "nonsense = 1\nyaw_rate_deg_s"),
        (1, "pitch_above_deg", "nonsense"),
        (1, "at_s = 8.0", "nonsense = 1\nat_s = 8.0"),
        (1, "frame_loss", "nonsense"),
        (1, "probability", "nonsense"),
        (1, "bit", "nonsense"),
        (5, "closed", "nonsense"),
        (5, "period_ms", "nonsense"),
        (1, "toppled", "nonsense"),
        (1, "inertial_hz", "nonsense = 1\ninertial_hz"),
        (1, "mounting_deg", "nonsense"),
        (1, "lift_m", "nonsense"),
        (1, "at_ms", "nonsense"),
    ];
    let mut known = BTreeSet::new();
    for (example, from, to) in unknown_in {
        // `toml` writes inline tables as sections, so every key is at the beginning of a line or a
        // section.
        let text = examples[example].replacen(from, to, 1);
        let refusal = Scenario::parse(&text, "example")
            .expect_err(&text)
            .to_string();
        let (_, list) = refusal
            .split_once("expected one of ")
            .or_else(|| refusal.split_once("available keys: "))
            .unwrap_or_else(|| panic!("{from}: {refusal}"));
        known.extend(list.split(", ").map(|key| key.trim_matches('`').to_owned()));
    }
    // One key of each list above, to show that every list was read.
    for key in [
        "terrain",
        "riser_m",
        "depth_m",
        "side_deg",
        "declared",
        "bus_cut",
        "probability",
        "frame",
        "switch",
        "data",
        "tension_error_below_m",
        "rate_at_rest_deg_s",
        "within_s",
        "at_ms",
    ] {
        assert!(
            known.contains(key),
            "the parser did not name {key}: {known:?}"
        );
    }
    let documented = documented();
    for key in &known {
        assert!(
            documented.contains(key) || in_a_heading(key),
            "{key} has no row"
        );
        assert!(shown.contains(key), "{key} has no example");
    }
}

/// Tests the section of every robot in the robot's own scenario.
#[test]
fn every_key_of_every_robot_has_a_row() {
    let documented = documented();
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for kind in Kind::value_variants() {
        let file = scenarios.join(kind.facts().scenario_file);
        let mut scenario: Table = std::fs::read_to_string(file)
            .expect("its scenario")
            .parse()
            .expect("TOML");
        let robots = scenario["robot"].as_table_mut().expect("a robot");
        let (name, section) = robots.iter_mut().next().expect("its section");
        let name = name.clone();
        let section = section.as_table_mut().expect("a table");
        section.insert("nonsense".into(), Value::Integer(1));
        let refusal = Scenario::parse(&scenario.to_string(), "example")
            .expect_err("the key was taken")
            .to_string();
        let keys = refusal
            .split('`')
            .skip_while(|text| !text.contains("expected"));
        let keys: Vec<_> = keys.skip(1).step_by(2).collect();
        assert!(!keys.is_empty(), "{refusal}");
        assert!(in_a_heading(&format!("[robot.{name}]")), "{name}");
        for key in keys {
            assert!(documented.contains(key), "{key} of {name} has no row");
        }
    }
}

fn in_a_heading(key: &str) -> bool {
    pages()
        .lines()
        .any(|line| line.starts_with("## `") && line.contains(key))
}

/// Tries values just outside the bounds, for rows whose key occurs once in the complete example and
/// whose bound is a number.
#[test]
fn the_bounds_on_the_page_are_those_of_the_check() {
    let example = &examples()[1];
    let mut tried = 0;
    for line in page().lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let key = cells[1]
            .trim_matches('`')
            .rsplit('.')
            .next()
            .unwrap_or_default();
        let assignment = format!("\n{key} = ");
        if example.matches(&assignment).count() != 1 {
            continue;
        }
        for (bound, outward) in [(cells[3], -1.0), (cells[4], 1.0)] {
            let Ok(bound) = bound.parse::<f64>() else {
                continue;
            };
            let (before, rest) = example.split_once(&assignment).expect("it is there once");
            let (old, after) = rest.split_once('\n').unwrap_or((rest, ""));
            let whole = old.parse::<i64>().is_ok();
            let outside = bound
                + outward
                    * if whole {
                        1.0
                    } else {
                        1e-6 * bound.abs().max(1e-3)
                    };
            let written = if whole {
                format!("{outside}")
            } else {
                format!("{outside:?}")
            };
            let text = format!("{before}{assignment}{written}\n{after}");
            let refusal = Scenario::parse(&text, "example")
                .expect_err(&format!("{key} = {written} was taken"))
                .to_string();
            assert!(refusal.contains(key), "{key}: {refusal}");
            tried += 1;
        }
    }
    println!("{tried} bounds tried");
    assert!(tried > 40, "{tried}");
}

//! Tests that the generated parts of docs/ match their sources and are complete.

use tautrack::stability::filter::Verdict;
use tautrack::{faults, settings};
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::tools::generate;

fn page(name: &str) -> String {
    let files = generate::files().unwrap_or_else(|error| panic!("{error}"));
    let (_, text) = files
        .into_iter()
        .find(|(path, _)| path.ends_with(name))
        .unwrap_or_else(|| panic!("{name} is not generated"));
    text
}

#[test]
fn committed_pages_and_data_sheets_are_what_their_sources_give() {
    for (path, text) in generate::files().unwrap_or_else(|error| panic!("{error}")) {
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == text,
            "{} is out of date: type `cargo generate` and commit",
            path.display()
        );
    }
}

#[test]
fn a_promise_without_exactly_one_test_is_refused_with_the_name_of_the_test() {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let refusal = |test: &str| {
        let source = format!("[[section]]\ntitle = 'All'\npromises = [['It works.', '{test}']]");
        generate::guarantees::tables(root, &source).expect_err("a refusal")
    };
    let missing = refusal("nobody_has_written_this_test");
    assert!(
        missing.starts_with("`nobody_has_written_this_test` names 0 tests"),
        "{missing}"
    );
    let twice = refusal("a_check_at_arming_accuses_no_sound_drive");
    for file in [
        "shared/tests/node/halls.rs",
        "shared/tests/node/motor_faults/wrong_angle.rs",
    ] {
        assert!(twice.contains(file), "{twice}");
    }
}

#[test]
fn every_setting_and_every_fault_has_its_row() {
    let page_of_settings = page("docs/settings.md");
    for row in settings::TABLE {
        let key = format!("| `{:#06x}` | `{}` |", row.key, row.name);
        assert_eq!(page_of_settings.matches(&key).count(), 1, "{key}");
    }
    // The page breaks its lines, and sets settings in italics.
    let words: Vec<String> = page("docs/faults.md")
        .split_whitespace()
        .map(str::to_owned)
        .collect();
    let plain = |text: &str| text.replace(['`', '*'], "");
    let page_of_faults = plain(&words.join(" "));
    for row in faults::TABLE {
        assert!(page_of_faults.contains(&plain(row.remedy)), "{row:?}");
    }
}

#[test]
fn every_object_has_a_meaning() {
    let page = page("docs/bus.md");
    let rows: Vec<&str> = page
        .split("| Object | Name | Type | Access | Default | Meaning |")
        .skip(1)
        .flat_map(|table| {
            table
                .lines()
                .skip(2)
                .take_while(|line| line.starts_with('|'))
        })
        .collect();
    assert!(rows.len() > 90, "{rows:?}");
    for row in rows {
        let meaning = row.split('|').nth(6).unwrap_or_default();
        assert!(!meaning.trim().is_empty(), "{row}");
    }
}

#[test]
fn every_verdict_is_in_one_row_of_the_page_with_its_reason() {
    let page = page("docs/bus.md");
    let (_, table) = page.split_once("| Code | In results |").expect("the table");
    let rows: Vec<Vec<&str>> = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    let number =
        |text: &str| u8::from_str_radix(text.trim_matches('`').trim_start_matches("0x"), 16);
    let mut known = 0;
    for code in 0..=u8::MAX {
        let covering: Vec<_> = rows
            .iter()
            .filter(|row| {
                let (first, last) = row[1].split_once(" to ").unwrap_or((row[1], row[1]));
                (number(first).unwrap()..=number(last).unwrap()).contains(&code)
            })
            .collect();
        let is_code = Verdict::from_code(code).is_some_and(|verdict| verdict.code() == code);
        assert_eq!(
            covering.len(),
            usize::from(is_code),
            "{code:#04x}: {covering:?}"
        );
        if let Some(row) = covering.first().filter(|row| row[1].contains(" to ")) {
            let reason = format!("{} ", code & 0xf);
            let reasons = row[3].split(", ").filter(|low| low.starts_with(&reason));
            assert_eq!(reasons.count(), 1, "{code:#04x}: {row:?}");
        }
        known += usize::from(is_code);
    }
    assert!(known > 40, "{known}");
}

/// Compares the time on the page with the recorded run, whose operator requests "arm" as soon as
/// the guard is ready.
#[test]
fn the_page_says_how_long_arming_takes() {
    let root = checkout::root().unwrap_or_else(|error| panic!("{error}"));
    let snapshot = std::fs::read_to_string(root.join("host-tests/snapshots/flat.txt")).unwrap();
    let time_of = |event: &str| -> f64 {
        let line = snapshot.lines().find(|line| line.ends_with(event)).unwrap();
        line.split_whitespace().next().unwrap().parse().unwrap()
    };
    let took = time_of("guard: armed") - time_of("guard: ready");
    let page = page("docs/bus.md");
    let (_, stated) = page.split_once("Arming B2P2 takes ").unwrap();
    let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
    assert!(
        (stated - took).abs() < 0.06,
        "the page says {stated} s, the run {took} s"
    );
}

#[test]
fn the_bit_budget_of_b2p2_is_a_third_of_the_bus() {
    // Computed by hand, bits per second: SYNC 55 x 250; set-points 4 x 125 x 250; motions 4 x 135 x
    // 250; conditions 4 x 135 x 50; guard 5 x 135 x 50 and 135 x 10; operator 135 x 50; heartbeats
    // 5 x 65 x 20; torque feed-forward 2 x 75 x 62.5; tension of the belts 75 x 50.
    let sum = 13_750 + 125_000 + 135_000 + 27_000 + 35_100 + 6_750 + 6_500 + 9_375 + 3_750;
    let expected = format!("**{:.1} %** of 1 Mbit/s", f64::from(sum) / 1e4);
    assert!(page("docs/bus.md").contains(&expected), "{expected}");
}

#[test]
fn no_frame_on_the_page_is_without_a_known_payload() {
    assert!(!page("docs/bus.md").contains(": ? |"));
}

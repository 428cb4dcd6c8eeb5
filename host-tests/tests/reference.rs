//! The generated parts of docs/ are what their sources give, and they leave nothing out.

use tautrack::{faults, settings};
use tautrack_host_tests::reference;

fn page(name: &str) -> String {
    let files = reference::files().unwrap_or_else(|error| panic!("{error}"));
    let (_, text) = files
        .into_iter()
        .find(|(path, _)| path.ends_with(name))
        .unwrap_or_else(|| panic!("{name} is not generated"));
    text
}

#[test]
fn committed_pages_and_data_sheets_are_what_their_sources_give() {
    for (path, text) in reference::files().unwrap_or_else(|error| panic!("{error}")) {
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == text,
            "{} is out of date: type `cargo generate` and commit",
            path.display()
        );
    }
}

#[test]
fn every_setting_and_every_fault_has_its_row() {
    let page_of_settings = page("docs/settings.md");
    for row in settings::TABLE {
        let key = format!("| `{:#06x}` | `{}` |", row.key, row.name);
        assert_eq!(page_of_settings.matches(&key).count(), 1, "{key}");
    }
    let page_of_faults = page("docs/faults.md");
    for row in faults::TABLE {
        assert!(page_of_faults.contains(row.remedy), "{row:?}");
    }
}

#[test]
fn the_bit_budget_of_b2p2_is_a_third_of_the_bus() {
    // By hand, bits a second: SYNC 55 x 250; set-points 4 x 125 x 250; motions 4 x 135 x 250; conditions 4 x 135 x 50;
    // guard 4 x 135 x 50 and 135 x 10; operator 135 x 50; heartbeats 5 x 65 x 20; torques in advance 2 x 75 x 62.5.
    let sum = 13_750 + 125_000 + 135_000 + 27_000 + 28_350 + 6_750 + 6_500 + 9_375;
    let expected = format!("**{:.1} %** of 1 Mbit/s", f64::from(sum) / 1e4);
    assert!(page("docs/bus.md").contains(&expected), "{expected}");
}

#[test]
fn no_frame_on_the_page_is_without_a_known_payload() {
    assert!(!page("docs/bus.md").contains(": ? |"));
}

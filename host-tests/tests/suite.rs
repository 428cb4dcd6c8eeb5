//! A sample of the hazard suite; `cargo demo --suite hazards` runs it as a whole.

use tautrack_host_tests::machines;
use tautrack_host_tests::nodes::{self, Board};
use tautrack_host_tests::suite::draw::Kind;
use tautrack_host_tests::suite::drawn_runs;
use tautrack_host_tests::suite::judge::Finding;

#[test]
fn a_few_drawn_hazards_are_held_and_a_few_drawn_legitimate_runs_pass() {
    let programs =
        nodes::build(Board::Native, machines::Kind::B2p2).unwrap_or_else(|error| panic!("{error}"));
    for kind in Kind::ALL {
        let drawn = drawn_runs(kind, 3, 1, &programs, &|_| {}).expect("they run");
        assert_eq!(drawn.rows.len(), 3);
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
}

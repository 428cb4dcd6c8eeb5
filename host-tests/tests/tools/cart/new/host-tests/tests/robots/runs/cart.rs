//! Runs the cart's nodes with its plant: a drive that arrives, and a stop that turns the cart over.

use super::{ends_in_the_same_bits, outcome, scenario};
use tautrack_host_tests::programs::Board;

#[test]
fn the_cart_arrives() {
    let (summary, _) = outcome(&scenario("cart/flat", |_| {}), Board::Host);
    assert!(summary.expectation_met, "{summary}");
    assert!((summary.driven_m - 3.0).abs() < 0.03, "{summary}");
}

#[test]
fn emulated_nodes_and_those_in_this_process_end_in_the_same_bits() {
    ends_in_the_same_bits("cart/flat");
}

#[test]
fn the_guard_holds_what_turns_over_without_it() {
    let [with, without] = [true, false].map(|guard| {
        let changed = scenario("cart/hazards/hard-stop-downhill", |description| {
            description.guard = guard;
        });
        outcome(&changed, Board::Host).0
    });
    assert!(without.toppled, "{without}");
    assert!(!with.toppled && with.guard.interventions > 0, "{with}");
}

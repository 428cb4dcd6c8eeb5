//! Runs the cart's nodes with its plant: a drive that arrives, and a stop that turns the cart over.

use crate::programs::Board;
use crate::results::summary::Summary;
use crate::robots::Kind;
use crate::scenario::Scenario;
use crate::simulator::run::{Options, run};
use std::path::Path;

/// Runs a shipped scenario of the cart.
fn outcome(name: &str, guard: bool) -> Summary {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/cart");
    let scenario = Scenario::load(&folder.join(name)).expect("a scenario");
    let mut description = scenario.description();
    description.guard = guard;
    let scenario = Scenario::checked(description).expect("a scenario");
    let programs = Kind::Cart.programs(Board::Host).expect("programs");
    let outcome = run(&scenario, &programs, Options::default()).expect("a run");
    Summary::new(&scenario, &outcome.facts, &outcome.samples)
}

#[test]
fn the_cart_arrives() {
    let summary = outcome("flat.toml", true);
    assert!(summary.expectation_met, "{summary}");
    assert!((summary.driven_m - 3.0).abs() < 0.03, "{summary}");
}

#[test]
fn the_guard_holds_what_turns_over_without_it() {
    let [with, without] = [true, false].map(|guard| outcome("hazards/hard-stop-downhill.toml", guard));
    assert!(without.toppled, "{without}");
    assert!(!with.toppled && with.guard.interventions > 0, "{with}");
}

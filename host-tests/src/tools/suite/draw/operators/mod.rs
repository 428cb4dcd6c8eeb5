//! Draws an operator who commands at random, on random ground.
//!
//! [`commands`] draws the operator's commands, each robot its ground and its load. Three requests
//! are never drawn: override and back off, which need somebody who watches the robot, and disarm,
//! which lets a robot roll down a slope.

pub mod commands;

use super::generator::Random;
use crate::robots::Kind;
use crate::scenario::{Scenario, ScenarioError};
use crate::tools::robot;

/// Time from arming for which the operator commands, s.
pub const OPERATED_S: f64 = 30.0;

/// Draws the run with this number. `again` counts earlier draws that toppled before the operator
/// commanded anything.
///
/// # Errors
/// A drawn value is out of a scenario's bounds, which is a mistake in a draw.
pub fn draw(
    kind: Kind,
    guard: bool,
    seed: u64,
    number: u64,
    again: u64,
) -> Result<Scenario, ScenarioError> {
    // These keys do not occur in the hazard suite.
    let mut random = Random::new(&[seed, number, (again << 4) | (8 + kind as u64)]);
    let mut drawn = robot::operator(kind, &mut random);
    drawn.name = format!("operator-{seed}-{number}");
    drawn.guard = guard;
    Scenario::checked(drawn)
}

/// Slope on which friction holds a robot, with a reserve of 15 %, degrees.
pub fn standing_deg(friction: f64) -> f64 {
    libm::atan(0.85 * friction).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::OperatorRequest;
    use clap::ValueEnum;
    use std::collections::BTreeSet;

    #[test]
    fn every_draw_is_a_good_scenario_of_its_own_and_a_number_is_always_the_same() {
        for robot in Kind::value_variants() {
            let mut seen = BTreeSet::new();
            for number in 0..300 {
                for again in 0..3 {
                    let draw = || draw(*robot, true, 1, number, again).unwrap();
                    let scenario = draw();
                    assert_eq!(scenario.kind(), *robot);
                    assert_eq!(scenario, draw());
                    let file = toml::to_string(&scenario).unwrap();
                    assert_eq!(Scenario::parse(&file, "drawn").unwrap(), scenario);
                    assert!(seen.insert(file), "{robot:?} {number} {again} came before");
                }
            }
        }
    }

    #[test]
    fn the_guard_is_the_only_difference_between_the_two_runs_of_a_number() {
        let with = draw(Kind::default(), true, 5, 7, 0).unwrap();
        let mut without = draw(Kind::default(), false, 5, 7, 0).unwrap().description();
        assert!(!without.guard);
        without.guard = true;
        assert_eq!(with.description(), without);
    }

    #[test]
    fn operators_request_everything_but_disarm_override_and_back_off() {
        let mut requests = BTreeSet::new();
        for number in 0..100 {
            let scenario = draw(Kind::default(), true, 1, number, 0).unwrap();
            let events = scenario.operator.events.iter();
            requests.extend(events.filter_map(|event| event.request.map(OperatorRequest::as_str)));
        }
        let expected = ["arm", "emergency_stop", "reset", "stop"];
        assert_eq!(requests.into_iter().collect::<Vec<_>>(), expected);
    }
}

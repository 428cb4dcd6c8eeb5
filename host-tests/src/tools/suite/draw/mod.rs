//! Draws scenarios at random.
//!
//! A scenario is determined by its kind, the seed, its number, and how often it was drawn again.
//! [`generator`] makes the random numbers, `beginning` the description that every draw starts from.
//! The hazard suite draws from the families of the default robot, in which the robot starts close
//! to its obstacle, so that a run takes 5 to 12 s of virtual time. [`operators`] draws operators
//! who command at random.

mod beginning;
pub mod generator;
pub mod operators;

use crate::robots::Robot;
use crate::scenario::{Description, Scenario, ScenarioError};
use crate::tools::robot;
use generator::Random;

pub use beginning::beginning;

/// A family draws scenarios of one kind, such as "too fast": its name, and the function that
/// changes the common description to one of this family.
pub type Family = (&'static str, fn(&mut Random, &mut Description));

/// Purpose of a scenario in the hazard suite.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// A run in which the robot topples without the guard.
    Hazard,
    /// A run in which the guard must not hinder the operator.
    Legitimate,
}

impl Kind {
    /// Both kinds, in the order of the suite.
    pub const ALL: [Self; 2] = [Self::Hazard, Self::Legitimate];

    /// Name of the folder with the scenario files of this kind.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Hazard => "hazards",
            Self::Legitimate => "legitimate",
        }
    }
}

/// Draws the scenario of this kind with this number. `again` counts earlier draws that were not of
/// this kind.
///
/// # Errors
/// A drawn value is out of a scenario's bounds, which is a mistake in a family.
pub fn draw(kind: Kind, seed: u64, number: u64, again: u64) -> Result<Scenario, ScenarioError> {
    let mut random = Random::new(&[seed, number, (again << 1) | kind as u64]);
    let families = robot::families(Robot::default().kind(), kind);
    let (family, change) = families[(number % families.len() as u64) as usize];
    let mut drawn = beginning(&mut random);
    change(&mut random, &mut drawn);
    drawn.name = match kind {
        Kind::Hazard => format!("hazard-{number}"),
        Kind::Legitimate => format!("legitimate-{number}"),
    };
    drawn.about = format!("{family}: {}", drawn.about);
    Scenario::checked(drawn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_draw_is_a_good_scenario_of_its_own_and_a_number_is_always_the_same() {
        for kind in Kind::ALL {
            let mut seen = BTreeSet::new();
            for number in 0..300 {
                for again in 0..3 {
                    let scenario = draw(kind, 1, number, again).unwrap();
                    assert_eq!(scenario, draw(kind, 1, number, again).unwrap());
                    let file = toml::to_string(&scenario).unwrap();
                    assert_eq!(Scenario::parse(&file, "drawn").unwrap(), scenario);
                    assert!(seen.insert(file), "{kind:?} {number} {again} came before");
                }
            }
            assert_ne!(draw(kind, 1, 0, 0).unwrap(), draw(kind, 2, 0, 0).unwrap());
        }
    }
}

//! Scenarios drawn at random.
//!
//! A scenario depends on its kind, the seed, its number and how often it was drawn again, and on
//! nothing else. [`generator`] makes the numbers, `hazards`, `manoeuvres` and `legitimate` hold the
//! families of the hazard suite, [`operators`] the operator who commands at random. Here: what the families share. The
//! robot begins near what it drives at, so that a run of a family takes 5 to 12 s of virtual time.

pub mod generator;
mod hazards;
mod legitimate;
mod manoeuvres;
pub mod operators;

use crate::scenario::{
    Description, Event, Expect, Operator, Payload, Robot, Scenario, ScenarioError, Terrain, When,
};
use generator::Random;

/// What a scenario is for.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// Topples without the guard.
    Hazard,
    /// Must not be hindered.
    Legitimate,
}

impl Kind {
    /// Both, in the order of the suite.
    pub const ALL: [Self; 2] = [Self::Hazard, Self::Legitimate];

    /// Name of the folder with the named scenarios of this kind.
    pub fn folder(self) -> &'static str {
        match self {
            Self::Hazard => "hazards",
            Self::Legitimate => "legitimate",
        }
    }
}

/// The scenario of this kind with this number; `again` counts the draws before that were none of the kind.
///
/// # Errors
/// When a drawn value is out of a scenario's bounds: a mistake in a family.
pub fn draw(kind: Kind, seed: u64, number: u64, again: u64) -> Result<Scenario, ScenarioError> {
    let mut random = Random::new(&[seed, number, (again << 1) | kind as u64]);
    let families: &[Family] = match kind {
        Kind::Hazard => hazards::FAMILIES,
        Kind::Legitimate => legitimate::FAMILIES,
    };
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

/// Name of a family, and what it changes of the common beginning.
type Family = (&'static str, fn(&mut Random, &mut Description));

/// What all have in common: the nominal robot on good ground, front up, driving slowly.
fn beginning(random: &mut Random) -> Description {
    Description {
        feed_forward: true,
        name: String::new(),
        about: String::new(),
        seed: random.bits() >> 32,
        duration_s: 14.0,
        guard: true,
        friction: random.between(1.0, 1.2),
        terrain: Terrain::Flat,
        crawler: None,
        hylos: None,
        rt_mover: None,
        robot: Robot {
            k_m: 1.232,
            pulley_radius_m: 0.05,
            com_offset_m: 0.0,
            sensor_noise: random.between(0.5, 3.0),
            payload: None,
        },
        operator: Operator {
            client: false,
            speed_mps: random.between(0.08, 0.18),
            chassis_deg: 45.0,
            step_m: 0.0,
            chassis_rate_deg_s: 28.6,
            heading_gain_per_s: 1.0,
            events: Vec::new(),
        },
        faults: Vec::new(),
        expect: Expect::default(),
    }
}

/// Where a nose is, close to the front of the straight robot, m.
fn near(random: &mut Random) -> f64 {
    random.between(0.83, 0.93)
}

/// Stairs near the robot.
fn stairs(random: &mut Random, riser_m: f64, count: u32, down: bool) -> Terrain {
    Terrain::Stairs {
        riser_m,
        run_m: 0.28,
        count,
        width_m: 3.0,
        first_nose_m: near(random),
        landing_m: 6.0,
        down,
    }
}

/// Conditions, all absent but what `change` sets.
fn when(change: impl FnOnce(&mut When)) -> When {
    let mut when = When::default();
    change(&mut when);
    when
}

/// The chassis to an angle when the first nose has lifted the robot.
fn straighten_to(chassis_deg: f64) -> Event {
    Event {
        when: when(|when| when.pitch_above_deg = Some(8.0)),
        chassis_deg: Some(chassis_deg),
        ..Event::default()
    }
}

/// Stops the robot after this distance.
fn stop_after(way_m: f64) -> Event {
    Event {
        when: when(|when| when.after_m = Some(way_m)),
        speed_mps: Some(0.0),
        ..Event::default()
    }
}

/// Folds the front down, by the belts' way since the first nose, where the centre of gravity is past the last of `count` noses by `late_m`;
/// then straightens and stops.
fn fold_behind(riser_m: f64, count: u32, late_m: f64, chassis_deg: f64) -> [Event; 3] {
    // The nominal climb folds 1.6 m after the first nose: 0.33 m and four steps.
    let steps = f64::from(count - 1) * libm::hypot(riser_m, 0.28);
    [
        Event {
            when: when(|when| {
                when.after_m = Some(0.33 + steps + late_m);
                when.pitch_above_deg = Some(20.0);
            }),
            chassis_deg: Some(chassis_deg),
            ..Event::default()
        },
        Event {
            when: when(|when| {
                when.after_s = Some(0.5);
                when.pitch_below_deg = Some(22.0);
            }),
            chassis_deg: Some(0.0),
            ..Event::default()
        },
        stop_after(0.2),
    ]
}

/// A declared load high above axle 1.
fn load(random: &mut Random, minimum_kg: f64, maximum_kg: f64) -> Payload {
    Payload {
        mass_kg: random.between(minimum_kg, maximum_kg),
        place_m: [
            random.between(0.08, 0.2),
            random.between(-0.03, 0.03),
            random.between(0.2, 0.3),
        ],
        from_s: 0.0,
        declared: true,
    }
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

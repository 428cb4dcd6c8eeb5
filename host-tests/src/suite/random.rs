//! Scenarios drawn at random around the named ones.
//!
//! A scenario depends on its kind, the seed, its number and how often it was drawn again, and on nothing else. The robot begins near what it
//! drives at, so that a run takes 5 to 12 s of virtual time.

use crate::plant::noise::mix;
use crate::scenario::{
    Description, Event, Expect, Operator, Payload, Robot, Scenario, ScenarioError, Terrain, When,
};

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
    let mut random = Random(mix(mix(mix(seed) ^ number) ^ ((again << 1) | kind as u64)));
    let families: &[Family] = match kind {
        Kind::Hazard => HAZARDS,
        Kind::Legitimate => LEGITIMATE,
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

struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(1);
        mix(self.0)
    }

    /// Between the bounds, in steps of a thousandth so that a file shows the value as it is.
    fn between(&mut self, least: f64, most: f64) -> f64 {
        let share = (self.bits() >> 11) as f64 / (1u64 << 53) as f64;
        (1e3 * (least + (most - least) * share)).round() / 1e3
    }

    fn coin(&mut self) -> bool {
        self.bits() & 1 == 0
    }

    fn sign(&mut self) -> f64 {
        if self.coin() { 1.0 } else { -1.0 }
    }
}

type Family = (&'static str, fn(&mut Random, &mut Description));

const HAZARDS: &[Family] = &[
    ("front kept up at the first nose", front_kept_up),
    ("payload", payload),
    ("raised body", raised_body),
    ("riser too high", high_riser),
    ("too fast", too_fast),
    ("curb with the front up", curb_front_up),
    ("front raised on a side slope", raised_on_side_slope),
    ("front up on a steep ramp", steep_ramp),
    ("folded too early", folded_too_early),
];

const LEGITIMATE: &[Family] = &[
    ("two steps", two_steps),
    ("low curb", low_curb),
    ("flat ground", flat_ground),
    ("side slope", side_slope),
    ("ramp", ramp),
    ("descent", descent),
    ("small load", small_load),
];

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

fn front_kept_up(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.17);
    drawn.terrain = stairs(random, riser, 3, false);
    let kept = if random.coin() {
        drawn.operator.chassis_deg = random.between(40.0, 65.0);
        drawn.operator.chassis_deg
    } else {
        let kept = random.between(18.0, 38.0);
        drawn.operator.events.push(straighten_to(kept));
        kept
    };
    let speed = drawn.operator.speed_mps;
    drawn.about = format!("{kept} degrees, riser {riser} m, {speed} m/s");
}

fn payload(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    let load = load(random, 1.0, 4.0);
    drawn.about = format!(
        "{} kg at {:?} m, riser {riser} m, {} m/s",
        load.mass_kg, load.place_m, drawn.operator.speed_mps
    );
    drawn.robot.payload = Some(load);
    drawn.operator.events.push(straighten_to(0.0));
}

fn load(random: &mut Random, least_kg: f64, most_kg: f64) -> Payload {
    Payload {
        mass_kg: random.between(least_kg, most_kg),
        place_m: [
            random.between(0.08, 0.2),
            random.between(-0.03, 0.03),
            random.between(0.2, 0.3),
        ],
        from_s: 0.0,
        declared: true,
    }
}

fn raised_body(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.robot.com_offset_m = random.between(0.03, 0.08);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!(
        "{} m higher, riser {riser} m, {} m/s",
        drawn.robot.com_offset_m, drawn.operator.speed_mps
    );
}

fn high_riser(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.168, 0.2);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!("{riser} m, {} m/s", drawn.operator.speed_mps);
}

fn too_fast(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.14, 0.16);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.speed_mps = random.between(0.3, 0.5);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!("{} m/s, riser {riser} m", drawn.operator.speed_mps);
}

fn curb_front_up(random: &mut Random, drawn: &mut Description) {
    let height_m = random.between(0.15, 0.3);
    drawn.terrain = Terrain::Curb {
        height_m,
        // Far enough for the front to rise without touching the face: caught by it, the rear rises instead.
        nose_m: near(random) + 0.1,
        depth_m: 6.0,
    };
    drawn.operator.chassis_deg = random.between(45.0, 75.0);
    drawn.about = format!(
        "{height_m} m, {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn raised_on_side_slope(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let side = if loaded {
        random.between(48.0, 55.0)
    } else {
        random.between(57.0, 62.0)
    };
    drawn.robot.payload = loaded.then(|| load(random, 1.5, 4.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Slope {
        angle_deg: 0.0,
        side_deg: random.sign() * side,
    };
    drawn.operator.speed_mps = 0.0;
    drawn.operator.chassis_deg = random.between(85.0, 99.0);
    let mass = drawn
        .robot
        .payload
        .as_ref()
        .map_or(0.0, |load| load.mass_kg);
    drawn.about = format!(
        "{side} degrees, to {} degrees, {mass} kg",
        drawn.operator.chassis_deg
    );
}

fn steep_ramp(random: &mut Random, drawn: &mut Description) {
    let loaded = random.coin();
    let angle = if loaded {
        random.between(50.0, 57.0)
    } else {
        random.between(58.0, 64.0)
    };
    drawn.robot.payload = loaded.then(|| load(random, 1.5, 4.0));
    drawn.friction = 2.5;
    drawn.terrain = Terrain::Ramp {
        angle_deg: angle,
        foot_m: near(random),
        length_m: 4.0,
    };
    drawn.duration_s = 18.0;
    drawn.operator.chassis_deg = random.between(75.0, 95.0);
    let mass = drawn
        .robot
        .payload
        .as_ref()
        .map_or(0.0, |load| load.mass_kg);
    drawn.about = format!(
        "{angle} degrees, front at {} degrees, {mass} kg, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn folded_too_early(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.145, 0.155);
    drawn.terrain = stairs(random, riser, 2, false);
    let early = random.between(0.15, 0.32);
    drawn.operator.speed_mps = random.between(0.1, 0.15);
    drawn.operator.events.push(straighten_to(0.0));
    drawn
        .operator
        .events
        .extend(fold_behind(riser, 2, -early, random.between(-50.0, -35.0)));
    drawn.about = format!(
        "by {early} m, riser {riser} m, {} m/s",
        drawn.operator.speed_mps
    );
}

fn two_steps(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.1, 0.15);
    drawn.terrain = stairs(random, riser, 2, false);
    drawn.operator.speed_mps = random.between(0.1, 0.15);
    drawn.operator.chassis_deg = random.between(35.0, 50.0);
    drawn.operator.events.push(straighten_to(0.0));
    let folds = random.coin();
    if folds {
        let fold = fold_behind(riser, 2, random.between(0.02, 0.08), -25.0);
        drawn.operator.events.extend(fold);
    }
    let how = if folds { "folded" } else { "straight" };
    drawn.about = format!("riser {riser} m, {how}, {} m/s", drawn.operator.speed_mps);
}

fn low_curb(random: &mut Random, drawn: &mut Description) {
    let height_m = random.between(0.03, 0.1);
    drawn.terrain = Terrain::Curb {
        height_m,
        nose_m: near(random),
        depth_m: 6.0,
    };
    drawn.operator.chassis_deg = random.between(20.0, 45.0);
    drawn.operator.events = vec![straighten_to(0.0), stop_after(0.6)];
    drawn.about = format!("{height_m} m, {} m/s", drawn.operator.speed_mps);
}

fn flat_ground(random: &mut Random, drawn: &mut Description) {
    drawn.duration_s = 10.0;
    drawn.operator.speed_mps = random.between(-0.3, 0.4);
    drawn.operator.chassis_deg = random.between(-20.0, 60.0);
    let yaw_rate = random.between(-25.0, 25.0);
    drawn.operator.events = vec![Event {
        when: when(|when| when.after_s = Some(3.0)),
        chassis_deg: Some(random.between(-20.0, 60.0)),
        yaw_rate_deg_s: Some(yaw_rate),
        ..Event::default()
    }];
    drawn.about = format!("{} m/s, {yaw_rate} degrees/s", drawn.operator.speed_mps);
}

fn side_slope(random: &mut Random, drawn: &mut Description) {
    drawn.duration_s = 8.0;
    // The higher the front, the gentler the slope.
    let chassis = random.between(0.0, 60.0);
    let side = random.sign() * random.between(5.0, 30.0 - 0.25 * chassis);
    drawn.terrain = Terrain::Slope {
        angle_deg: random.between(-8.0, 8.0),
        side_deg: side,
    };
    drawn.operator.chassis_deg = chassis;
    drawn.about = format!(
        "{side} degrees, front at {chassis} degrees, {} m/s",
        drawn.operator.speed_mps
    );
}

fn ramp(random: &mut Random, drawn: &mut Description) {
    let angle_deg = random.between(5.0, 28.0);
    drawn.terrain = Terrain::Ramp {
        angle_deg,
        foot_m: near(random),
        length_m: random.between(0.4, 1.0),
    };
    drawn.operator.chassis_deg = random.between(0.0, 30.0);
    drawn.operator.speed_mps = random.between(0.12, 0.25);
    drawn.about = format!(
        "{angle_deg} degrees, front at {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn descent(random: &mut Random, drawn: &mut Description) {
    let riser = random.between(0.06, 0.15);
    let count = if random.coin() { 1 } else { 2 };
    drawn.terrain = stairs(random, riser, count, true);
    drawn.operator.speed_mps = random.between(0.1, 0.18);
    drawn.operator.chassis_deg = random.between(-12.0, 0.0);
    drawn.operator.events = vec![Event {
        when: when(|when| when.pitch_below_deg = Some(-8.0)),
        chassis_deg: Some(0.0),
        ..Event::default()
    }];
    drawn.about = format!(
        "{count} of {riser} m, front at {} degrees, {} m/s",
        drawn.operator.chassis_deg, drawn.operator.speed_mps
    );
}

fn small_load(random: &mut Random, drawn: &mut Description) {
    let mut load = load(random, 0.1, 0.5);
    load.declared = random.coin();
    let riser = random.between(0.1, 0.14);
    drawn.terrain = stairs(random, riser, 3, false);
    drawn.operator.events.push(straighten_to(0.0));
    drawn.about = format!(
        "{} kg, declared {}, riser {riser} m, {} m/s",
        load.mass_kg, load.declared, drawn.operator.speed_mps
    );
    drawn.robot.payload = Some(load);
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

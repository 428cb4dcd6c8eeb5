//! Parts that the families of the hazard suite share. A family draws scenarios of one kind, such as
//! "too fast".

use super::generator::Random;
use crate::robots::Robot;
use crate::robots::b2p2::section::B2p2;
use crate::robots::payload::Payload;
use crate::scenario::{Description, Event, Expect, Operator, Sensors, When};
use crate::world::terrain::Terrain;
use std::collections::BTreeMap;

/// Name of a family, and the function that changes the common description to one of this family.
pub(super) type Family = (&'static str, fn(&mut Random, &mut Description));

/// The description that all families start from: the nominal robot on good ground, front raised,
/// driving slowly.
pub(super) fn beginning(random: &mut Random) -> Description {
    Description {
        feed_forward: true,
        name: String::new(),
        about: String::new(),
        seed: random.bits() >> 32,
        duration_s: 14.0,
        guard: true,
        friction: random.between(1.0, 1.2),
        terrain: Terrain::Flat,
        robot: Robot::B2p2(B2p2 {
            sensor_noise: random.between(0.5, 3.0),
            ..B2p2::nominal()
        }),
        operator: Operator {
            client: false,
            speed_mps: random.between(0.08, 0.18),
            chassis_deg: 45.0,
            step_m: 0.0,
            chassis_rate_deg_s: 28.6,
            heading_gain_per_s: 1.0,
            request: None,
            events: Vec::new(),
        },
        motors: BTreeMap::new(),
        sensors: Sensors::default(),
        settings: BTreeMap::new(),
        faults: Vec::new(),
        hand: Vec::new(),
        expect: Expect::default(),
    }
}

/// Draws the x of a nose, close to the front of the straight robot, m.
pub(super) fn near(random: &mut Random) -> f64 {
    random.between(0.83, 0.93)
}

/// Stairs close to the robot.
pub(super) fn stairs(random: &mut Random, riser_m: f64, count: u32, down: bool) -> Terrain {
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

/// Conditions of an event: all absent except those that `change` sets.
pub(super) fn when(change: impl FnOnce(&mut When)) -> When {
    let mut when = When::default();
    change(&mut when);
    when
}

/// Event that moves the chassis to an angle as soon as the first nose has lifted the robot.
pub(super) fn straighten_to(chassis_deg: f64) -> Event {
    Event {
        when: when(|when| when.pitch_above_deg = Some(8.0)),
        chassis_deg: Some(chassis_deg),
        ..Event::default()
    }
}

/// Event that stops the robot after this distance.
pub(super) fn stop_after(way_m: f64) -> Event {
    Event {
        when: when(|when| when.after_m = Some(way_m)),
        speed_mps: Some(0.0),
        ..Event::default()
    }
}

/// Events that fold the front down when the centre of gravity is `late_m` past the last of `count`
/// noses, then straighten the robot and stop it. The place is given as the belts' travel since the
/// first nose.
pub(super) fn fold_behind(riser_m: f64, count: u32, late_m: f64, chassis_deg: f64) -> [Event; 3] {
    // The nominal climb folds 1.6 m after the first nose: 0.33 m plus four steps.
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

/// Mass of the robot's load, kg; 0 without a load.
pub(super) fn mass(robot: &B2p2) -> f64 {
    robot.payload.as_ref().map_or(0.0, |load| load.mass_kg)
}

/// Draws a declared load high above axle 1.
pub(super) fn load(random: &mut Random, minimum_kg: f64, maximum_kg: f64) -> Payload {
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

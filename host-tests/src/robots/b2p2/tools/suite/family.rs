//! Parts that B2P2's families of the hazard suite share.

use crate::robots::b2p2::section::B2p2;
use crate::robots::payload::Payload;
use crate::scenario::{Event, When};
use crate::tools::suite::draw::generator::Random;
use crate::world::terrain::Terrain;

/// Draws the x of a nose, close to the front of the straight robot, m.
pub fn near(random: &mut Random) -> f64 {
    random.between(0.83, 0.93)
}

/// Stairs close to the robot.
pub fn stairs(random: &mut Random, riser_m: f64, count: u32, down: bool) -> Terrain {
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
pub fn when(change: impl FnOnce(&mut When)) -> When {
    let mut when = When::default();
    change(&mut when);
    when
}

/// Event that moves the chassis to an angle as soon as the first nose has lifted the robot.
pub fn straighten_to(chassis_deg: f64) -> Event {
    Event {
        when: when(|when| when.pitch_above_deg = Some(8.0)),
        chassis_deg: Some(chassis_deg),
        ..Event::default()
    }
}

/// Event that stops the robot after this distance.
pub fn stop_after(way_m: f64) -> Event {
    Event {
        when: when(|when| when.after_m = Some(way_m)),
        speed_mps: Some(0.0),
        ..Event::default()
    }
}

/// Events that fold the front down when the centre of gravity is `late_m` past the last of `count`
/// noses, then straighten the robot and stop it. The place is given as the belts' travel since the
/// first nose.
pub fn fold_behind(riser_m: f64, count: u32, late_m: f64, chassis_deg: f64) -> [Event; 3] {
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
pub fn mass(robot: &B2p2) -> f64 {
    robot.payload.as_ref().map_or(0.0, |load| load.mass_kg)
}

/// Draws a declared load high above axle 1.
pub fn load(random: &mut Random, minimum_kg: f64, maximum_kg: f64) -> Payload {
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

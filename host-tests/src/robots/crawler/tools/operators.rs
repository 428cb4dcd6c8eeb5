//! Draws the crawler's runs: slopes, ramps and flat ground, any soil that carries the robot,
//! declared loads.

use crate::robots::Robot;
use crate::robots::crawler::section::{Crawler, SlipCompensation, Soil};
use crate::robots::payload::Payload;
use crate::scenario::Description;
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::operators::commands::{Controls, commands};
use crate::tools::suite::draw::operators::{OPERATED_S, standing_deg};
use crate::world::terrain::Terrain;

/// Upper bound of the time until the robot is armed, s.
const ARMING_S: f64 = 1.0;

const CONTROLS: Controls = Controls {
    speed_mps: [-0.5, 0.5],
    yaw_deg_s: 90.0,
    posture: None,
    weights: [0.5, 0.35, 0.0, 0.15],
};

pub fn draw(random: &mut Random) -> Description {
    let mut drawn = beginning(random);
    drawn.duration_s = ARMING_S + OPERATED_S;
    drawn.friction = random.between(0.8, 1.3);
    let friction_deg = random.between(22.0, 38.0);
    let cohesion_pa = random.between(500.0, 8_000.0).round();
    let compensation = [
        (SlipCompensation::None, 1.0),
        (SlipCompensation::Soil, 1.0),
        (SlipCompensation::Measured, 1.0),
    ];
    let load = random.chance(0.6).then(|| load(random));
    let mass = load.as_ref().map_or(0.0, |load| load.mass_kg);
    drawn.robot = Robot::Crawler(Crawler {
        soil: Soil {
            cohesion_pa,
            friction_deg,
            k1_per_m: random.between(40.0, 200.0),
            k2: 1.0,
        },
        slip_compensation: random.weighted(&compensation).unwrap_or_default(),
        acceleration_mps2: random.between(0.2, 4.0),
        payload: load,
    });
    // On steeper slopes cohesion may still hold a light robot, but the draw does not rely on it.
    let steepest = standing_deg(drawn.friction * libm::tan(friction_deg.to_radians()));
    let (terrain, about) = ground(random, steepest);
    drawn.terrain = terrain;
    drawn.operator.speed_mps = 0.0;
    drawn.operator.chassis_deg = 0.0;
    drawn.operator.heading_gain_per_s = 0.0;
    drawn.operator.events = commands(random, &CONTROLS);
    drawn.about = format!("{about}, soil {cohesion_pa} Pa and {friction_deg} degrees, {mass} kg");
    drawn
}

fn load(random: &mut Random) -> Payload {
    Payload {
        mass_kg: random.between(0.2, 2.5),
        place_m: [
            random.between(-0.02, 0.02),
            random.between(-0.02, 0.02),
            random.between(0.05, 0.25),
        ],
        from_s: 0.0,
        declared: true,
    }
}

fn ground(random: &mut Random, steepest: f64) -> (Terrain, String) {
    let rise = random.between(4.0, steepest);
    match random.weighted(&[(0, 0.55), (1, 0.3), (2, 0.15)]) {
        Some(0) => {
            let aside = random.between(0.0, 1.0);
            let angle_deg = (random.sign() * rise * (1.0 - aside) * 1e3).round() / 1e3;
            let side_deg = (random.sign() * rise * aside * 1e3).round() / 1e3;
            let about = format!("slope of {angle_deg} degrees, {side_deg} to the side");
            let slope = Terrain::Slope {
                angle_deg,
                side_deg,
            };
            (slope, about)
        }
        Some(1) => {
            let ramp = Terrain::Ramp {
                angle_deg: rise,
                foot_m: random.between(0.2, 0.6),
                length_m: random.between(0.4, 3.0),
            };
            (ramp, format!("ramp of {rise} degrees"))
        }
        _ => (Terrain::Flat, "flat ground".into()),
    }
}

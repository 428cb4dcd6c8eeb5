//! Draws RT-Mover's runs: steps up, slopes and flat ground, and declared loads.

use crate::robots::Robot;
use crate::robots::payload::Payload;
use crate::robots::rt_mover::section::RtMover;
use crate::scenario::{Description, Event};
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::operators::commands::{Controls, commands};
use crate::tools::suite::draw::operators::{OPERATED_S, standing_deg};
use crate::world::terrain::Terrain;

/// Upper bound of the time until the robot is armed, s.
const HOMING_S: f64 = 6.0;
/// Foremost point of the robot at the start, m.
const FRONT_M: f64 = 0.4;

const CONTROLS: Controls = Controls {
    speed_mps: [-0.5, 0.5],
    yaw_deg_s: 30.0,
    posture: Some(step),
    weights: [0.36, 0.2, 0.32, 0.12],
};

/// Draws a command for the gait with a random step height, or in one of four cases the end of the
/// gait.
fn step(random: &mut Random, event: &mut Event) {
    let height = random.between(0.02, 0.2);
    event.step_m = Some(if random.chance(0.25) { 0.0 } else { height });
}

pub fn draw(random: &mut Random) -> Description {
    let mut drawn = beginning(random);
    drawn.duration_s = HOMING_S + OPERATED_S;
    drawn.friction = random.between(0.7, 1.3);
    let payload = random.chance(0.6).then(|| load(random));
    let mass = payload.as_ref().map_or(0.0, |load| load.mass_kg);
    drawn.robot = Robot::RtMover(RtMover { payload });
    let (terrain, about) = ground(random, standing_deg(drawn.friction).min(12.0));
    drawn.terrain = terrain;
    drawn.operator.speed_mps = random.between(-0.1, 0.3);
    drawn.operator.chassis_deg = 0.0;
    drawn.operator.heading_gain_per_s = 0.0;
    drawn.operator.events = commands(random, &CONTROLS);
    drawn.about = format!("{about}, friction {}, {mass} kg", drawn.friction);
    drawn
}

fn load(random: &mut Random) -> Payload {
    Payload {
        mass_kg: random.between(0.5, 14.0),
        place_m: [
            random.between(0.0, 0.08),
            random.between(-0.3, 0.3),
            random.between(0.1, 0.5),
        ],
        from_s: 0.0,
        declared: true,
    }
}

fn ground(random: &mut Random, steepest: f64) -> (Terrain, String) {
    match random.weighted(&[(0, 0.55), (1, 0.25), (2, 0.2)]) {
        Some(0) => {
            let height_m = random.between(0.03, 0.2);
            let curb = Terrain::Curb {
                height_m,
                nose_m: FRONT_M + random.between(0.05, 0.5),
                depth_m: 6.0,
            };
            (curb, format!("curb {height_m} m"))
        }
        Some(1) => {
            let angle_deg = random.between(-steepest, steepest);
            let side_deg = random.between(-steepest, steepest);
            let slope = Terrain::Slope {
                angle_deg,
                side_deg,
            };
            let about = format!("slope of {angle_deg} degrees, {side_deg} to the side");
            (slope, about)
        }
        _ => (Terrain::Flat, "flat ground".into()),
    }
}

//! Draws Hylos' runs: hillsides with waves, any heading and clearance, with and without posture
//! control.

use crate::robots::Robot;
use crate::robots::hylos::section::Hylos;
use crate::scenario::{Description, Event};
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::operators::commands::{Controls, commands};
use crate::tools::suite::draw::operators::{OPERATED_S, standing_deg};
use crate::world::terrain::Terrain;

/// Upper bound of the time until the robot is armed, s.
const HOMING_S: f64 = 4.0;

const CONTROLS: Controls = Controls {
    speed_mps: [-0.5, 0.5],
    yaw_deg_s: 40.0,
    posture: Some(clearance),
    weights: [0.42, 0.26, 0.18, 0.14],
};

fn clearance(random: &mut Random, event: &mut Event) {
    event.clearance_m = Some(random.between(0.2, 0.38));
}

pub fn draw(random: &mut Random) -> Description {
    let mut drawn = beginning(random);
    drawn.duration_s = HOMING_S + OPERATED_S;
    drawn.friction = random.between(0.9, 1.5);
    // The robot stays upright on slopes of up to 50 degrees with posture control, and up to 40
    // degrees without. The drawn slopes stay below both.
    let posture_control = random.chance(0.7);
    let steepest = standing_deg(drawn.friction).min(if posture_control { 42.0 } else { 38.0 });
    let slope_deg = random.between(5.0, steepest);
    let wave_height_m = random.between(0.0, 0.02);
    let heading_deg = random.between(-180.0, 180.0);
    drawn.terrain = if random.chance(0.85) {
        Terrain::Hillside {
            slope_deg,
            foot_m: random.between(1.0, 2.0),
            wave_height_m,
        }
    } else {
        Terrain::Flat
    };
    drawn.robot = Robot::Hylos(Hylos {
        posture_control,
        clearance_m: random.between(0.22, 0.36),
        acceleration_mps2: random.between(0.2, 2.0),
        heading_deg,
    });
    drawn.operator.speed_mps = random.between(0.0, 0.4);
    drawn.operator.chassis_deg = 0.0;
    drawn.operator.heading_gain_per_s = 0.0;
    drawn.operator.events = commands(random, &CONTROLS);
    let level = matches!(drawn.terrain, Terrain::Flat);
    let ground = if level {
        "flat ground".into()
    } else {
        format!("hillside of {slope_deg} degrees with waves of {wave_height_m} m")
    };
    drawn.about = format!(
        "{ground}, heading {heading_deg} degrees, posture control {posture_control}, friction {}",
        drawn.friction
    );
    drawn
}

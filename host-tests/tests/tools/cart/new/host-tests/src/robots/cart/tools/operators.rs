//! Draws the cart's runs: slopes and flat ground, any height of the mast.

use crate::robots::Robot;
use crate::robots::cart::section::Cart;
use crate::scenario::Description;
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::operators::commands::{Controls, commands};
use crate::tools::suite::draw::operators::{OPERATED_S, standing_deg};
use crate::world::terrain::Terrain;

/// Upper bound of the time until the robot is armed, s.
const ARMING_S: f64 = 1.0;
/// Maximum slope, degrees; on steeper ones the cart falls over at rest.
const STEEPEST_DEG: f64 = 12.0;

const CONTROLS: Controls = Controls {
    speed_mps: [-0.5, 0.5],
    yaw_deg_s: 60.0,
    posture: None,
    weights: [0.5, 0.35, 0.0, 0.15],
};

pub fn draw(random: &mut Random) -> Description {
    let mut drawn = beginning(random);
    drawn.duration_s = ARMING_S + OPERATED_S;
    drawn.friction = random.between(0.7, 1.3);
    let mast_m = random.between(0.3, 1.0);
    drawn.robot = Robot::Cart(Cart {
        mast_m,
        acceleration_mps2: random.between(0.2, 3.0),
    });
    let steepest = standing_deg(drawn.friction).min(STEEPEST_DEG);
    let angle_deg = (random.sign() * random.between(0.0, steepest) * 1e3).round() / 1e3;
    drawn.terrain = Terrain::Slope {
        angle_deg,
        side_deg: 0.0,
    };
    drawn.operator.speed_mps = 0.0;
    drawn.operator.chassis_deg = 0.0;
    drawn.operator.heading_gain_per_s = 0.0;
    drawn.operator.events = commands(random, &CONTROLS);
    drawn.about = format!("slope of {angle_deg} degrees, mast of {mast_m} m");
    drawn
}

//! Draws B2P2's runs: stairs up, curbs, ramps, side slopes and flat ground; belts of different
//! lengths, declared loads.

use super::suite::mass;
use crate::robots::payload::Payload;
use crate::scenario::{Description, Event};
use crate::tools::suite::draw::beginning;
use crate::tools::suite::draw::generator::Random;
use crate::tools::suite::draw::operators::commands::{Controls, commands};
use crate::tools::suite::draw::operators::{OPERATED_S, standing_deg};
use crate::world::terrain::Terrain;

/// Upper bound of the time until the robot is armed, s.
const HOMING_S: f64 = 4.5;

const CONTROLS: Controls = Controls {
    speed_mps: [-0.5, 0.5],
    yaw_deg_s: 60.0,
    posture: Some(chassis),
    weights: [0.38, 0.16, 0.32, 0.14],
};

#[derive(Clone, Copy)]
enum Ground {
    Stairs,
    Curb,
    Ramp,
    Slope,
    Flat,
}

/// Draws an angle of the chassis joint; one in four is at an end of its travel.
fn chassis(random: &mut Random, event: &mut Event) {
    let drawn = random.between(-59.5, 99.5);
    let exact = [(Some(-59.5), 1.0), (Some(99.5), 1.0), (None, 6.0)];
    event.chassis_deg = Some(random.weighted(&exact).flatten().unwrap_or(drawn));
}

pub fn draw(random: &mut Random) -> Description {
    let mut drawn = beginning(random);
    drawn.duration_s = HOMING_S + OPERATED_S;
    drawn.friction = random.between(0.7, 1.3);
    drawn.robot.b2p2_mut().k_m = random.between(1.0, 1.4);
    drawn.robot.b2p2_mut().payload = random.chance(0.6).then(|| load(random));
    // Axle 3 of the straight robot is at (K + 0.32) / 2, its belt 0.05 m farther.
    let front = 0.5 * (drawn.robot.b2p2_mut().k_m + 0.32) + 0.05;
    let (terrain, about) = ground(random, front, standing_deg(drawn.friction));
    drawn.terrain = terrain;
    let operator = &mut drawn.operator;
    operator.speed_mps = 0.0;
    operator.chassis_deg = 0.0;
    operator.chassis_rate_deg_s = random.between(15.0, 180.0);
    operator.heading_gain_per_s = 0.0;
    // Half of the operators begin by driving at the obstacle with the front raised.
    if random.coin() {
        operator.speed_mps = random.between(0.1, 0.4);
        operator.chassis_deg = random.between(20.0, 60.0);
        operator.heading_gain_per_s = 1.0;
    }
    operator.events = commands(random, &CONTROLS);
    let mass = mass(drawn.robot.b2p2_mut());
    drawn.about = format!(
        "{about}, friction {}, K {} m, {mass} kg",
        drawn.friction,
        drawn.robot.b2p2_mut().k_m
    );
    drawn
}

fn load(random: &mut Random) -> Payload {
    Payload {
        mass_kg: random.between(0.2, 4.0),
        place_m: [
            random.between(0.0, 0.3),
            random.between(-0.08, 0.08),
            random.between(0.05, 0.3),
        ],
        from_s: 0.0,
        declared: true,
    }
}

fn ground(random: &mut Random, front: f64, steepest: f64) -> (Terrain, String) {
    let kinds = [
        (Ground::Stairs, 0.4),
        (Ground::Curb, 0.15),
        (Ground::Ramp, 0.15),
        (Ground::Slope, 0.2),
        (Ground::Flat, 0.1),
    ];
    let ahead = front + random.between(0.01, 0.4);
    match random.weighted(&kinds).unwrap_or(Ground::Flat) {
        Ground::Stairs => {
            let riser = random.between(0.08, 0.18);
            let run = random.between(0.24, 0.34);
            let stairs = Terrain::Stairs {
                riser_m: riser,
                run_m: run,
                count: 2 + random.below(4) as u32,
                width_m: random.between(1.8, 4.0),
                first_nose_m: ahead,
                landing_m: random.between(3.0, 6.0),
                down: false,
            };
            (stairs, format!("stairs {riser} by {run} m"))
        }
        Ground::Curb => {
            let height_m = random.between(0.03, 0.3);
            let curb = Terrain::Curb {
                height_m,
                nose_m: ahead,
                depth_m: random.between(2.0, 6.0),
            };
            (curb, format!("curb {height_m} m"))
        }
        Ground::Ramp => {
            let angle_deg = random.between(5.0, steepest);
            let ramp = Terrain::Ramp {
                angle_deg,
                foot_m: ahead,
                length_m: random.between(0.4, 3.0),
            };
            (ramp, format!("ramp of {angle_deg} degrees"))
        }
        Ground::Slope => {
            // The slopes in both directions add up to `rise`, so the plane is not steeper than
            // that.
            let rise = random.between(5.0, steepest);
            let aside = random.between(0.0, 1.0);
            let angle_deg = (random.sign() * rise * (1.0 - aside) * 1e3).round() / 1e3;
            let side_deg = (random.sign() * rise * aside * 1e3).round() / 1e3;
            let slope = Terrain::Slope {
                angle_deg,
                side_deg,
            };
            let about = format!("slope of {angle_deg} degrees, {side_deg} to the side");
            (slope, about)
        }
        Ground::Flat => (Terrain::Flat, "flat ground".into()),
    }
}

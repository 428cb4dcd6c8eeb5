//! Counts Hylos' guard and its controller.

use crate::cost::counter::Table;
use crate::cost::guards::{at, count_guard};
use core::f32::consts::TAU;
use core::hint::black_box;
use tautrack::math;
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::{Controller, Desired, Hylos, Parameters, Potential, Sensed};

pub fn count(table: &mut Table) -> Option<()> {
    count_controller(table)?;
    let [hip, knee] = stance(&Parameters::<f32>::nominal(), 0.29)
        .map(|angle| (angle * (16_777_216.0 / TAU)) as i32);
    // Each leg has four motors: hip, knee, steering, wheel.
    count_guard::<Hylos>(table, "guard tick of Hylos", 8, 0.05, |drive, tick| {
        at([hip, knee, 0, 0][drive & 3] + (tick & 0xff) as i32)
    })
}

/// Counts a step of a robot that stands on a slope in any direction; some of these slopes would
/// topple it.
fn count_controller(table: &mut Table) -> Option<()> {
    let parameters = black_box(Parameters::<f32>::nominal());
    let sensed = Sensed {
        legs: [stance(&parameters, 0.29); 4],
        torques: [[0.0; 2]; 4],
        steering: [0.0; 4],
        up: [0.0, 0.0, 1.0],
        acceleration: [0.0; 3],
    };
    let desired = Desired {
        forward: 0.0,
        yaw_rate: 0.0,
        clearance: Some(0.29),
    };
    let potential = Potential::new(black_box(0.004), 0.35, 0.02).ok()?;
    let controller = Controller::new(parameters, potential, &sensed);
    table.kernel(
        "body controller of Hylos",
        &mut (controller, sensed, desired),
        |(_, sensed, desired), _, random| {
            let [x, y] = random.near([0.0; 2], 0.6);
            sensed.up = [x, y, math::sqrt(1.0 - x * x - y * y)];
            sensed.legs = [[0.5, 1.1]; 4].map(|leg| random.near(leg, 0.4));
            sensed.torques = [[0.0; 2]; 4].map(|leg| random.near(leg, 20.0));
            sensed.steering = random.near([0.0; 4], 0.5);
            [desired.forward, desired.yaw_rate] = random.near([0.0; 2], 0.3);
        },
        |(controller, sensed, desired)| {
            controller.step(sensed, desired, 0.008);
        },
    )
}

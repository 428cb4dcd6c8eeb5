//! Counts one step of the body controller of Hylos.

use super::counter::Table;
use super::inputs::Random;
use core::hint::black_box;
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::{Controller, Desired, Parameters, Potential, Sensed};

struct State {
    controller: Controller<f32>,
    sensed: Sensed<f32>,
    desired: Desired<f32>,
}

/// Sets the state of a robot that stands on a slope in any direction; some of these slopes would
/// topple it.
fn sensed(state: &mut State, _: u32, random: &mut Random) {
    let [x, y] = [random.within(0.6), random.within(0.6)];
    state.sensed.up = [x, y, tautrack::math::sqrt(1.0 - x * x - y * y)];
    for leg in &mut state.sensed.legs {
        *leg = [0.5 + random.within(0.4), 1.1 + random.within(0.4)];
    }
    for torque in state.sensed.torques.as_flattened_mut() {
        *torque = random.within(20.0);
    }
    for angle in &mut state.sensed.steering {
        *angle = random.within(0.5);
    }
    state.desired.forward = random.within(0.3);
    state.desired.yaw_rate = random.within(0.3);
}

pub fn count(table: &mut Table) {
    let parameters = black_box(Parameters::<f32>::nominal());
    let sensed_first = Sensed {
        legs: [stance(&parameters, 0.29); 4],
        torques: [[0.0; 2]; 4],
        steering: [0.0; 4],
        up: [0.0, 0.0, 1.0],
        acceleration: [0.0; 3],
    };
    let Ok(potential) = Potential::new(black_box(0.004), 0.35, 0.02) else {
        return;
    };
    let mut state = black_box(State {
        controller: Controller::new(parameters, potential, &sensed_first),
        sensed: sensed_first,
        desired: Desired {
            forward: 0.0,
            yaw_rate: 0.0,
            clearance: Some(0.29),
        },
    });
    table.kernel(
        "body controller of Hylos",
        &mut state,
        sensed,
        |state, ()| {
            state.controller.step(&state.sensed, &state.desired, 0.008);
        },
    );
}

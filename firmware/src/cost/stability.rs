//! Counts the centre of gravity and the margins of B2P2. To count the functions of another model,
//! add one `table.kernel` call per function here.

use super::counter::Table;
use super::inputs::{Random, angle, settings};
use core::hint::black_box;
use tautrack::robots::b2p2::Model;
use tautrack::stability::support::margins;
use tautrack::units::Angle;

struct State {
    model: Model,
    support: [[f32; 3]; 4],
    cog: [f32; 3],
    margins: [f32; 4],
}

/// Returns a chassis angle and an extension of the screw, and sets a support whose corners are near
/// the robot's.
fn shape(state: &mut State, call: u32, random: &mut Random) -> (Angle, f32) {
    state.support = [[0.0, -0.16], [0.77, -0.16], [0.77, 0.16], [0.0, 0.16]].map(|corner| {
        [
            corner[0] + random.within(0.1),
            corner[1] + random.within(0.1),
            0.0,
        ]
    });
    if call == 0 {
        state.support = [[0.1; 3]; 4];
    }
    state.cog = [
        0.3 + random.within(0.3),
        random.within(0.2),
        random.within(0.3),
    ];
    (angle(call), 0.4 + random.within(0.2))
}

pub fn count(table: &mut Table) {
    let mut state = black_box(State {
        model: Model::new(&settings()),
        support: [[0.0; 3]; 4],
        cog: [0.0; 3],
        margins: [0.0; 4],
    });
    table.kernel("CoG of B2P2", &mut state, shape, |state, (theta, l3)| {
        state.cog = state.model.shape(theta, l3).cog;
    });
    table.kernel("four margins", &mut state, shape, |state, _| {
        state.margins = margins(&state.support, state.cog);
    });
    table.kernel(
        "CoG and four margins",
        &mut state,
        shape,
        |state, (theta, l3)| {
            let cog = state.model.shape(theta, l3).cog;
            state.margins = margins(&state.support, cog);
        },
    );
}

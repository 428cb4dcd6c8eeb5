//! Counts the dynamic model of B2P2 and its stability criteria, in single precision, at random
//! postures and motions.

use super::counter::Table;
use super::inputs::{Random, settings};
use core::hint::black_box;
use tautrack::math::vector::CoordinateFrame;
use tautrack::motor::from_radians;
use tautrack::motor::profile::Motion;
use tautrack::robots::b2p2::feed_forward::Load;
use tautrack::robots::b2p2::model::newton_euler::Effort;
use tautrack::robots::b2p2::{FrontPart, JOINTS, JointMatrix, Joints, Parameters, Posture};
use tautrack::screw::Geometry;
use tautrack::sensors::BodySensors;
use tautrack::settings::{Setting, Settings};
use tautrack::stability::attitude::Attitude;
use tautrack::stability::tipover::{Edges, angles};
use tautrack::stability::zmp::{Plane, Wrench, ZeroMomentPoint, zero_moment_point};

struct State {
    parameters: Parameters<f32>,
    q: Joints<f32>,
    rates: Joints<f32>,
    accelerations: Joints<f32>,
    frames: [CoordinateFrame<f32>; JOINTS],
    matrix: JointMatrix<f32>,
    effort: Effort<f32>,
    plane: Plane<f32>,
    zmp: ZeroMomentPoint<f32>,
    contacts: [[f32; 3]; 4],
    cog: [f32; 3],
    moment: [f32; 3],
    angles: [f32; 4],
    margin: f32,
}

fn motion(state: &mut State, _: u32, random: &mut Random) {
    state.q = [3.0, 3.0, 0.5, 3.0, 0.5, 0.8, 3.0, 0.2].map(|bound| random.within(bound));
    state.rates = [2.0; JOINTS].map(|bound| random.within(bound));
    state.accelerations = [5.0; JOINTS].map(|bound| random.within(bound));
    let mut near = |place: [f32; 3], bound| place.map(|value| value + random.within(bound));
    state.contacts = [
        [0.0, -0.16, 0.0],
        [0.77, -0.16, 0.0],
        [0.77, 0.16, 0.0],
        [0.0, 0.16, 0.0],
    ]
    .map(|corner| near(corner, 0.1));
    state.cog = near([0.3, 0.0, 0.2], 0.2);
    state.moment = near([0.0; 3], 10.0);
    state.effort.reaction = Wrench {
        force: near([0.0, 0.0, -81.0], 60.0),
        moment: near([0.0; 3], 40.0),
    };
    state.plane.normal = near([0.0, 0.0, -1.0], 0.3);
}

/// Counts the computation of the front part's load, at random attitudes and motions.
fn count_front_part(table: &mut Table) {
    let settings = settings();
    let [l1, l2, k] = [Setting::LengthL1, Setting::LengthL2, Setting::LengthK]
        .map(|setting| settings.get(setting));
    let Ok(geometry) = Geometry::from_micrometres(l1, l2, k) else {
        return; // the nominal geometry is valid; otherwise the host finds no entry
    };
    let nothing = Load {
        joint: 0.0,
        screw: 0.0,
    };
    let mut state = black_box((
        FrontPart::new(&geometry, &Settings::default()),
        geometry,
        Attitude::default(),
        nothing,
    ));
    table.kernel(
        "load of B2P2's front part",
        &mut state,
        |(_, _, attitude, _), _, random| {
            *attitude = Attitude::default();
            attitude.update(
                &BodySensors {
                    inclination: [random.within(1.2), random.within(0.8)],
                    ..BodySensors::default()
                },
                1e-3,
            );
            Motion {
                position: from_radians(random.within(1.7)),
                velocity: random.within(2.0),
                acceleration: random.within(8.0),
            }
        },
        |(front, geometry, attitude, load), motion| {
            *load = front.load(geometry, &motion, attitude);
        },
    );
}

pub fn count(table: &mut Table) {
    count_front_part(table);
    let nothing = Wrench {
        force: [0.0; 3],
        moment: [0.0; 3],
    };
    let mut state = black_box(State {
        parameters: Parameters::paper(),
        q: [0.0; JOINTS],
        rates: [0.0; JOINTS],
        accelerations: [0.0; JOINTS],
        frames: [CoordinateFrame {
            axes: [[0.0; 3]; 3],
            origin: [0.0; 3],
        }; JOINTS],
        matrix: [[0.0; JOINTS]; JOINTS],
        effort: Effort {
            forces: [0.0; JOINTS],
            reaction: nothing,
        },
        plane: Plane {
            point: [0.0, 0.0, -0.05],
            normal: [0.0, 0.0, 1.0],
        },
        zmp: ZeroMomentPoint::None,
        contacts: [[0.0; 3]; 4],
        cog: [0.0; 3],
        moment: [0.0; 3],
        angles: [0.0; 4],
        margin: 0.0,
    });
    // Each of the next three starts from the joint values and includes their sines.
    table.kernel("B2P2 frames", &mut state, motion, |state, ()| {
        state.frames = Posture::new(&state.parameters, &state.q).frames();
    });
    table.kernel("B2P2 inertia matrix", &mut state, motion, |state, ()| {
        state.matrix = Posture::new(&state.parameters, &state.q).inertia_matrix();
    });
    table.kernel("B2P2 inverse dynamics", &mut state, motion, |state, ()| {
        state.effort = Posture::new(&state.parameters, &state.q)
            .newton_euler(&state.rates, &state.accelerations);
    });
    table.kernel("zero moment point", &mut state, motion, |state, ()| {
        state.zmp = zero_moment_point(&state.effort.reaction, &state.plane);
    });
    table.kernel("four tip-over angles", &mut state, motion, |state, ()| {
        let force = state.effort.reaction.force.map(|force| -force);
        state.angles = angles(&state.contacts, state.cog, force, state.moment);
    });

    motion(&mut state, 0, &mut Random::new());
    let Some(edges) = Edges::new(&state.contacts) else {
        return; // the contacts are distinct; otherwise the host finds no entry
    };
    let mut prepared = (edges, state);
    table.kernel(
        "minimum of four tip-over angles",
        &mut prepared,
        |(edges, state), call, random| {
            motion(state, call, random);
            *edges = Edges::new(&state.contacts).unwrap_or(*edges);
        },
        |(edges, state), ()| {
            let force = state.effort.reaction.force;
            state.margin = edges.margin(state.cog, force, state.moment);
        },
    );
}

//! Counts single functions of the library, at random postures and motions.

use super::counter::Table;
use super::inputs::{Random, angle, geometry, settings};
use core::hint::black_box;
use tautrack::math;
use tautrack::robots::b2p2::{JOINTS, Joints, Model, Parameters, Posture};
use tautrack::robots::hylos::controller::stance;
use tautrack::robots::hylos::{self, Controller, Desired, Potential, Sensed};
use tautrack::robots::rt_mover::prediction::{Prediction, Progress, Way};
use tautrack::robots::rt_mover::wheel::WHEELS;
use tautrack::robots::rt_mover::{self, Shape};
use tautrack::stability::support::margins;
use tautrack::stability::tipover::Edges;
use tautrack::units::Angle;

/// Corners of B2P2's support, about.
const CORNERS: [[f32; 3]; 4] = [
    [0.0, -0.16, 0.0],
    [0.77, -0.16, 0.0],
    [0.77, 0.16, 0.0],
    [0.0, 0.16, 0.0],
];

pub fn count(table: &mut Table) -> Option<()> {
    table.kernel(
        "sin_cos_q30",
        &mut (Angle::ZERO, (0, 0)),
        |(theta, _), call, _| *theta = angle(call),
        |(theta, result)| *result = math::sin_cos_q30(*theta),
    )?;
    table.kernel(
        "screw extension with derivative",
        &mut (black_box(geometry(&settings(&[])?)?), Angle::ZERO, None),
        |(_, theta, _), call, _| *theta = angle(call),
        |(geometry, theta, result)| *result = Some(geometry.extension(*theta)),
    )?;
    count_margins(table)?;
    count_tip_over(table)?;
    count_dynamics(table)?;
    count_controller_of_hylos(table)?;
    count_prediction_of_rt_mover(table)
}

fn near_corners(random: &mut Random) -> [[f32; 3]; 4] {
    CORNERS.map(|corner| random.near(corner, 0.1))
}

fn count_margins(table: &mut Table) -> Option<()> {
    let model = black_box(Model::new(&settings(&[])?));
    table.kernel(
        "CoG and four margins",
        &mut (model, CORNERS, (Angle::ZERO, 0.0), [0.0; 4]),
        |(_, support, shape, _), call, random| {
            // The first support has no area.
            *support = if call == 0 {
                [[0.1; 3]; 4]
            } else {
                near_corners(random)
            };
            *shape = (angle(call), 0.4 + random.within(0.2));
        },
        |(model, support, (theta, l3), result)| {
            *result = margins(support, model.shape(*theta, *l3).cog);
        },
    )
}

fn count_tip_over(table: &mut Table) -> Option<()> {
    table.kernel(
        "minimum of four tip-over angles",
        &mut (Edges::new(&CORNERS)?, [[0.0; 3]; 3], 0.0),
        |(edges, inputs, _), _, random| {
            *edges = Edges::new(&near_corners(random)).unwrap_or(*edges);
            *inputs = [
                random.near([0.3, 0.0, 0.2], 0.2),
                random.near([0.0, 0.0, -81.0], 60.0),
                random.near([0.0; 3], 10.0),
            ];
        },
        |(edges, [cog, force, moment], result)| *result = edges.margin(*cog, *force, *moment),
    )
}

fn count_dynamics(table: &mut Table) -> Option<()> {
    const RANGES: Joints<f32> = [3.0, 3.0, 0.5, 3.0, 0.5, 0.8, 3.0, 0.2];
    // It starts from the joint values and includes their sines.
    table.kernel(
        "B2P2 inverse dynamics",
        &mut (black_box(Parameters::paper()), [[0.0; JOINTS]; 3], None),
        |(_, motion, _), _, random| {
            *motion = [
                RANGES.map(|bound| random.within(bound)),
                random.near([0.0; JOINTS], 2.0),
                random.near([0.0; JOINTS], 5.0),
            ];
        },
        |(parameters, [q, rates, accelerations], effort)| {
            *effort = Some(Posture::new(parameters, q).newton_euler(rates, accelerations));
        },
    )
}

/// Counts a step of a robot that stands on a slope in any direction; some of these slopes would
/// topple it.
fn count_controller_of_hylos(table: &mut Table) -> Option<()> {
    let parameters = black_box(hylos::Parameters::<f32>::nominal());
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

/// Counts the moments of predictions, which are in addition to the guard's tick. Each prediction
/// runs to its end, then another one starts.
fn count_prediction_of_rt_mover(table: &mut Table) -> Option<()> {
    const WAY: Way<f32> = Way {
        rise: 0.2,
        travel: 0.15,
        fall: 0.03,
    };
    let parameters = black_box(rt_mover::parameters::Parameters::nominal());
    table.kernel(
        "moment of RT-Mover's prediction",
        &mut (parameters, None, Progress::Unfinished),
        |(parameters, prediction, progress), call, random| {
            if prediction.is_none() || *progress != Progress::Unfinished {
                let shape = Shape {
                    pitch: random.within(0.1),
                    steering: [random.within(0.2), random.within(0.5)],
                    roll: random.near([0.0; 2], 0.2),
                };
                let (heading, wheel) = (random.within(0.2), WHEELS[(call & 3) as usize]);
                *prediction = Some(Prediction::new(parameters, &shape, heading, wheel, &WAY));
            }
        },
        |(parameters, prediction, progress)| {
            if let Some(prediction) = prediction {
                *progress = prediction.moment(parameters);
            }
        },
    )
}

//! Computes B2P2's centre of gravity and zero moment point at one sample.
//!
//! The model is the one of the nodes, in double precision: [`Posture`], its Newton-Euler pass and
//! [`zero_moment_point`].

use crate::results::zmp::Moment;
use crate::robots::b2p2::plant::B2p2Parameters;
use crate::simulator::record::SAMPLE_HZ;
use crate::world::load::Load;
use crate::world::truth::Truth;
use std::f64::consts::{PI, TAU};
use tautrack::math::vector::{Symmetric, add, dot, scale, sub};
use tautrack::robots::b2p2::parameters::{LENGTHS, Lengths, SEGMENTS};
use tautrack::robots::b2p2::{Joints, Parameters, Posture, Tabulated};
use tautrack::stability::zmp::{Plane, ZeroMomentPoint, zero_moment_point};

/// Minimum horizontal distance of two contacts that define the slope of the plane, m. Closer
/// contacts may lie above each other.
const LEAST_SPAN: f64 = 0.10;

/// The nodes' model with the plant's masses; `None` if the parameters are no valid robot.
pub fn model(plant: &B2p2Parameters, payload: Option<Load>) -> Option<Parameters<f64>> {
    let mut segments = SEGMENTS;
    let body = &mut segments[0];
    let [forward, _, right] = body.centre_of_mass;
    // The plant's height of the centre of mass replaces the tabulated one. The inertia about the
    // centre of mass stays the same.
    let place = [forward, plant.body_1_com_height, right];
    let mut inertia = add_point(
        add_point(body.inertia_about_origin, -body.mass, body.centre_of_mass),
        body.mass,
        place,
    );
    let mut moment = scale(body.mass, place);
    if let Some(load) = payload {
        let [forward, left, up] = load.place;
        let place = [forward, up, -left];
        inertia = add_point(inertia, load.mass, place);
        for (axis, row) in inertia.iter_mut().enumerate() {
            row[axis] += load.own_inertia();
        }
        moment = add(moment, scale(load.mass, place));
        body.mass += load.mass;
    }
    *body = Tabulated {
        mass: body.mass,
        centre_of_mass: scale(1.0 / body.mass, moment),
        inertia_about_origin: inertia,
    };
    let lengths = Lengths {
        l1: plant.l1,
        l2: plant.l2,
        axle_3: plant.axle_3_from_r8,
        ..LENGTHS
    };
    Parameters::new(&lengths, &segments).ok()
}

/// Adds the inertia of a point mass to an inertia, both about the origin, kg m^2.
fn add_point(inertia: [[f64; 3]; 3], mass: f64, place: [f64; 3]) -> [[f64; 3]; 3] {
    let Symmetric {
        diagonal: [xx, yy, zz],
        mixed: [yz, zx, xy],
    } = Symmetric::point_mass(mass, place);
    let point = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    [0, 1, 2].map(|row| add(inertia[row], point[row]))
}

/// Converts a point or direction from world axes (x forward, y left, z up) to R0 (x right, y
/// forward, z up).
fn in_r0([x, y, z]: [f64; 3]) -> [f64; 3] {
    [-y, x, z]
}

/// The joints q of the ground truth.
pub fn joints(truth: &Truth) -> Joints<f64> {
    let [right, forward, up] = in_r0(truth.axle_1);
    let screw = truth.extension - LENGTHS.axle_3;
    [
        forward,
        right,
        up,
        truth.yaw,
        truth.roll,
        truth.pitch,
        truth.theta,
        screw,
    ]
}

/// Computes the moment of a sample with this ground truth. `around` has the joints before, at and
/// after it.
pub fn moment(
    model: &Parameters<f64>,
    truth: &Truth,
    [before, now, after]: [Joints<f64>; 3],
) -> Moment {
    let step = 1.0 / f64::from(SAMPLE_HZ);
    // A heading may jump by a full turn.
    let turned = |joint: usize, angle: f64| match joint {
        3 => (angle + PI).rem_euclid(TAU) - PI,
        _ => angle,
    };
    let path = |from: &Joints<f64>, to: &Joints<f64>| {
        core::array::from_fn::<_, 8, _>(|joint| turned(joint, to[joint] - from[joint]))
    };
    let (gone, coming) = (path(&before, &now), path(&now, &after));
    let rates = core::array::from_fn(|joint| (gone[joint] + coming[joint]) / (2.0 * step));
    let accelerations = core::array::from_fn(|joint| (coming[joint] - gone[joint]) / (step * step));

    let posture = Posture::new(model, &now);
    let (axles, cog) = posture.along_heading();
    let reaction = posture.newton_euler(&rates, &accelerations).reaction;
    let origin = in_r0(truth.axle_1);
    let heading = in_r0([libm::cos(truth.yaw), libm::sin(truth.yaw), 0.0]);
    let zmp = ground(truth, heading).and_then(|plane| match zero_moment_point(&reaction, &plane) {
        ZeroMomentPoint::At(point) => Some(dot(heading, sub(point, origin))),
        ZeroMomentPoint::None => None,
    });
    Moment {
        axles,
        cog,
        zmp,
        smoothed: None,
    }
}

/// The plane on which the robot stands: it contains the rearmost and the foremost contact and does
/// not tilt sideways. At rest the zero moment point is below the centre of gravity on any plane.
/// The plane matters only for how far a motion moves the zero moment point.
fn ground(truth: &Truth, heading: [f64; 3]) -> Option<Plane<f64>> {
    let along = |point: &[f64; 3]| dot(heading, *point);
    let contacts = || truth.contacts.iter().map(|point| in_r0(*point));
    let rear = contacts().min_by(|a, b| along(a).total_cmp(&along(b)))?;
    let front = contacts().max_by(|a, b| along(a).total_cmp(&along(b)))?;
    let span = along(&front) - along(&rear);
    let rise = if span < LEAST_SPAN {
        0.0
    } else {
        (front[2] - rear[2]) / span
    };
    Some(Plane {
        point: rear,
        normal: sub([0.0, 0.0, 1.0], scale(rise, heading)),
    })
}

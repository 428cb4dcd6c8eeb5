//! B2P2's parts of the page: its drawing, its curves and its assumptions.

use crate::results::report::{OwnPage, Source};
use crate::robots::b2p2::plant::B2p2Parameters;
use crate::robots::b2p2::section::B2p2;
use crate::simulator::record::Sample;
use crate::world::truth::Truth;
use serde_json::json;

/// The curves of B2P2 alone. Angles become degrees.
const CURVES: &[Source<Sample>] = &[
    ("theta", 0.01, |s| Some(s.truth.theta.to_degrees())),
    ("extension", 1e-4, |s| Some(s.truth.extension)),
    ("tension", 0.01, |s| Some(s.truth.tension_error * 1e3)),
    ("leftTension", 0.1, |s| {
        s.truth.channels.get("left_belt_tension_n").copied()
    }),
    ("rightTension", 0.1, |s| {
        s.truth.channels.get("right_belt_tension_n").copied()
    }),
    ("askedTheta", 0.01, |s| {
        Some(s.received.asked_theta.to_degrees())
    }),
    ("passedTheta", 0.01, |s| {
        Some(s.received.passed_theta.to_degrees())
    }),
    ("leftCurrent", 0.01, |s| {
        s.received.currents.first().copied()
    }),
    ("rightCurrent", 0.01, |s| {
        s.received.currents.get(1).copied()
    }),
    ("chassisCurrent", 0.01, |s| {
        s.received.currents.get(2).copied()
    }),
    ("screwCurrent", 0.01, |s| {
        s.received.currents.get(3).copied()
    }),
];

/// Returns the page of a robot with this section and these parameters.
pub fn page(robot: &B2p2, parameters: &B2p2Parameters) -> OwnPage {
    let B2p2Parameters {
        l1,
        l2,
        pulley_radius,
        width,
        belt_width,
        ..
    } = *parameters;
    OwnPage {
        script: include_str!("page.js"),
        data: json!({ "robot": robot, "l1": l1, "l2": l2 }),
        curves: CURVES,
        axles: Box::new(move |truth: &Truth, axle_1| {
            let along = |[x, z]: [f64; 2], length: f64, angle: f64| {
                [x + length * libm::cos(angle), z + length * libm::sin(angle)]
            };
            let axle_2 = along(axle_1, l1, truth.pitch);
            let front = truth.pitch + truth.theta;
            let axle_3 = along(axle_2, l2 + truth.extension, front);
            vec![axle_1, axle_2, axle_3]
        }),
        radius_m: pulley_radius,
        half_width_m: 0.5 * (width - belt_width),
    }
}

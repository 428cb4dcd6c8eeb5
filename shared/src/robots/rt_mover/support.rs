//! Computes the centre of gravity and its distance to the edges of a support on three wheels.

use super::parameters::Parameters;
use super::wheel::{Arm, Axle, Shape, Wheel};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, scale};

/// Minimum length of an edge, m; a shorter one has no direction.
const MIN_LENGTH: f64 = 1e-3;

/// Smallest signed distance of `cog` to the edges of a triangle of supports, seen from above, m;
/// positive inside. The supports run counter-clockwise.
///
/// An edge shorter than a millimetre has no direction. The margin is then at most minus the
/// distance to it, so the centre of gravity is never "inside". NaN gives NaN.
pub fn static_margin<S: Scalar>(supports: &[[S; 2]; 3], cog: [S; 2]) -> S {
    let margin = |from: [S; 2], to: [S; 2]| {
        let edge = [to[0] - from[0], to[1] - from[1]];
        let offset = [cog[0] - from[0], cog[1] - from[1]];
        let length = (edge[0] * edge[0] + edge[1] * edge[1]).sqrt();
        if length < S::from_f64(MIN_LENGTH) {
            -(offset[0] * offset[0] + offset[1] * offset[1]).sqrt()
        } else {
            (edge[0] * offset[1] - edge[1] * offset[0]) / length
        }
    };
    let [a, b, c] = *supports;
    let least = |one: S, other: S| {
        if one < other {
            one
        } else if other <= one {
            other
        } else {
            one + other
        }
    };
    least(least(margin(a, b), margin(b, c)), margin(c, a))
}

/// Centre of gravity in body-centred level axes, with the seat level, m.
pub fn cog<S: Scalar>(parameters: &Parameters<S>, shape: &Shape<S>) -> Vector<S> {
    // Body and shafts are symmetric about the middle; only the axles hang below, across their arms.
    let down = [Axle::Front, Axle::Rear].map(|axle| {
        let arm = Arm::new(parameters, shape, axle);
        scale(
            -(parameters.arm_drop * parameters.wheel_share),
            arm.frame.axes[2],
        )
    });
    let [forward, up] = parameters.cog;
    add([S::ZERO, forward, up], add(down[0], down[1]))
}

/// Margin with `lifted` in the air, m: [`static_margin`] of the other three wheels where they are.
pub fn margin_without<S: Scalar>(parameters: &Parameters<S>, shape: &Shape<S>, lifted: Wheel) -> S {
    // Counter-clockwise, starting with the wheel after the lifted one.
    let supports = match lifted {
        Wheel::RearRight => [Wheel::FrontRight, Wheel::FrontLeft, Wheel::RearLeft],
        Wheel::FrontRight => [Wheel::FrontLeft, Wheel::RearLeft, Wheel::RearRight],
        Wheel::FrontLeft => [Wheel::RearLeft, Wheel::RearRight, Wheel::FrontRight],
        Wheel::RearLeft => [Wheel::RearRight, Wheel::FrontRight, Wheel::FrontLeft],
    };
    let places = supports.map(|wheel| {
        let [x, y, _] = Arm::new(parameters, shape, wheel.axle()).contact(parameters, wheel);
        [x, y]
    });
    let [x, y, _] = cog(parameters, shape);
    static_margin(&places, [x, y])
}

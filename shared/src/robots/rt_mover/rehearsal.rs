//! A step of one wheel gone through in mind before any wheel leaves the ground.

use super::command::{Situation, Task};
use super::exact::exact;
use super::parameters::Parameters;
use super::projection::Projection;
use super::support::margin_without;
use super::wheel::{Shape, Wheel};
use crate::math::Scalar;

/// Roll of the leg arm, rad, and turning round the partner, rad, from one moment to the next.
const ROLL: f64 = 0.04;
const TURN: f64 = 0.04;
/// More moments than any step takes: half a turn up, across and down.
const MOMENTS: usize = 80;

/// A wheel's way onto a step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Way<S> {
    /// Height by which it is lifted, m.
    pub rise: S,
    /// Distance by which it is swung forward, m.
    pub travel: S,
    /// Height by which it is let down again, m.
    pub fall: S,
}

/// What a step will be like.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Rehearsal<S> {
    /// Least static margin, m.
    pub margin: S,
    /// Largest angle of the leg's steering shaft either way, rad.
    pub steering: S,
    /// The robot after it.
    pub shape: Shape<S>,
    /// Direction of its body against that of travel after it, rad.
    pub heading: S,
}

/// Height of `wheel` over its partner and distance ahead of it along the direction of travel, m.
pub fn reach<S: Scalar>(
    parameters: &Parameters<S>,
    shape: &Shape<S>,
    heading: S,
    wheel: Wheel,
) -> [S; 2] {
    let frame = Projection::new(parameters, shape);
    let [own, partner] = [wheel, wheel.partner()].map(|wheel| frame.contacts[wheel as usize]);
    let (sine, cosine) = heading.sin_cos();
    let ahead = (own[0] - partner[0]) * sine + (own[1] - partner[1]) * cosine;
    [frame.height(wheel), ahead]
}

/// Goes through the step of `lifted` from `shape` and `heading` by the exact law; `None` if it does not come to an end.
///
/// Cost: about 30 times that of [`exact`]; once before a step, not in every tick.
pub fn rehearse<S: Scalar>(
    parameters: &Parameters<S>,
    shape: &Shape<S>,
    heading: S,
    lifted: Wheel,
    way: &Way<S>,
) -> Option<Rehearsal<S>> {
    let (leg, up) = (lifted.axle() as usize, -lifted.side::<S>());
    let [height, ahead] = reach(parameters, shape, heading, lifted);
    let (top, across) = (height + way.rise, ahead + way.travel);
    let bottom = top - way.fall;
    let mut end = Rehearsal {
        margin: margin_without(parameters, shape, lifted),
        steering: S::ZERO,
        shape: *shape,
        heading,
    };
    let mut phase = 0;
    for _ in 0..MOMENTS {
        let [height, ahead] = reach(parameters, &end.shape, end.heading, lifted);
        // Up, across, down; one after the other.
        if phase == 0 && height >= top || phase == 1 && ahead >= across {
            phase += 1;
        }
        if phase == 2 && height <= bottom {
            return Some(end);
        }
        let task = match phase {
            0 => Task::Vertical {
                roll_rate: up * S::from_f64(ROLL),
            },
            1 => Task::Swing {
                turning: -(up * S::from_f64(TURN)),
            },
            _ => Task::Vertical {
                roll_rate: -(up * S::from_f64(ROLL)),
            },
        };
        let situation = Situation {
            shape: end.shape,
            rates: Shape::ZERO,
            heading: end.heading,
            lifted,
        };
        let rates = exact(parameters, &situation, &task)?;
        end.shape.pitch += rates.rates.pitch;
        for axle in 0..2 {
            end.shape.steering[axle] += rates.rates.steering[axle];
            end.shape.roll[axle] += rates.rates.roll[axle];
        }
        end.heading += rates.turning;
        let margin = margin_without(parameters, &end.shape, lifted);
        if !(margin >= end.margin) {
            end.margin = margin;
        }
        let steering = end.shape.steering[leg];
        let size = if steering < S::ZERO {
            -steering
        } else {
            steering
        };
        if !(size <= end.steering) {
            end.steering = size;
        }
    }
    None
}

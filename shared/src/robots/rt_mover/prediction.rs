//! Predicts the step of one wheel, with its margins, before any wheel leaves the ground.

use super::exact::exact;
use super::parameters::Parameters;
use super::projection::Projection;
use super::support::margin_without;
use super::task::{Situation, Task};
use super::wheel::{Shape, Wheel};
use crate::math::Scalar;

/// Increments from one moment of the prediction to the next: roll of the leg arm, rad, and rotation
/// about the partner, rad.
const ROLL: f64 = 0.04;
const TURN: f64 = 0.04;
/// Maximum number of moments. It is more than any step takes: up, across and down by half a turn
/// together.
const MOMENTS: usize = 80;

/// Path of a wheel onto a step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Way<S> {
    /// Height by which it is lifted, m.
    pub rise: S,
    /// Distance by which it is swung forward, m.
    pub travel: S,
    /// Height by which it is lowered again, m.
    pub fall: S,
}

/// Predicted result of a step.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Predicted<S> {
    /// Smallest static margin, m.
    pub margin: S,
    /// Largest angle of the leg arm's steering shaft in either direction, rad.
    pub steering: S,
    /// Shape of the robot after the step.
    pub shape: Shape<S>,
    /// Direction of the body relative to the direction of travel after the step, rad.
    pub heading: S,
}

/// Progress of a prediction.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Progress<S> {
    /// The step is not complete yet.
    Unfinished,
    /// The step is complete.
    Done(Predicted<S>),
    /// The step does not end.
    Endless,
}

/// Height of `wheel` above its partner, and distance ahead of it along the direction of travel, m.
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

/// Prediction of a step by the exact law, moment by moment.
#[derive(Clone, Debug)]
pub struct Prediction<S> {
    lifted: Wheel,
    /// Height to which the wheel rises, distance ahead to which it swings, and height to which it
    /// is lowered, m.
    goals: [S; 3],
    /// 0 for up, 1 for across, 2 for down.
    phase: usize,
    moments: usize,
    end: Predicted<S>,
}

impl<S: Scalar> Prediction<S> {
    /// Starts the prediction of a step of `lifted` from `shape` and `heading`.
    pub fn new(
        parameters: &Parameters<S>,
        shape: &Shape<S>,
        heading: S,
        lifted: Wheel,
        way: &Way<S>,
    ) -> Self {
        let [height, ahead] = reach(parameters, shape, heading, lifted);
        let top = height + way.rise;
        Self {
            lifted,
            goals: [top, ahead + way.travel, top - way.fall],
            phase: 0,
            moments: 0,
            end: Predicted {
                margin: margin_without(parameters, shape, lifted),
                steering: S::ZERO,
                shape: *shape,
                heading,
            },
        }
    }

    /// Advances the prediction by one moment. Cost: that of [`exact`] and two projections
    /// (`cargo cost`). A step takes 40 to 80 moments, so they are spread over as many ticks.
    pub fn moment(&mut self, parameters: &Parameters<S>) -> Progress<S> {
        let (lifted, end) = (self.lifted, &mut self.end);
        let up = -lifted.side::<S>();
        let [height, ahead] = reach(parameters, &end.shape, end.heading, lifted);
        let [top, across, bottom] = self.goals;
        if self.phase == 0 && height >= top || self.phase == 1 && ahead >= across {
            self.phase += 1;
        }
        if self.phase == 2 && height <= bottom {
            return Progress::Done(*end);
        }
        self.moments += 1;
        if self.moments > MOMENTS {
            return Progress::Endless;
        }
        let task = match self.phase {
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
        let Some(rates) = exact(parameters, &situation, &task) else {
            return Progress::Endless;
        };
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
        let steering = end.shape.steering[lifted.axle() as usize];
        let size = if steering < S::ZERO {
            -steering
        } else {
            steering
        };
        if !(size <= end.steering) {
            end.steering = size;
        }
        Progress::Unfinished
    }
}

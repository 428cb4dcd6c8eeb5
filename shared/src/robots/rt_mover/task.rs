//! What a lifted wheel has to do in which situation, and the motor rates that do it.

use super::wheel::{Shape, Wheel};
use crate::math::Scalar;

/// State of the robot with one wheel lifted.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Situation<S> {
    /// Measured angles.
    pub shape: Shape<S>,
    /// Measured rates, of which the exact law needs only that of the supporting axle's steering
    /// shaft.
    pub rates: Shape<S>,
    /// Direction of the body relative to the direction of travel, `theta_B`, counter-clockwise,
    /// rad.
    pub heading: S,
    /// The wheel in the air.
    pub lifted: Wheel,
}

/// Task of the lifted wheel.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Task<S> {
    /// Move straight up or down.
    Vertical {
        /// Rate of the leg arm's roll shaft, rad/s: positive lifts the left wheel.
        roll_rate: S,
    },
    /// Swing about its partner, the other wheel of the same arm.
    Swing {
        /// Rate, counter-clockwise, `theta_o`, rad/s.
        turning: S,
    },
}

impl<S: Scalar> Task<S> {
    /// Rate of the leg arm's roll shaft, rad/s.
    pub fn roll_rate(&self) -> S {
        match *self {
            Self::Vertical { roll_rate } => roll_rate,
            Self::Swing { .. } => S::ZERO,
        }
    }
}

/// Command for the motors.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MotorCommand<S> {
    /// Rates of the shafts, rad/s. Only those of the leg arm are commands. Those of pitch and
    /// supporting roll are what posture control will produce by itself; the paper's laws do not
    /// contain them.
    pub rates: Shape<S>,
    /// Speed of each wheel forward along its heading, m/s.
    pub wheels: [S; 4],
    /// Rate of rotation of the body, rad/s.
    pub turning: S,
}

impl<S: Scalar> MotorCommand<S> {
    /// All motors at rest.
    pub const STOPPED: Self = Self {
        rates: Shape::ZERO,
        wheels: [S::ZERO; 4],
        turning: S::ZERO,
    };
}

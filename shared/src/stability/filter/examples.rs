//! Defines bounds and margins for the tests of the filter.

use super::{Bounds, Margins, Ramp};
use crate::stability::energy::Tipping;

/// A robot that does not turn, with its centre of gravity on the ground: its energy is its margin.
pub const STILL: Tipping = Tipping {
    height: 0.0,
    arm: 0.0,
    rate: 0.0,
    gyration: 0.0,
};

const fn ramp(none: f32, all: f32) -> Ramp {
    Ramp { none, all }
}

pub const BOUNDS: Bounds = Bounds {
    towards: ramp(0.05, 0.09),
    away: ramp(0.01, 0.05),
    horizon: 0.25,
    foresight: 0.15,
    tipping: [STILL; 4],
    half_width: 0.15,
    fastest: 0.45,
    braking: 1.5,
    noses: false,
};

pub fn standing(back: f32) -> Margins {
    Margins {
        now: [back, 0.3, 0.15, 0.15],
        rate: [0.0; 4],
        speed: 0.0,
    }
}

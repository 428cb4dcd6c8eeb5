//! What the state estimate takes from the drives, and what of it goes on the bus.

use crate::bus::pdo::GuardPosition;
use crate::estimate::state::{State, Validity};
use crate::math::to_i16;
use crate::robots::{Body, DriveState};

/// When the oldest of the drives that odometry comes from was heard; none before each was.
pub(super) fn odometry_us<B: Body>(drives: &[DriveState]) -> Option<u64> {
    let mut oldest = u64::MAX;
    for index in B::ODOMETRY {
        let heard_us = drives.get(*index)?.heard_us?;
        if heard_us < oldest {
            oldest = heard_us;
        }
    }
    Some(oldest)
}

/// Payload of TPDO 5.
pub(super) fn summary(state: &State) -> GuardPosition {
    let centimetres = |axis: usize| to_i16(state[axis].value * 100.0);
    let invalid = state[0].validity == Validity::Invalid;
    GuardPosition {
        north: centimetres(0),
        east: centimetres(1),
        up: centimetres(2),
        validity: (0..4).fold(0, |bits, axis| {
            bits | (state[axis].validity as u8) << (2 * axis)
        }),
        age: if invalid {
            u8::MAX
        } else {
            u8::try_from(state[0].age_ms / 100).unwrap_or(u8::MAX)
        },
    }
}

//! What the state estimate takes from the drives, and what of it goes on the bus by itself.

use super::drives::Drives;
use crate::bus::pdo::GuardPosition;
use crate::estimate::state::{Joint, State, Validity};
use crate::math::to_i16;
use crate::robots::Body;

/// When the drive was heard that was silent longest among those of the odometry.
pub(super) fn odometry_us<B: Body>(drives: &Drives) -> Option<u64> {
    let heard = B::ODOMETRY.iter().map(|drive| drives.moved_us(*drive));
    heard.min().flatten()
}

/// The coordinates behind q1 to q6 with the age of their encoders.
pub(super) fn joints(body: &impl Body, drives: &Drives) -> [Joint; 2] {
    body.joints().map(|joint| {
        joint.map_or_else(Joint::default, |(drive, value)| Joint {
            value,
            heard_us: drives.moved_us(drive),
        })
    })
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

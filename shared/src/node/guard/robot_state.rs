//! What the state estimate takes from B2P2's drives.

use super::drives::{Drives, Role};
use crate::bus::pdo::GuardPosition;
use crate::estimate::state::{Joint, State, Validity};
use crate::math::to_i16;
use crate::robots::b2p2::shape::AXLE_3_FROM_BODY_3;
use crate::units::Angle;

/// Extension of the screw, m per 2^-24 m.
const METRES_PER_BUS: f32 = 1.0 / 16_777_216.0;

/// When the older of the two belts was heard.
pub(super) fn belts_us(drives: &Drives) -> Option<u64> {
    let [left, right] = [Role::Left, Role::Right].map(|role| drives.of(role).moved_us());
    left.zip(right).map(|(left, right)| left.min(right))
}

/// The paper's q7 and q8.
pub(super) fn joints(drives: &Drives) -> [Joint; 2] {
    let joint = |role, value: fn(i32) -> f32| {
        let drive = drives.of(role);
        let heard_us = drive.moved_us().filter(|_| drive.referenced());
        Joint {
            value: value(drive.position()),
            heard_us,
        }
    };
    [
        joint(Role::Joint, |bits| Angle::from_bits(bits).radians()),
        joint(Role::Screw, |bits| {
            bits as f32 * METRES_PER_BUS - AXLE_3_FROM_BODY_3
        }),
    ]
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

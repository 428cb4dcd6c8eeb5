//! Duration of frames on the wire, in bits. At 1 Mbit/s one bit takes one microsecond.

use tautrack::can::Frame;
use tautrack::link::STEP_US;

/// Bit rate of the bus, bit/s.
pub const BIT_RATE: u64 = 1_000_000;
/// Number of bits that the bus can carry in one lockstep step.
pub const BITS_PER_STEP: u32 = (BIT_RATE * STEP_US / 1_000_000) as u32;

/// Number of bits that `frame` occupies with worst-case stuffing, including the interframe space of
/// three bits; 55 to 135.
///
/// `8 n + 44 + 3 + floor((34 + 8 n - 1) / 4)` for `n` data bytes of a CAN 2.0A frame (Davis, Burns,
/// Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis: Refuted, revisited and
/// revised", eq. 1).
pub fn worst_case_bits(frame: &Frame) -> u32 {
    let data_bits = 8 * frame.data().len() as u32;
    let stuff_bits = (34 + data_bits - 1) / 4;
    data_bits + 44 + 3 + stuff_bits
}

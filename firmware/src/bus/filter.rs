//! Decides which requests a node follows: refuses those that it does not support, and those that a
//! client may not make at the time.
//!
//! * Block transfers in both directions. Segmented transfers are sufficient for every object of
//!   this dictionary.
//! * Writes to PDO mappings that are no expedited transfers, and more than eight objects in a PDO.
//! * Writes of values that a drive does not support: modes, option codes and homing methods.
//! * LSS (layer setting services). The id of a node that has one is a setting.
//! * Remote frames do not reach this filter: [`Frame`] cannot represent them.
//! * While the guard is alive: SDO writes to objects that may move an axle, or that decide which
//!   frames do. Only the other communication objects, and those of the recording, can be written.
//! * While the node is stopped: SDO requests, which have no answer then (CiA 301).
//! * While the control task does not run: SYNC, because the node would send old positions.

use tautrack::bus::drive_parameters;
use tautrack::can::Frame;

const LSS_REQUEST: u16 = 0x7e5;
const SYNC: u16 = 0x080;
pub(super) const SDO_REQUEST: u16 = 0x600;
pub(super) const SDO_RESPONSE: u16 = 0x580;

/// Abort codes of CiA 301.
const COMMAND_SPECIFIER: u32 = 0x0504_0001;
pub(super) const PARAMETER_LENGTH: u32 = 0x0607_0010;
const VALUE_RANGE: u32 = 0x0609_0030;
pub(super) const VALUE_TOO_HIGH: u32 = 0x0609_0031;
pub(super) const DEVICE_STATE: u32 = 0x0800_0022;

/// Maximum number of objects in one PDO.
const MAX_MAPPINGS: u8 = 8;

/// Decision about a received frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Verdict {
    /// Follow the frame.
    Pass,
    /// Discard the frame.
    Drop,
    /// Discard the frame and send this one as the answer.
    Answer(Frame),
}

/// Conditions, besides the frame, that the verdict depends on.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Condition {
    /// The guard's heartbeat is alive, and the guard is another node.
    pub guard_alive: bool,
    /// The control task runs.
    pub control_runs: bool,
    /// The node is in the NMT state "stopped".
    pub stopped: bool,
}

/// Decides what to do with `frame`, which node `node_id` received.
pub fn evaluate(frame: &Frame, node_id: u8, condition: Condition) -> Verdict {
    let node = u16::from(node_id);
    if frame.id() == LSS_REQUEST || frame.id() == SYNC && !condition.control_runs {
        return Verdict::Drop;
    }
    if frame.id() != SDO_REQUEST + node {
        return Verdict::Pass;
    }
    let &[command, index_low, index_high, sub, value, ..] = frame.data() else {
        return Verdict::Drop; // CiA 301: an SDO has eight bytes
    };
    if frame.data().len() != 8 || condition.stopped {
        return Verdict::Drop;
    }
    let abort = |code: u32| {
        let [a, b, c, d] = code.to_le_bytes();
        Frame::new(
            SDO_RESPONSE + node,
            &[0x80, index_low, index_high, sub, a, b, c, d],
        )
        .map_or(Verdict::Drop, Verdict::Answer)
    };
    let index = u16::from_le_bytes([index_low, index_high]);
    // Expedited transfer with its size given: bits 0 and 1; number of unused bytes: bits 2 and 3.
    let size = if command & 0b11 == 0b11 {
        4 - ((command >> 2) & 0b11)
    } else {
        0
    };
    match command >> 5 {
        1 if condition.guard_alive && moves_an_axle(index) => abort(DEVICE_STATE),
        5 | 6 => abort(COMMAND_SPECIFIER),
        1 if is_mapping(index) => match (sub, size) {
            (0, 1) if value > MAX_MAPPINGS => abort(VALUE_TOO_HIGH),
            (0, 1) | (1.., 4) => Verdict::Pass,
            _ => abort(PARAMETER_LENGTH),
        },
        1 if drive_parameters::is_restricted(index) => {
            if size == 0 {
                abort(PARAMETER_LENGTH)
            } else if drive_parameters::supports(index, signed(frame.data(), size)) {
                Verdict::Pass
            } else {
                abort(VALUE_RANGE)
            }
        }
        _ => Verdict::Pass,
    }
}

/// Returns the value of an expedited transfer with `size` bytes, which has a sign.
fn signed(data: &[u8], size: u8) -> i32 {
    match (data, size) {
        (&[.., value, _, _, _], 1) => i32::from(value as i8),
        (&[.., low, high, _, _], 2) => i32::from(i16::from_le_bytes([low, high])),
        (&[.., a, b, c, d], _) => i32::from_le_bytes([a, b, c, d]),
        _ => 0,
    }
}

/// Whether writing the object may move an axle: all objects of the drive itself, and the parameters
/// of its receive PDOs.
pub(super) fn moves_an_axle(index: u16) -> bool {
    matches!(index, 0x1400..=0x17ff | 0x2000..) && !is_capture(index)
}

/// Whether the object belongs to the recording of signals, which moves nothing.
pub fn is_capture(index: u16) -> bool {
    matches!(index, 0x2060..=0x2063)
}

/// Whether the object maps objects into a PDO.
pub(super) fn is_mapping(index: u16) -> bool {
    matches!(index, 0x1600..=0x17ff | 0x1a00..=0x1bff)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Condition = Condition {
        guard_alive: false,
        control_runs: true,
        stopped: false,
    };

    fn request(bytes: [u8; 8]) -> Verdict {
        evaluate(&Frame::new(0x605, &bytes).unwrap(), 5, ALONE)
    }

    #[test]
    fn nobody_writes_what_moves_an_axle_while_the_guard_is_alive() {
        let guarded = Condition {
            guard_alive: true,
            ..ALONE
        };
        for index in [
            0x6040_u16, 0x6060, 0x607a, 0x60ff, 0x60b2, 0x2001, 0x2101, 0x1400, 0x1601,
        ] {
            let [low, high] = index.to_le_bytes();
            // The first request of an expedited and of a segmented transfer, in several sizes.
            for command in [0x23, 0x2b, 0x2f, 0x20, 0x21] {
                let write = Frame::new(0x605, &[command, low, high, 1, 0, 0, 0, 0]).unwrap();
                let code = aborted(evaluate(&write, 5, guarded));
                assert_eq!(code, Some(DEVICE_STATE), "{index:#x}");
            }
            let read = Frame::new(0x605, &[0x40, low, high, 0, 0, 0, 0, 0]).unwrap();
            assert_eq!(evaluate(&read, 5, guarded), Verdict::Pass, "{index:#x}");
        }
        let capture = Frame::new(0x605, &[0x2f, 0x60, 0x20, 1, 1, 0, 0, 0]).unwrap();
        assert_eq!(evaluate(&capture, 5, guarded), Verdict::Pass);
        let heartbeat = Frame::new(0x605, &[0x2b, 0x17, 0x10, 0, 50, 0, 0, 0]).unwrap();
        assert_eq!(evaluate(&heartbeat, 5, guarded), Verdict::Pass);
        assert_eq!(request([0x2b, 0x40, 0x60, 0, 6, 0, 0, 0]), Verdict::Pass);
    }

    #[test]
    fn a_node_whose_control_task_stands_answers_no_sync() {
        let standing = Condition {
            control_runs: false,
            ..ALONE
        };
        let sync = Frame::new(0x080, &[]).unwrap();
        assert_eq!(evaluate(&sync, 5, standing), Verdict::Drop);
        assert_eq!(evaluate(&sync, 5, ALONE), Verdict::Pass);
    }

    fn aborted(verdict: Verdict) -> Option<u32> {
        match verdict {
            Verdict::Answer(frame) => {
                assert_eq!((frame.id(), frame.data()[0]), (0x585, 0x80));
                Some(u32::from_le_bytes(frame.data()[4..8].try_into().unwrap()))
            }
            _ => None,
        }
    }

    #[test]
    fn block_transfers_are_refused_both_ways() {
        assert_eq!(
            aborted(request([0xa0, 0x08, 0x10, 0, 20, 0, 0, 0])),
            Some(COMMAND_SPECIFIER)
        );
        assert_eq!(
            aborted(request([0xa1, 0, 0, 0, 0, 0, 0, 0])),
            Some(COMMAND_SPECIFIER)
        );
        assert_eq!(
            aborted(request([0xc2, 0x00, 0x20, 0, 20, 0, 0, 0])),
            Some(COMMAND_SPECIFIER)
        );
    }

    #[test]
    fn mapping_takes_only_expedited_writes_of_the_right_size() {
        assert_eq!(
            aborted(request([0x20, 0x00, 0x16, 0, 0, 0, 0, 0])),
            Some(PARAMETER_LENGTH)
        );
        assert_eq!(
            aborted(request([0x21, 0x00, 0x1a, 0, 1, 0, 0, 0])),
            Some(PARAMETER_LENGTH)
        );
        assert_eq!(
            aborted(request([0x22, 0x00, 0x1a, 0, 1, 0, 0, 0])),
            Some(PARAMETER_LENGTH)
        );
        assert_eq!(
            aborted(request([0x2f, 0x01, 0x16, 0, 9, 0, 0, 0])),
            Some(VALUE_TOO_HIGH)
        );
        assert_eq!(request([0x2f, 0x00, 0x16, 0, 8, 0, 0, 0]), Verdict::Pass);
        assert_eq!(
            request([0x23, 0x03, 0x1a, 1, 0x20, 0, 0x40, 0x60]),
            Verdict::Pass
        );
    }

    #[test]
    fn unsupported_values_are_refused_in_every_size() {
        // Index, size, value, and whether a drive supports it.
        for (index, size, value, supported) in [
            (0x6060_u16, 1_u8, 10_i32, true),
            (0x6060, 1, -1, true),
            (0x6060, 1, 4, false),
            (0x6060, 1, -3, false),
            (0x605a, 2, 6, true),
            (0x605a, 2, 3, false),
            (0x605a, 2, 0x106, false),
            (0x605e, 2, -1, false),
            (0x6098, 1, 24, true),
            (0x6098, 1, 35, false),
            (0x6087, 4, 0, false),
            (0x6087, 4, -1, true),
            (0x6065, 4, -1, true),
        ] {
            let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
            let command = 0x23 | (4 - size) << 2;
            let code = aborted(request([command, low, high, 0, a, b, c, d]));
            assert_eq!(
                code,
                (!supported).then_some(VALUE_RANGE),
                "{index:#x} {value}"
            );
        }
        assert_eq!(
            aborted(request([0x21, 0x5a, 0x60, 0, 2, 0, 0, 0])),
            Some(PARAMETER_LENGTH)
        );
    }

    #[test]
    fn everything_else_passes_but_lss() {
        assert_eq!(request([0x40, 0x00, 0x10, 0, 0, 0, 0, 0]), Verdict::Pass);
        assert_eq!(
            evaluate(&Frame::new(0x606, &[0xa0; 8]).unwrap(), 5, ALONE),
            Verdict::Pass
        );
        assert_eq!(
            evaluate(&Frame::new(0x7e5, &[4, 1]).unwrap(), 5, ALONE),
            Verdict::Drop
        );
        assert_eq!(
            evaluate(&Frame::new(0x605, &[0x40]).unwrap(), 5, ALONE),
            Verdict::Drop
        );
    }
}

//! What the CANopen stack must never see: frames that this version of it answers wrongly or panics
//! on, and what a client may not do now.
//!
//! * Block transfers, either way. An abort in the middle of a block upload panics the stack, its end frame is wrong for
//!   lengths that are a multiple of seven, and the segments of a block download cannot be told from other requests.
//!   Segmented transfers carry anything of this dictionary.
//! * Segmented writes to PDO mappings: an empty last segment panics the stack, and a count above eight is accepted.
//! * LSS: node ids are settings of the node, and the stack would change its own id behind the filter's back.
//! * Remote frames never get here: [`Frame`] cannot express them.
//! * While the guard is alive, nobody writes an object that may move an axle, or that decides which
//!   frames do: only the rest of the communication objects stays open.
//! * While the control task stands, SYNC: the stack would send old positions.

use tautrack::can::Frame;

const LSS_REQUEST: u16 = 0x7e5;
const SYNC: u16 = 0x080;
const SDO_REQUEST: u16 = 0x600;
const SDO_RESPONSE: u16 = 0x580;

/// Abort codes of CiA 301.
const COMMAND_SPECIFIER: u32 = 0x0504_0001;
const PARAMETER_LENGTH: u32 = 0x0607_0010;
const VALUE_TOO_HIGH: u32 = 0x0609_0031;
const DEVICE_STATE: u32 = 0x0800_0022;

/// Most objects in one PDO.
const MAX_MAPPINGS: u8 = 8;

/// What to do with a received frame.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Verdict {
    /// Hand it to the stack.
    Pass,
    /// Forget it.
    Drop,
    /// Send this instead.
    Answer(Frame),
}

/// What the verdict depends on beside the frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Condition {
    /// The heartbeat of a guard that is another node is alive.
    pub guard_alive: bool,
    /// The control task runs.
    pub control_runs: bool,
}

/// Evaluates `frame`, received by node `node_id`.
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
    if frame.data().len() != 8 {
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
    match command >> 5 {
        1 if condition.guard_alive && moves_an_axle(index) => abort(DEVICE_STATE),
        5 | 6 => abort(COMMAND_SPECIFIER),
        1 if is_mapping(index) => {
            // Expedited, size given: bits 0 and 1; unused bytes: bits 2 and 3.
            let size = if command & 0b11 == 0b11 {
                4 - ((command >> 2) & 0b11)
            } else {
                0
            };
            match (sub, size) {
                (0, 1) if value > MAX_MAPPINGS => abort(VALUE_TOO_HIGH),
                (0, 1) | (1.., 4) => Verdict::Pass,
                _ => abort(PARAMETER_LENGTH),
            }
        }
        _ => Verdict::Pass,
    }
}

/// The object that `frame` addresses, if it is a request for node `node_id` that names one.
pub fn sdo_index(frame: &Frame, node_id: u8) -> Option<u16> {
    match frame.data() {
        // The segment of a longer transfer names none: 0, which is no object.
        [command, ..] if frame.id() == SDO_REQUEST + u16::from(node_id) && command >> 5 == 0 => {
            Some(0)
        }
        [_, low, high, ..] if frame.id() == SDO_REQUEST + u16::from(node_id) => {
            Some(u16::from_le_bytes([*low, *high]))
        }
        _ => None,
    }
}

/// All objects of the drive itself, and what its receive PDOs are made of.
fn moves_an_axle(index: u16) -> bool {
    matches!(index, 0x1400..=0x17ff | 0x2000..)
}

fn is_mapping(index: u16) -> bool {
    matches!(index, 0x1600..=0x17ff | 0x1a00..=0x1bff)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONE: Condition = Condition {
        guard_alive: false,
        control_runs: true,
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
            // Expedited and segmented, each by its first request.
            for command in [0x23, 0x2b, 0x2f, 0x20, 0x21] {
                let write = Frame::new(0x605, &[command, low, high, 1, 0, 0, 0, 0]).unwrap();
                let code = aborted(evaluate(&write, 5, guarded));
                assert_eq!(code, Some(DEVICE_STATE), "{index:#x}");
            }
            let read = Frame::new(0x605, &[0x40, low, high, 0, 0, 0, 0, 0]).unwrap();
            assert_eq!(evaluate(&read, 5, guarded), Verdict::Pass, "{index:#x}");
        }
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

//! What the CANopen stack must never see: frames that this version of it answers wrongly or panics on.
//!
//! * Block transfers, either way. An abort in the middle of a block upload panics the stack, its end frame is wrong for
//!   lengths that are a multiple of seven, and the segments of a block download cannot be told from other requests.
//!   Segmented transfers carry anything of this dictionary.
//! * Segmented writes to PDO mappings: an empty last segment panics the stack, and a count above eight is accepted.
//! * LSS: node ids are settings of the node, and the stack would change its own id behind the filter's back.
//! * Remote frames never get here: [`Frame`] cannot express them.

use tautrack::can::Frame;

const LSS_REQUEST: u16 = 0x7e5;
const SDO_REQUEST: u16 = 0x600;
const SDO_RESPONSE: u16 = 0x580;

/// Abort codes of CiA 301.
const COMMAND_SPECIFIER: u32 = 0x0504_0001;
const PARAMETER_LENGTH: u32 = 0x0607_0010;
const VALUE_TOO_HIGH: u32 = 0x0609_0031;

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

/// Judges `frame`, received by node `node_id`.
pub fn judge(frame: &Frame, node_id: u8) -> Verdict {
    let node = u16::from(node_id);
    if frame.id() == LSS_REQUEST {
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
    match command >> 5 {
        5 | 6 => abort(COMMAND_SPECIFIER),
        1 if is_mapping(u16::from_le_bytes([index_low, index_high])) => {
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

fn is_mapping(index: u16) -> bool {
    matches!(index, 0x1600..=0x17ff | 0x1a00..=0x1bff)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(bytes: [u8; 8]) -> Verdict {
        judge(&Frame::new(0x605, &bytes).unwrap(), 5)
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
            judge(&Frame::new(0x606, &[0xa0; 8]).unwrap(), 5),
            Verdict::Pass
        );
        assert_eq!(
            judge(&Frame::new(0x7e5, &[4, 1]).unwrap(), 5),
            Verdict::Drop
        );
        assert_eq!(
            judge(&Frame::new(0x605, &[0x40]).unwrap(), 5),
            Verdict::Drop
        );
    }
}

//! Payloads of the process data objects (PDOs). Their fields stand in the tables of the object
//! dictionaries (`dictionary/*.toml`), from which the build script writes the calls of `payload!`.
//! Each field has a fixed scale, which its comment states.

use super::network::function;
use crate::can::Frame;

/// A payload that a PDO carries.
pub trait Payload: Sized {
    /// Length in bytes.
    const LENGTH: usize;
    /// Reads the payload from at least [`Self::LENGTH`] bytes; `None` if there are fewer.
    fn read(bytes: &[u8]) -> Option<Self>;
    /// Returns the payload's bytes, followed by zeros.
    fn bytes(&self) -> [u8; 8];

    /// Creates the frame of this payload, with the identifier `function` + `node`.
    fn frame(&self, function: u16, node: u8) -> Frame {
        Frame::new(
            (function + u16::from(node)) & Frame::MAX_ID,
            &self.bytes()[..Self::LENGTH],
        )
        .unwrap_or_default()
    }

    /// Returns the payload in `received`, if its identifier is `function` + `node` and it is long
    /// enough.
    fn from_frame(received: &Frame, function: u16, node: u8) -> Option<Self> {
        (received.id() == function + u16::from(node))
            .then(|| Self::read(received.data()))
            .flatten()
    }
}

macro_rules! payload {
    ($(#[doc = $doc:literal])* $name:ident { $($(#[doc = $field_doc:literal])* $field:ident: $type:ty = $object:literal,)* }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
        pub struct $name { $($(#[doc = $field_doc])* pub $field: $type,)* }

        impl $name {
            /// The mapped objects in order: index, sub-index and number of bits, as in the PDO
            /// mapping records.
            pub const MAPPING: &'static [u32] = &[$($object << 8 | 8 * size_of::<$type>() as u32,)*];
        }

        impl Payload for $name {
            const LENGTH: usize = 0 $(+ size_of::<$type>())*;

            fn read(bytes: &[u8]) -> Option<Self> {
                #[allow(unused_mut)]
                let mut rest = bytes;
                Some(Self { $($field: {
                    let (head, tail) = rest.split_first_chunk()?;
                    rest = tail;
                    let _ = rest;
                    <$type>::from_le_bytes(*head)
                },)* })
            }

            fn bytes(&self) -> [u8; 8] {
                let mut bytes = [0; 8];
                let mut at = 0;
                $(for byte in self.$field.to_le_bytes() {
                    bytes[at] = byte;
                    at += 1;
                })*
                let _ = at;
                bytes
            }
        }
    };
}

include!(concat!(env!("OUT_DIR"), "/payloads.rs"));

/// Values of [`OperatorCommand::request`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Request {
    /// Switch the motors off at once. A robot on a slope is then free to roll.
    Disarm = 0,
    /// Home the drives that are not homed, then drive.
    Arm = 1,
    /// Stop now and hold.
    Stop = 2,
    /// Clear latched faults and a trip. A change to this value counts, and it must persist for
    /// three commands, as [`Request::Disarm`] and [`Request::Arm`] must.
    Reset = 3,
    /// Supervised override: a tripped guard passes the command at crawl speed while this request
    /// lasts.
    Override = 4,
    /// Back off: a tripped guard moves the robot back at crawl speed while this request lasts, if
    /// the settings allow it.
    BackOff = 5,
    /// Stop now, trip the guard, and hold.
    EmergencyStop = 6,
    /// As [`Request::Arm`], and the operator confirms that drives are homed off level ground.
    ArmOffLevel = 7,
}

/// Bit of [`OperatorCommand::request`] that is added to the [`Request`] while the dead-man switch
/// is held.
pub const DEAD_MAN_HELD: u8 = 0x80;

/// Bit of [`OperatorCommand::request`] that is added to the [`Request`] while the belts shall be
/// released. Robots without a screw ignore it.
pub const BELTS_RELEASED: u8 = 0x40;

/// Bit of [`OperatorCommand::request`] that is added to the [`Request`] while the robot shall clear
/// obstacles by itself. Robots without such a controller ignore it.
pub const CLEARANCE: u8 = 0x20;

impl Request {
    /// Returns the request in a command byte. Unknown values are [`Request::Stop`].
    pub fn from_byte(byte: u8) -> Self {
        match byte & !(DEAD_MAN_HELD | BELTS_RELEASED | CLEARANCE) {
            0 => Self::Disarm,
            1 => Self::Arm,
            3 => Self::Reset,
            4 => Self::Override,
            5 => Self::BackOff,
            6 => Self::EmergencyStop,
            7 => Self::ArmOffLevel,
            _ => Self::Stop,
        }
    }

    /// Returns whether this requests to arm and to drive.
    pub fn drives(self) -> bool {
        matches!(self, Self::Arm | Self::ArmOffLevel)
    }
}

/// Returns the function code of the transmit PDO with this number, counted from 1.
pub const fn transmit(number: usize) -> u16 {
    function::TPDO[number - 1]
}

/// Returns the function code of the receive PDO with this number, counted from 1.
pub const fn receive(number: usize) -> u16 {
    function::RPDO[number - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_payload_survives_its_frame() {
        let set_point = PositionSetPoint {
            controlword: 0x000f,
            mode: -1,
            target: -123_456_789,
        };
        let frame = set_point.frame(receive(1), 4);
        assert_eq!((frame.id(), frame.data().len()), (0x204, 7));
        assert_eq!(
            PositionSetPoint::from_frame(&frame, receive(1), 4),
            Some(set_point)
        );
        assert_eq!(PositionSetPoint::from_frame(&frame, receive(1), 5), None);
        assert_eq!(DriveMotion::read(&[1, 2, 3]), None);
    }

    #[test]
    fn mappings_name_object_and_bits() {
        assert_eq!(DriveMotion::MAPPING, [0x6064_0020, 0x606c_0020]);
        assert_eq!(OperatorCommand::MAPPING[4], 0x4000_0508);
    }

    /// The predefined connection set of CiA 301, and the fifth transmit PDO.
    #[test]
    fn identifiers_are_those_of_the_predefined_connections() {
        let transmitted = [1, 2, 3, 4, 5].map(transmit);
        assert_eq!(transmitted, [0x180, 0x280, 0x380, 0x480, 0x680]);
        let received = [1, 2, 3, 4].map(receive);
        assert_eq!(received, [0x200, 0x300, 0x400, 0x500]);
    }

    /// With and without each flag. What no request has stops.
    #[test]
    fn every_request_is_read_from_its_byte() {
        let requests = [
            Request::Disarm,
            Request::Arm,
            Request::Stop,
            Request::Reset,
            Request::Override,
            Request::BackOff,
            Request::EmergencyStop,
            Request::ArmOffLevel,
        ];
        for (byte, request) in (0..).zip(requests) {
            assert_eq!(request as u8, byte);
            for flags in [
                0,
                DEAD_MAN_HELD,
                BELTS_RELEASED,
                DEAD_MAN_HELD | BELTS_RELEASED,
                CLEARANCE,
            ] {
                assert_eq!(Request::from_byte(byte | flags), request);
            }
        }
        for byte in 0..=u8::MAX {
            let unknown = byte & 0x18 != 0;
            assert!(
                !unknown || Request::from_byte(byte) == Request::Stop,
                "{byte:#x}"
            );
        }
    }
}

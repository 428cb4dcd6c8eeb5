//! Payloads of the process data objects (PDOs). Each field has a fixed scale, which its comment
//! states. The object dictionaries map the same fields in the same order.

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
            /// The meaning of each mapped object, in the order of [`Self::MAPPING`].
            pub const MEANINGS: &'static [&'static str] = &[$(concat!($($field_doc),*),)*];
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

payload! {
    /// Set-point of a position mode: RPDO 1 of axle and screw.
    PositionSetPoint {
        /// Controlword of CiA 402.
        controlword: u16 = 0x60_4000,
        /// Mode of operation.
        mode: i8 = 0x60_6000,
        /// Target position; axle: 2^-`position_bits` turn of the output shaft, screw: 2^-24 m of
        /// extension.
        target: i32 = 0x60_7a00,
    }
}

payload! {
    /// Set-point of a velocity mode: RPDO 2 of axle and screw.
    VelocitySetPoint {
        /// Controlword of CiA 402.
        controlword: u16 = 0x60_4000,
        /// Mode of operation.
        mode: i8 = 0x60_6000,
        /// Target velocity; axle: 1e-6 rad/s of the output shaft, screw: 1e-9 m/s.
        target: i32 = 0x60_ff00,
    }
}

payload! {
    /// Set-point of torque mode: RPDO 4 of the axle. A screw has no such PDO.
    TorqueSetPoint {
        /// Controlword of CiA 402.
        controlword: u16 = 0x60_4000,
        /// Mode of operation.
        mode: i8 = 0x60_6000,
        /// Target torque: 0.01 N m at the output shaft; screw: force, N.
        target: i16 = 0x60_7100,
    }
}

payload! {
    /// Torque feed-forward (CiA 402: torque offset): RPDO 3 of axle and screw.
    TorqueOffset {
        /// Torque feed-forward, added to the torque of the loops: 0.01 N m at the output shaft;
        /// screw: force, N.
        torque: i16 = 0x60_b200,
    }
}

payload! {
    /// Motion of a drive at the last SYNC: TPDO 1 of axle and screw.
    DriveMotion {
        /// Position, scaled as [`PositionSetPoint::target`].
        position: i32 = 0x60_6400,
        /// Velocity, scaled as [`VelocitySetPoint::target`].
        velocity: i32 = 0x60_6c00,
    }
}

payload! {
    /// Status of a drive: TPDO 2 of axle and screw.
    DriveStatus {
        /// Statusword of CiA 402; bit 14: homed; bit 15: the rotor is being aligned.
        statusword: u16 = 0x60_4100,
        /// Error code (`tautrack::faults`); 0 is none.
        error_code: u16 = 0x60_3f00,
        /// Torque at the output shaft computed from the current, 0.01 N m; screw: its force, N.
        torque: i16 = 0x60_7700,
        /// Motor current, mA.
        current: i16 = 0x60_7800,
    }
}

payload! {
    /// Command of the operator: RPDO 1 of the guard. Eight bytes, sent at least once every
    /// `operator_timeout`.
    OperatorCommand {
        /// Commanded forward speed over ground, mm/s.
        forward: i16 = 0x40_0001,
        /// Commanded yaw rate, counter-clockwise from above, mrad/s.
        yaw_rate: i16 = 0x40_0002,
        /// Commanded posture, as the robot's posture word; B2P2: chassis angle, front up positive,
        /// 2^-16 turn.
        posture: i16 = 0x40_0003,
        /// What the operator requests besides motion: a [`Request`], plus 0x80 while the dead-man
        /// switch is held.
        request: u8 = 0x40_0004,
        /// Sequence number: one more than in the previous command; 0 follows 255. It shows that the
        /// operator is present, and that there is only one.
        sequence: u8 = 0x40_0005,
    }
}

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

impl Request {
    /// Returns the request in a command byte. Unknown values are [`Request::Stop`].
    pub fn from_byte(byte: u8) -> Self {
        match byte & !DEAD_MAN_HELD {
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

payload! {
    /// Odometry and attitude of the robot: TPDO 1 of the guard.
    GuardMotion {
        /// Distance travelled, from the encoders of the drives, forward positive, 1e-6 m.
        odometry: i32 = 0x40_0200,
        /// Pitch, nose up positive, 0.01 degree (CiA 410 slope long16).
        pitch: i16 = 0x60_1000,
        /// Roll, left side up positive, 0.01 degree (CiA 410 slope lateral16).
        roll: i16 = 0x60_2000,
    }
}

payload! {
    /// State of the guard and its reasons: TPDO 2 of the guard.
    GuardState {
        /// State of the guard (`tautrack::node::guard::State`).
        state: u8 = 0x40_0101,
        /// Verdict on the newest command, with the edge or the reason
        /// (`tautrack::stability::filter::Verdict`).
        verdict: u8 = 0x40_0102,
        /// Speed scale: what the guard leaves of the commanded speed, percent.
        scale: u8 = 0x40_0103,
        /// Node whose fault or loss holds the robot; 0 for none.
        fault_node: u8 = 0x40_0104,
        /// Error code of that node (`tautrack::faults`).
        fault_code: u16 = 0x40_0105,
        /// Heading, counter-clockwise from above, 2^-16 turn.
        heading: i16 = 0x40_0106,
    }
}

payload! {
    /// Signed margins of the centre of gravity to the edges of the support, mm, negative outside of
    /// the support: TPDO 3 of the guard.
    ///
    /// A margin is the distance in the support plane from the projected centre of gravity to an
    /// edge.
    GuardMargins {
        /// Margin to the rear edge, mm.
        back: i16 = 0x40_0301,
        /// Margin to the front edge, mm.
        front: i16 = 0x40_0302,
        /// Margin to the left edge, mm.
        left: i16 = 0x40_0303,
        /// Margin to the right edge, mm.
        right: i16 = 0x40_0304,
    }
}

payload! {
    /// Commanded and passed speed and posture: TPDO 4 of the guard.
    GuardPassed {
        /// Commanded forward speed, mm/s.
        asked_speed: i16 = 0x40_0401,
        /// Passed forward speed, mm/s.
        passed_speed: i16 = 0x40_0402,
        /// Commanded posture, as the robot's posture word.
        asked_posture: i16 = 0x40_0403,
        /// Passed posture, as the robot's posture word.
        passed_posture: i16 = 0x40_0404,
    }
}

payload! {
    /// Position of the robot: TPDO 5 of the guard, ten times a second. Objects 0x4010 to 0x4012
    /// have it with a finer resolution, and do not saturate.
    GuardPosition {
        /// Distance north of the origin (q1), cm; saturates.
        north: i16 = 0x40_1401,
        /// Distance east of the origin (q2), cm; saturates.
        east: i16 = 0x40_1402,
        /// Height above the origin (q3), cm; saturates.
        up: i16 = 0x40_1403,
        /// Validity (`tautrack::estimate::state::Validity`) of q1 in bits 0 and 1, of q2, q3 and q4
        /// in the next pairs of bits.
        validity: u8 = 0x40_1404,
        /// Age of the newest believed fix, 0.1 s; saturates; 255 without a fix.
        age: u8 = 0x40_1405,
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

    /// With and without the dead-man switch. What no request has stops.
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
            assert_eq!(Request::from_byte(byte), request);
            assert_eq!(Request::from_byte(byte | DEAD_MAN_HELD), request);
        }
        for byte in 8..=0x7f {
            assert_eq!(Request::from_byte(byte), Request::Stop);
        }
    }
}

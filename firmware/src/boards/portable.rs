//! Parts of a board that need only the traits of embedded-hal and embedded-can, for every chip
//! whose library implements these.

use super::OperatorSwitches;
use embedded_can::{Id, StandardId};
use embedded_hal::digital::InputPin;
use tautrack::can::Frame;
use tautrack::sensors::Switches;

/// Inputs of home and limit switches, which are between the input and ground.
///
/// A limit switch is closed in the range of travel, so a broken wire counts as actuated. The home
/// switch closes when it is actuated. An input that cannot be read counts as an open switch. A
/// switch without an input counts as not actuated.
pub struct SwitchInputs<H, P, N> {
    /// Home switch, if there is one.
    pub home: Option<H>,
    /// Limit switch at the end of the positive direction, if there is one.
    pub positive_limit: Option<P>,
    /// Limit switch at the end of the negative direction, if there is one.
    pub negative_limit: Option<N>,
}

impl<H: InputPin, P: InputPin, N: InputPin> SwitchInputs<H, P, N> {
    /// State of the switches.
    pub fn read(&mut self) -> Switches {
        Switches {
            home: self
                .home
                .as_mut()
                .is_some_and(|home| home.is_low().unwrap_or(false)),
            positive_limit: self
                .positive_limit
                .as_mut()
                .is_some_and(|limit| limit.is_high().unwrap_or(true)),
            negative_limit: self
                .negative_limit
                .as_mut()
                .is_some_and(|limit| limit.is_high().unwrap_or(true)),
        }
    }
}

/// Inputs of the operator's switches, which are between the input and ground.
///
/// The emergency stop opens when it is actuated, and the dead-man switch when it is released. So a
/// broken wire prevents motion, and so does an input that cannot be read.
pub struct OperatorInputs<E, D> {
    /// Emergency stop.
    pub emergency_stop: E,
    /// Dead-man switch.
    pub dead_man: D,
}

impl<E: InputPin, D: InputPin> OperatorInputs<E, D> {
    /// State of the switches.
    pub fn read(&mut self) -> OperatorSwitches {
        OperatorSwitches {
            emergency_stop: self.emergency_stop.is_high().unwrap_or(true),
            dead_man_released: self.dead_man.is_high().unwrap_or(true),
        }
    }
}

/// Converts a frame that a CAN controller has received. `None` for remote frames and for extended
/// identifiers, which no node uses.
pub fn received(frame: &impl embedded_can::Frame) -> Option<Frame> {
    match frame.id() {
        Id::Standard(id) if frame.is_data_frame() => Frame::new(id.as_raw(), frame.data()),
        _ => None,
    }
}

/// Converts a frame for a CAN controller; `None` if the controller cannot send it.
pub fn to_send<F: embedded_can::Frame>(frame: &Frame) -> Option<F> {
    F::new(StandardId::new(frame.id())?, frame.data())
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_can::ExtendedId;
    use embedded_hal::digital::{Error, ErrorKind, ErrorType};
    use std::vec::Vec;

    /// Level of an input; `None` if it cannot be read.
    struct Input(Option<bool>);

    #[derive(Debug)]
    struct Broken;

    impl Error for Broken {
        fn kind(&self) -> ErrorKind {
            ErrorKind::Other
        }
    }

    impl ErrorType for Input {
        type Error = Broken;
    }

    impl InputPin for Input {
        fn is_high(&mut self) -> Result<bool, Broken> {
            self.0.ok_or(Broken)
        }

        fn is_low(&mut self) -> Result<bool, Broken> {
            self.0.map(|high| !high).ok_or(Broken)
        }
    }

    fn switches(levels: [Option<bool>; 3]) -> Switches {
        let [home, positive_limit, negative_limit] = levels.map(Input);
        SwitchInputs {
            home: Some(home),
            positive_limit: Some(positive_limit),
            negative_limit: Some(negative_limit),
        }
        .read()
    }

    #[test]
    fn a_broken_wire_counts_as_an_actuated_limit_switch_and_no_home_switch() {
        let stopped = Switches {
            home: false,
            positive_limit: true,
            negative_limit: true,
        };
        assert_eq!(switches([Some(true); 3]), stopped);
        assert_eq!(switches([None; 3]), stopped);
        let in_range = Switches {
            home: true,
            positive_limit: false,
            negative_limit: false,
        };
        assert_eq!(switches([Some(false); 3]), in_range);
        let at_positive_end = switches([Some(true), Some(true), Some(false)]);
        assert!(at_positive_end.positive_limit && !at_positive_end.negative_limit);
    }

    #[test]
    fn a_broken_wire_to_a_switch_of_the_operator_prevents_motion() {
        let read = |levels: [Option<bool>; 2]| {
            let [emergency_stop, dead_man] = levels.map(Input);
            let mut inputs = OperatorInputs {
                emergency_stop,
                dead_man,
            };
            let switches = inputs.read();
            [switches.emergency_stop, switches.dead_man_released]
        };
        assert_eq!(read([Some(true); 2]), [true; 2]);
        assert_eq!(read([None; 2]), [true; 2]);
        assert_eq!(read([Some(false); 2]), [false; 2]);
        assert_eq!(read([Some(true), Some(false)]), [true, false]);
    }

    /// Frame of a controller.
    struct Other {
        id: Id,
        remote: bool,
        data: Vec<u8>,
    }

    impl embedded_can::Frame for Other {
        fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
            (data.len() <= 8).then(|| Self {
                id: id.into(),
                remote: false,
                data: data.into(),
            })
        }

        fn new_remote(id: impl Into<Id>, _: usize) -> Option<Self> {
            Some(Self {
                id: id.into(),
                remote: true,
                data: Vec::new(),
            })
        }

        fn is_extended(&self) -> bool {
            matches!(self.id, Id::Extended(_))
        }

        fn is_remote_frame(&self) -> bool {
            self.remote
        }

        fn id(&self) -> Id {
            self.id
        }

        fn dlc(&self) -> usize {
            self.data.len()
        }

        fn data(&self) -> &[u8] {
            &self.data
        }
    }

    #[test]
    fn frames_pass_both_ways_but_remote_and_extended_ones() {
        use embedded_can::Frame as _;
        for (id, data) in [(0, &[] as &[u8]), (0x185, &[1, 2, 3]), (0x7ff, &[9; 8])] {
            let frame = Frame::new(id, data).unwrap();
            let sent: Other = to_send(&frame).unwrap();
            assert_eq!(sent.id, Id::Standard(StandardId::new(id).unwrap()));
            assert_eq!(sent.data, data);
            assert_eq!(received(&sent), Some(frame));
        }
        let remote = Other::new_remote(StandardId::new(0x705).unwrap(), 1).unwrap();
        assert_eq!(received(&remote), None);
        let extended = Other::new(ExtendedId::new(5).unwrap(), &[1]).unwrap();
        assert_eq!(received(&extended), None);
    }
}

//! Sensor readings of the simulated robot in the current step.

use core::cell::RefCell;
use critical_section::Mutex;
use tautrack::link::Sensors;

pub(super) static INPUTS: Mutex<RefCell<Inputs>> = Mutex::new(RefCell::new(Inputs {
    sensors: Sensors {
        encoder_frozen: false,
        shaft_torque: 0.0,
        supply_voltage: 0.0,
        switches: tautrack::sensors::Switches {
            home: false,
            positive_limit: false,
            negative_limit: false,
        },
        body: None,
    },
    encoder: 0,
}));

pub(super) struct Inputs {
    pub sensors: Sensors,
    pub encoder: i32,
}

/// Sensor values of the current step.
pub fn sensors() -> Sensors {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().sensors)
}

/// Encoder counts at the end of the current step.
pub fn encoder() -> i32 {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().encoder)
}

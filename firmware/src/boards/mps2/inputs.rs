//! Sensor readings of the simulated robot in the current step.

use core::cell::RefCell;
use critical_section::Mutex;
use tautrack::link::Sensors;
use tautrack::sensors::Switches;

pub(super) static INPUTS: Mutex<RefCell<Inputs>> = Mutex::new(RefCell::new(Inputs {
    sensors: Sensors {
        encoder_frozen: false,
        shaft_torque: 0.0,
        supply_voltage: 0.0,
        switches: Switches {
            home: false,
            positive_limit: false,
            negative_limit: false,
        },
        body: None,
    },
    encoder: 0,
    encoder_broken: false,
    index: false,
}));

pub(super) struct Inputs {
    pub sensors: Sensors,
    pub encoder: i32,
    pub encoder_broken: bool,
    /// The encoder's index gave a pulse.
    pub index: bool,
}

/// Supply voltage of the current step, V.
pub fn supply_voltage() -> f32 {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().sensors.supply_voltage)
}

/// Limit switches and home switch in the current step.
pub fn switches() -> Switches {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().sensors.switches)
}

/// Encoder counts at the end of the current step.
pub fn encoder() -> i32 {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().encoder)
}

/// Whether the rotor sensor is broken.
pub fn encoder_broken() -> bool {
    critical_section::with(|cs| INPUTS.borrow(cs).borrow().encoder_broken)
}

/// Count of the rotor sensor at a pulse of its index in the current step. The simulated sensor
/// counts within a turn, which begins there.
pub fn index() -> Option<u32> {
    critical_section::with(|cs| {
        let pulse = &mut INPUTS.borrow(cs).borrow_mut().index;
        core::mem::take(pulse).then_some(0)
    })
}

//! Readings at the moment of the first fault.

use super::{Axle, Inputs};
use crate::bus::scale::{deci, milli, milli_i32};
use crate::faults::Faults;

/// Readings of the control period in which the first fault was raised (object 0x2040).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Snapshot {
    /// Code of the fault with the strongest reaction among those raised in this period.
    pub code: u16,
    /// Measured motor current, mA.
    pub current: i16,
    /// Demanded motor current, mA.
    pub demand: i16,
    /// Supply voltage, mV.
    pub supply_voltage: i32,
    /// Velocity in the unit of object 0x606C.
    pub velocity: i32,
    /// Position in the unit of object 0x6064.
    pub position: i32,
    /// Temperature of the bridge, 0.1 degree Celsius; [`NO_SENSOR`] without a reading.
    pub bridge_temperature: i16,
    /// Temperature of the motor, as that of the bridge.
    pub motor_temperature: i16,
}

/// Temperature where no sensor is.
pub const NO_SENSOR: i16 = i16::MIN;

impl Axle {
    /// Records the readings if `raised` are the first faults since the last reset.
    pub(super) fn take_snapshot(&self, raised: Faults, inputs: &Inputs) -> Option<Snapshot> {
        if !self.latch.faults().is_empty() {
            return None;
        }
        let fault = raised.strongest()?;
        let tenths = |temperature: Option<f32>| match temperature {
            Some(celsius) if celsius.is_finite() => deci(celsius),
            _ => NO_SENSOR,
        };
        Some(Snapshot {
            code: fault.code(),
            current: milli(inputs.current),
            demand: milli(self.demand),
            supply_voltage: milli_i32(inputs.supply_voltage),
            velocity: self.scale.velocity_to_bus(self.velocity()),
            position: self.scale.position_to_bus(self.position()),
            bridge_temperature: tenths(inputs.temperatures.bridge),
            motor_temperature: tenths(inputs.temperatures.motor),
        })
    }
}

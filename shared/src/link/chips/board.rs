//! The sensor chips of the guard's board, with their faults.

use super::inclinometer::Inclinometer;
use super::inertial_unit::InertialUnit;
use super::magnetometer::Magnetometer;
use crate::link::{BodyMeasurands, ChipFault};
use crate::motor::model::noise::Noise;

/// Addresses of the chips; the pin SA0 of the inertial unit is low, that of the inclinometer high.
const INERTIAL_UNIT: u8 = 0x6a;
const MAGNETOMETER: u8 = 0x1e;
const INCLINOMETER: u8 = 0x19;
/// Number of steps after power-up in which the chips boot and do not answer. The data sheet of the
/// inertial unit says 10 ms at most.
const BOOT_STEPS: u8 = 10;

/// The chips, on one I2C bus.
pub struct Chips {
    inertial_unit: InertialUnit,
    magnetometer: Magnetometer,
    inclinometer: Inclinometer,
    /// Faults of inertial unit, magnetometer and inclinometer in this step.
    faults: [Option<ChipFault>; 3],
    /// Numbers of the fault [`ChipFault::Noise`].
    noise: Noise,
    /// A chip holds the data line low. Only clock pulses free it.
    held: bool,
    booted: u8,
    /// Register that is read next.
    register: u8,
}

/// No chip acknowledges the address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct NoAcknowledge;

impl Chips {
    /// The chips when they are switched on. `seed` is that of the run.
    pub const fn new(seed: u64) -> Self {
        Self {
            inertial_unit: InertialUnit::RESET,
            magnetometer: Magnetometer::RESET,
            inclinometer: Inclinometer::RESET,
            faults: [None; 3],
            noise: Noise::new(seed),
            held: false,
            booted: 0,
            register: 0,
        }
    }

    /// Runs the chips for one step.
    pub fn measure(&mut self, acts: &BodyMeasurands) {
        self.faults = acts.faults;
        self.held |= self.is_stuck();
        self.booted = self.booted.saturating_add(1);
        let [inertial_unit, magnetometer, inclinometer] = acts.faults;
        let noise = &mut self.noise;
        self.inertial_unit.step(acts, inertial_unit, noise);
        self.magnetometer.step(acts, magnetometer, noise);
        self.inclinometer.step(acts, inclinometer, noise);
    }

    fn is_stuck(&self) -> bool {
        self.faults.contains(&Some(ChipFault::BusStuck))
    }

    /// Whether a chip holds the data line low.
    pub fn held(&self) -> bool {
        self.held
    }

    /// Gives clock pulses, which free the data line unless the fault lasts.
    pub fn pulse(&mut self) {
        self.held = self.is_stuck();
    }

    /// Number of the chip with this address, if it answers.
    fn number(&self, address: u8) -> Result<usize, NoAcknowledge> {
        let number = match address {
            INERTIAL_UNIT => 0,
            MAGNETOMETER => 1,
            INCLINOMETER => 2,
            _ => return Err(NoAcknowledge),
        };
        let silent = self.faults[number] == Some(ChipFault::NoAcknowledge);
        if silent || self.booted < BOOT_STEPS {
            return Err(NoAcknowledge);
        }
        Ok(number)
    }

    /// Writes bytes to a chip. The first one is the address of a register, in which the second one
    /// goes, and from which a read goes on.
    ///
    /// # Errors
    /// No chip acknowledges the address.
    pub fn write(&mut self, address: u8, bytes: &[u8]) -> Result<(), NoAcknowledge> {
        let number = self.number(address)?;
        let Some((first, values)) = bytes.split_first() else {
            return Ok(());
        };
        self.register = *first;
        if values.is_empty() {
            return Ok(());
        }
        match number {
            0 => self.inertial_unit.write(*first, values),
            1 => self.magnetometer.write(*first, values),
            _ => self.inclinometer.write(*first, values),
        }
        Ok(())
    }

    /// Reads registers of a chip, from the one that the last write has addressed.
    ///
    /// # Errors
    /// No chip acknowledges the address.
    pub fn read(&mut self, address: u8, bytes: &mut [u8]) -> Result<(), NoAcknowledge> {
        match self.number(address)? {
            0 => self.inertial_unit.read(self.register, bytes),
            1 => self.magnetometer.read(self.register, bytes),
            _ => self.inclinometer.read(self.register, bytes),
        }
        Ok(())
    }
}

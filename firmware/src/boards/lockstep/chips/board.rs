//! The sensor chips of the guard's board, with their faults.

use super::inertial_unit::InertialUnit;
use super::magnetometer::Magnetometer;
use core::cell::RefCell;
use critical_section::Mutex;
use embedded_hal_async::i2c::{ErrorKind, NoAcknowledgeSource, Operation};
use tautrack::link::{BodyMeasurands, ChipFault};
use tautrack::motor::model::noise::Noise;

/// Addresses of the chips; the pin SA0 of the inertial unit is low.
const INERTIAL_UNIT: u8 = 0x6a;
const MAGNETOMETER: u8 = 0x1e;
/// Number of steps after power-up in which the chips boot and do not answer. The data sheet of the
/// inertial unit says 10 ms at most.
const BOOT_STEPS: u8 = 10;

static CHIPS: Mutex<RefCell<Chips>> = Mutex::new(RefCell::new(Chips {
    inertial_unit: InertialUnit::RESET,
    magnetometer: Magnetometer::RESET,
    faults: [None; 2],
    noise: Noise::new(0),
    held: false,
    booted: 0,
}));

pub(super) struct Chips {
    inertial_unit: InertialUnit,
    magnetometer: Magnetometer,
    /// Faults of the inertial unit and of the magnetometer in this step.
    faults: [Option<ChipFault>; 2],
    /// Numbers of the fault [`ChipFault::Noise`].
    noise: Noise,
    /// A chip holds the data line low. Only clock pulses free it.
    held: bool,
    booted: u8,
}

/// Runs `action` with the chips.
pub(super) fn with<R>(action: impl FnOnce(&mut Chips) -> R) -> R {
    critical_section::with(|cs| action(&mut CHIPS.borrow(cs).borrow_mut()))
}

/// Switches the chips on. `seed` is that of the run.
pub fn power_up(seed: u64) {
    with(|chips| chips.noise = Noise::new(seed));
}

/// Runs the chips for one step.
pub fn measure(acts: &BodyMeasurands) {
    with(|chips| {
        chips.faults = acts.faults;
        chips.held |= chips.is_stuck();
        chips.booted = chips.booted.saturating_add(1);
        let [inertial_unit, magnetometer] = acts.faults;
        let noise = &mut chips.noise;
        chips.inertial_unit.step(acts, inertial_unit, noise);
        chips.magnetometer.step(acts, magnetometer, noise);
    });
}

impl Chips {
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

    /// Carries a transfer out. A write begins with the register's address, from which a read goes
    /// on.
    pub fn transfer(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        let number = match address {
            INERTIAL_UNIT => 0,
            MAGNETOMETER => 1,
            _ => return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address)),
        };
        let silent = self.faults[number] == Some(ChipFault::NoAcknowledge);
        if silent || self.booted < BOOT_STEPS {
            return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address));
        }
        let mut register = 0;
        for operation in operations {
            match (operation, number) {
                (Operation::Read(bytes), 0) => self.inertial_unit.read(register, bytes),
                (Operation::Read(bytes), _) => self.magnetometer.read(register, bytes),
                (Operation::Write(bytes), _) => {
                    let Some((first, values)) = bytes.split_first() else {
                        continue;
                    };
                    register = *first;
                    if values.is_empty() {
                        continue;
                    }
                    if number == 0 {
                        self.inertial_unit.write(register, values);
                    } else {
                        self.magnetometer.write(register, values);
                    }
                }
            }
        }
        Ok(())
    }
}

//! The simulated sensor chips and their I2C bus: a transfer copies registers and takes no virtual
//! time.

use crate::sensors::{self, Address, Rates, SensorBus};
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_executor::{SpawnError, Spawner};
use embedded_hal_async::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use tautrack::link::BodyMeasurands;
use tautrack::link::chips::Chips;

static CHIPS: Mutex<RefCell<Chips>> = Mutex::new(RefCell::new(Chips::new(0)));

/// Runs `action` with the chips.
fn with<R>(action: impl FnOnce(&mut Chips) -> R) -> R {
    critical_section::with(|cs| action(&mut CHIPS.borrow(cs).borrow_mut()))
}

/// Switches the chips on. `seed` is that of the run.
pub(super) fn power_up(seed: u64) {
    with(|chips| *chips = Chips::new(seed));
}

/// Runs the chips for one step.
pub(super) fn measure(acts: &BodyMeasurands) {
    with(|chips| chips.measure(acts));
}

struct Bus;

impl ErrorType for Bus {
    type Error = ErrorKind;
}

impl I2c for Bus {
    /// Ends at once, or never while a chip holds the data line low.
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        if with(|chips| chips.held()) {
            core::future::pending::<()>().await;
        }
        with(|chips| {
            operations
                .iter_mut()
                .try_for_each(|operation| match operation {
                    Operation::Read(bytes) => chips.read(address, bytes),
                    Operation::Write(bytes) => chips.write(address, bytes),
                })
        })
        .map_err(|_| ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address))
    }
}

impl SensorBus for Bus {
    async fn recover(&mut self) {
        with(Chips::pulse);
    }
}

#[embassy_executor::task]
async fn read(rates: Rates) -> ! {
    sensors::run(Bus, Address::Low, rates).await
}

/// Starts the task that reads the simulated chips.
pub fn start_sensors(spawner: Spawner, rates: Rates) -> Result<(), SpawnError> {
    spawner.spawn(read(rates)?);
    Ok(())
}

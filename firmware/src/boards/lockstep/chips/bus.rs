//! I2C bus of the simulated chips.

use super::board;
use crate::sensors::{self, Address, Rates, SensorBus};
use embassy_executor::{SpawnError, Spawner};
use embedded_hal_async::i2c::{ErrorKind, ErrorType, I2c, Operation};

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
        if board::with(|chips| chips.held()) {
            core::future::pending::<()>().await;
        }
        board::with(|chips| chips.transfer(address, operations))
    }
}

impl SensorBus for Bus {
    async fn recover(&mut self) {
        board::with(board::Chips::pulse);
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

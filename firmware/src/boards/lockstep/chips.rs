//! The I2C bus of the simulated sensor chips: a transfer copies registers and takes no virtual
//! time.

use crate::sensors::SensorBus;
use core::cell::RefCell;
use core::ops::Deref;
use critical_section::Mutex;
use embedded_hal_async::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use tautrack::link::chips::Chips;

/// Bus to the chips at `P`.
pub struct Bus<P>(pub P);

impl<P: Deref<Target = Mutex<RefCell<Chips>>>> Bus<P> {
    fn with<R>(&self, action: impl FnOnce(&mut Chips) -> R) -> R {
        critical_section::with(|cs| action(&mut self.0.borrow(cs).borrow_mut()))
    }
}

impl<P> ErrorType for Bus<P> {
    type Error = ErrorKind;
}

impl<P: Deref<Target = Mutex<RefCell<Chips>>>> I2c for Bus<P> {
    /// Ends at once, or never while a chip holds the data line low.
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        if self.with(|chips| chips.held()) {
            core::future::pending::<()>().await;
        }
        self.with(|chips| {
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

impl<P: Deref<Target = Mutex<RefCell<Chips>>>> SensorBus for Bus<P> {
    async fn recover(&mut self) {
        self.with(Chips::pulse);
    }
}

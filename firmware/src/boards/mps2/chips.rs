//! The simulated sensor chips.

use crate::boards::lockstep::Bus;
use crate::sensors::{self, Address, Published, Rates};
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_executor::{SpawnError, Spawner};
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

#[embassy_executor::task]
async fn read(rates: Rates, published: &'static Published) -> ! {
    sensors::run(Bus(&CHIPS), Address::Low, rates, published).await
}

/// Starts the task that reads the simulated chips.
pub fn start_sensors(
    spawner: Spawner,
    rates: Rates,
    published: &'static Published,
) -> Result<(), SpawnError> {
    spawner.spawn(read(rates, published)?);
    Ok(())
}

//! Sensor chips on I2C3: inertial unit and magnetometer. [`crate::sensors`] reads them in a task of
//! the thread, below the control task.

use crate::boards::stm32g4::i2c::{self, Bus, Line};
use crate::sensors::{self, Address, Published, Rates};
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_executor::{SpawnError, Spawner};
use embassy_stm32::i2c::{ErrorInterruptHandler, EventInterruptHandler, I2c};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::peripherals::{DMA1_CH1, DMA1_CH2, I2C3, PC8, PC9};
use embassy_stm32::{Peri, bind_interrupts, dma, interrupt, pac};

bind_interrupts!(struct Interrupts {
    I2C3_EV => EventInterruptHandler<I2C3>;
    I2C3_ER => ErrorInterruptHandler<I2C3>;
    DMA1_CHANNEL1 => dma::InterruptHandler<DMA1_CH1>;
    DMA1_CHANNEL2 => dma::InterruptHandler<DMA1_CH2>;
});

static BUS: Mutex<RefCell<Option<Bus>>> = Mutex::new(RefCell::new(None));

/// Starts the bus. Its interrupts are less urgent than all others.
pub fn start_bus(
    controller: Peri<'static, I2C3>,
    clock: Peri<'static, PC8>,
    data: Peri<'static, PC9>,
    transmit: Peri<'static, DMA1_CH1>,
    receive: Peri<'static, DMA1_CH2>,
) {
    for line in [interrupt::I2C3_EV, interrupt::I2C3_ER] {
        line.set_priority(Priority::P4);
    }
    for line in [interrupt::DMA1_CHANNEL1, interrupt::DMA1_CHANNEL2] {
        line.set_priority(Priority::P4);
    }
    let driver = I2c::new(
        controller,
        clock,
        data,
        transmit,
        receive,
        Interrupts,
        i2c::config(),
    );
    let line = |pin| Line {
        port: pac::GPIOC,
        pin,
    };
    let bus = Bus::new(driver, pac::I2C3, line(8), line(9));
    critical_section::with(|cs| BUS.borrow(cs).replace(Some(bus)));
}

/// Starts the task that reads the chips.
///
/// # Errors
/// The task runs already.
pub fn start(
    spawner: Spawner,
    rates: Rates,
    published: &'static Published,
) -> Result<(), SpawnError> {
    if let Some(bus) = critical_section::with(|cs| BUS.borrow(cs).take()) {
        spawner.spawn(read(bus, rates, published)?);
    }
    Ok(())
}

#[embassy_executor::task]
async fn read(bus: Bus, rates: Rates, published: &'static Published) -> ! {
    sensors::run(bus, Address::Low, rates, published).await
}

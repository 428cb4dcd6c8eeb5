//! Serial line of the GNSS receiver: USART1 receives 115200 baud, 8 bits, no parity.

use crate::serial;
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::mode::Blocking;
use embassy_stm32::peripherals::{PC5, USART1};
use embassy_stm32::usart::{Config, ConfigError, UartRx};
use embassy_stm32::{Peri, interrupt, pac};
use static_cell::StaticCell;

/// Bit rate, bit/s.
const BAUD: u32 = 115_200;

/// Starts the serial line and its interrupt.
///
/// # Errors
/// The library refuses the bit rate.
pub fn start(port: Peri<'static, USART1>, receive: Peri<'static, PC5>) -> Result<(), ConfigError> {
    static PORT: StaticCell<UartRx<'static, Blocking>> = StaticCell::new();
    let mut config = Config::default();
    config.baudrate = BAUD;
    // Dropping it switches the port off.
    PORT.init(UartRx::new_blocking(port, receive, config)?);
    pac::USART1.cr1().modify(|w| w.set_rxneie(true));
    // SAFETY: the handler is below, and everything that it uses has been started.
    unsafe { interrupt::USART1.enable() };
    Ok(())
}

#[interrupt]
fn USART1() {
    let port = pac::USART1;
    let status = port.isr().read();
    if status.rxne() {
        let byte = port.rdr().read().dr() as u8;
        // A full line loses the byte; the checksum of its sentence then fails.
        serial::put(&[byte]);
    }
    // A byte that came too early raises the interrupt until its flag is cleared.
    if status.ore() {
        port.icr().write(|w| w.set_ore(true));
    }
}

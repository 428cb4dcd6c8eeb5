//! CAN transceiver and terminator of the board. Both pins act when they are high: PC11 shuts the
//! transceiver down, PC14 connects 120 ohm (UM2516, tables 3 and 4).

use core::mem;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PC11, PC14};

/// Switches the transceiver on and the terminator off.
pub fn start(shut_down: Peri<'static, PC11>, terminator: Peri<'static, PC14>) {
    // An output that is dropped disconnects its pin.
    mem::forget(Output::new(shut_down, Level::Low, Speed::Low));
    mem::forget(Output::new(terminator, Level::Low, Speed::Low));
}

//! Home and limit switches, between an input and ground.
//!
//! A limit switch is closed in the range of travel, so a broken wire counts as actuated. An axle
//! without limit switches has both inputs wired to ground. The home switch closes when it is
//! actuated.

use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::pac::gpio::vals::Idr;
use embassy_stm32::peripherals::{PB3, PB4, PB8};
use embassy_stm32::{Peri, pac};
use static_cell::StaticCell;
use tautrack::sensors::Switches;

/// Inputs of the home, the positive limit and the negative limit switch.
static INPUTS: StaticCell<[Input<'static>; 3]> = StaticCell::new();

/// Connects the pull-up resistors.
pub fn start(
    home: Peri<'static, PB8>,
    positive_limit: Peri<'static, PB3>,
    negative_limit: Peri<'static, PB4>,
) {
    INPUTS.init([
        Input::new(home, Pull::Up),
        Input::new(positive_limit, Pull::Up),
        Input::new(negative_limit, Pull::Up),
    ]);
}

/// State of the switches.
pub fn read() -> Switches {
    let levels = pac::GPIOB.idr().read();
    Switches {
        home: levels.idr(8) == Idr::LOW,
        positive_limit: levels.idr(3) == Idr::HIGH,
        negative_limit: levels.idr(4) == Idr::HIGH,
    }
}

//! Home and limit switches: see [`SwitchInputs`]. An axle without limit switches has both inputs
//! wired to ground, or a sensor at its output shaft connected to them.

use crate::boards::portable::SwitchInputs;
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::{PB3, PB4, PB8};
use tautrack::sensors::Switches;

type Inputs = SwitchInputs<Input<'static>, Input<'static>, Input<'static>>;

static INPUTS: Mutex<RefCell<Option<Inputs>>> = Mutex::new(RefCell::new(None));

/// Inputs of the limit switches: at the end of the positive direction, and of the negative one.
pub type Limits = (Peri<'static, PB3>, Peri<'static, PB4>);

/// Connects the pull-up resistors.
pub fn start(home: Option<Peri<'static, PB8>>, limits: Option<Limits>) {
    let (positive_limit, negative_limit) = limits.unzip();
    let inputs = SwitchInputs {
        home: home.map(|pin| Input::new(pin, Pull::Up)),
        positive_limit: positive_limit.map(|pin| Input::new(pin, Pull::Up)),
        negative_limit: negative_limit.map(|pin| Input::new(pin, Pull::Up)),
    };
    critical_section::with(|cs| INPUTS.borrow(cs).replace(Some(inputs)));
}

/// State of the switches.
pub fn read() -> Switches {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let mut inputs = INPUTS.borrow(cs).try_borrow_mut().ok()?;
        inputs.as_mut().map(SwitchInputs::read)
    })
    .unwrap_or_default()
}

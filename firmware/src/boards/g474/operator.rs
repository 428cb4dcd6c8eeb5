//! Emergency stop and dead-man switch: see [`OperatorInputs`].

use crate::boards::OperatorSwitches;
use crate::boards::portable::OperatorInputs;
use core::cell::RefCell;
use critical_section::Mutex;
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::{PC10, PC12};

type Inputs = OperatorInputs<Input<'static>, Input<'static>>;

static INPUTS: Mutex<RefCell<Option<Inputs>>> = Mutex::new(RefCell::new(None));

/// Connects the pull-up resistors.
pub fn start(emergency_stop: Peri<'static, PC10>, dead_man: Peri<'static, PC12>) {
    let inputs = OperatorInputs {
        emergency_stop: Input::new(emergency_stop, Pull::Up),
        dead_man: Input::new(dead_man, Pull::Up),
    };
    critical_section::with(|cs| INPUTS.borrow(cs).replace(Some(inputs)));
}

/// State of the switches.
pub fn switches() -> OperatorSwitches {
    critical_section::with(|cs| {
        // Cannot fail: the critical section excludes any other borrow.
        let mut inputs = INPUTS.borrow(cs).try_borrow_mut().ok()?;
        inputs.as_mut().map(OperatorInputs::read)
    })
    .unwrap_or(OperatorSwitches::ACTUATED)
}

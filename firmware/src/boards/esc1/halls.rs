//! Three Hall sensors on the pads of the encoder: the PWM interrupt reads their levels.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use embassy_stm32::gpio::{Input, Pull};
use embassy_stm32::peripherals::{PB6, PB7, PB8};
use embassy_stm32::{Peri, pac};
use static_cell::StaticCell;
use tautrack::motor::halls::Halls;

static HALLS: Mutex<RefCell<Halls>> = Mutex::new(RefCell::new(Halls::new()));
static BROKEN: AtomicBool = AtomicBool::new(false);
/// Number of the first of three neighbouring pins of port B.
const FIRST_PIN: u32 = 6;

/// Connects the pull-up resistors.
pub fn start(a: Peri<'static, PB6>, b: Peri<'static, PB7>, c: Peri<'static, PB8>) {
    static PINS: StaticCell<[Input<'static>; 3]> = StaticCell::new();
    PINS.init([
        Input::new(a, Pull::Up),
        Input::new(b, Pull::Up),
        Input::new(c, Pull::Up),
    ]);
}

/// Reads the sensors, and returns their count. Only the PWM interrupt calls this, in every period.
/// Otherwise it returns `None`.
#[inline(never)] // an encoder needs none of this
pub fn update() -> Option<u32> {
    let code = pac::GPIOB.idr().read().0 >> FIRST_PIN;
    critical_section::with(|cs| {
        let mut halls = HALLS.borrow(cs).try_borrow_mut().ok()?;
        let count = halls.update(code);
        BROKEN.store(halls.are_broken(), Ordering::Relaxed);
        Some(count)
    })
}

/// Whether the sensors are broken, as of the last PWM period.
pub fn are_broken() -> bool {
    BROKEN.load(Ordering::Relaxed)
}

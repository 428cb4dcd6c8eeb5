//! Starts the application of a motor board if its checksum is right. Otherwise the LED flashes
//! quickly for ever, and no output of the board is ever switched on.
#![no_std]
#![no_main]

// Includes the source file, because the library would add the application's handlers.
#[path = "../boards/esc1/image.rs"]
mod image;

use core::panic::PanicInfo;
use embassy_stm32::pac;
use embassy_stm32::pac::gpio::vals::{Moder, Odr};

/// Pin of the LED: PC6.
const LED: usize = 6;
/// Core clocks, at 16 MHz, for which the LED is on or off.
const HALF_FLASH: u32 = 1_600_000;

unsafe extern "C" {
    /// The application's flash memory, from the link script.
    static _application: u8;
    static _application_length: u8;
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let start = &raw const _application;
    let length = &raw const _application_length as usize;
    // SAFETY: the link script has the bounds of the application's flash memory.
    let application = unsafe { core::slice::from_raw_parts(start, length) };
    if image::is_valid(application) {
        // SAFETY: a valid image begins with its vector table, and no interrupt is enabled.
        unsafe {
            (*cortex_m::peripheral::SCB::PTR).vtor.write(start as u32);
            cortex_m::asm::bootload(start.cast());
        }
    }
    flash_the_led()
}

/// Handles an error in the flash memory, which the check of the application reads.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    flash_the_led()
}

/// Flashes the LED quickly for ever.
fn flash_the_led() -> ! {
    pac::RCC.ahb2enr().modify(|w| w.set_gpiocen(true));
    pac::GPIOC
        .moder()
        .modify(|w| w.set_moder(LED, Moder::OUTPUT));
    loop {
        for level in [Odr::HIGH, Odr::LOW] {
            pac::GPIOC.odr().modify(|w| w.set_odr(LED, level));
            cortex_m::asm::delay(HALF_FLASH);
        }
    }
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

//! Comparators that open the bridge when the current of a low side is too high, without software.
//!
//! The comparators notice currents from the motor into a low side, and shorts between high and low
//! side. The current loop limits the currents of both directions (`tautrack::motor::current`).
//! `analogue` has the threshold.

use super::analogue::threshold;
use embassy_stm32::pac;
use embassy_stm32::pac::comp::vals::{Blanking, Inm};
use embassy_stm32::pac::dac::vals::Mode;
use tautrack::motor::calibration::sensing;
use tautrack::settings::{Setting, Settings};

/// Comparators of phases a, b and c, counted as in the chip's manual.
pub const COMPARATORS: [usize; 3] = [1, 2, 4];

/// Starts the comparators, with the zeros and the current limit of the settings. Must be called
/// before the bridge's outputs are enabled. Phase c begins with the zero of phase b.
pub fn start(settings: &Settings) {
    pac::RCC.ahb2enr().modify(|w| w.set_dac3en(true));
    pac::RCC.apb2enr().modify(|w| w.set_syscfgen(true));
    let dac = pac::DAC3;
    dac.mcr().modify(|w| {
        // The bus clock is above 160 MHz.
        w.set_hfsel(0b10);
        for channel in 0..2 {
            w.set_mode(channel, Mode::NORMAL_INT_BUFDIS);
        }
    });
    dac.cr().modify(|w| {
        w.set_en(0, true);
        w.set_en(1, true);
    });
    let [a, b] = sensing(settings).zero;
    set_limit(settings.si(Setting::CurrentLimit), [a, b, b]);
    // Output 5 of TIM1 blanks them. Its number differs between the comparators (RM0440, table 195).
    for (comparator, blanking) in [
        (pac::COMP1, Blanking::BLANK1),
        (pac::COMP2, Blanking::BLANK1),
        (pac::COMP4, Blanking::BLANK4),
    ] {
        comparator.csr().write(|w| {
            w.set_blanksel(blanking);
            // DAC3: channel 1 for comparator 1, channel 2 for comparators 2 and 4.
            w.set_inmsel(Inm::DACA);
            // PA1, PA7 and PB0.
            w.set_inpsel(false);
            w.set_en(true);
        });
    }
}

/// Sets the current limit, A, and the zeros of phases a, b and c. Phases b and c have one
/// threshold, the higher one.
pub fn set_limit(limit: f32, [a, b, c]: [i32; 3]) {
    for (channel, zero) in [a, Ord::min(b, c)].into_iter().enumerate() {
        let code = threshold(zero, limit);
        pac::DAC3.dhr12r(channel).write(|w| w.set_dhr(code));
    }
}

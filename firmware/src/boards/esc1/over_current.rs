//! Comparators that open the bridge when the current of a low side is too high, without software.
//!
//! A comparator sees its shunt through the same divider as the op-amp, so 4/7 of the shunt's
//! voltage, on top of the voltage that makes the op-amp's output half the reference. The
//! comparators notice currents from the motor into a low side, and shorts between high and low
//! side. The current loop limits the currents of both directions (`tautrack::motor::current`).

use embassy_stm32::pac;
use embassy_stm32::pac::comp::vals::{Blanking, Inm};
use embassy_stm32::pac::dac::vals::Mode;

/// Comparators of phases a, b and c, counted as in the chip's manual.
pub const COMPARATORS: [usize; 3] = [1, 2, 4];

/// Current that opens the bridge, A. It is below the end of the op-amps' range.
const THRESHOLD_AMPERES: f32 = 57.0;
/// Voltage at the comparator for no current, V.
const BIAS: f32 = 3.3 / 2.0 / 16.0;
/// Voltage at the comparator per current, V/A.
const PER_AMPERE: f32 = 0.003 * 4.0 / 7.0;
/// Code of the converter that makes the threshold.
const CODE: u16 = ((BIAS + PER_AMPERE * THRESHOLD_AMPERES) / 3.3 * 4096.0) as u16;

/// Starts the comparators. Must be called before the bridge's outputs are enabled.
pub fn start() {
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
    for channel in 0..2 {
        dac.dhr12r(channel).write(|w| w.set_dhr(CODE));
    }
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

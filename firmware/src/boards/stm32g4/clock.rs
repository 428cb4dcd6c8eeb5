//! Clocks: 170 MHz from the crystal, with the core's boost mode.

use crate::boards::Selected;
use embassy_stm32::rcc::{Hse, HseMode, Pll, PllMul, PllRDiv, PllSource, Sysclk, mux};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals, pac};

/// Core clock, Hz. All bus and timer clocks equal it.
pub const CORE_HZ: u32 = 170_000_000;
/// Bit R1MODE of `PWR_CR5`, which is 0 in boost mode (RM0440, 6.4.5). The library's register
/// description has it at bit 0, so the library cannot clear it.
const R1MODE: u32 = 1 << 8;

/// Starts the clocks and returns the peripherals. Must be called only once.
///
/// CAN needs the accuracy of a crystal. The board's constants have its frequency, and the divider
/// that makes 4 MHz of it. As arguments they would not be constants, and take 400 bytes.
pub fn start() -> Peripherals {
    // Above 150 MHz the core needs boost mode.
    pac::RCC.apb1enr1().modify(|w| w.set_pwren(true));
    pac::PWR.cr5().modify(|w| w.0 &= !R1MODE);

    let mut config = Config::default();
    config.rcc.hsi = false;
    config.rcc.hse = Some(Hse {
        freq: Hertz(Selected::CRYSTAL_HZ),
        mode: HseMode::Oscillator,
    });
    config.rcc.pll = Some(Pll {
        source: PllSource::HSE,
        prediv: Selected::CRYSTAL_DIVIDER,
        mul: PllMul::MUL85,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = true;
    config.rcc.mux.adc12sel = mux::Adcsel::SYS;
    config.rcc.mux.fdcansel = mux::Fdcansel::PCLK1;
    embassy_stm32::init(config)
}

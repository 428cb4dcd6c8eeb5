//! Clocks: 170 MHz from the crystal, with the core's boost mode.

use crate::boards::Selected;
use embassy_stm32::pac::flash::vals::Latency;
use embassy_stm32::pac::timer::vals::Urs;
use embassy_stm32::rcc::{
    AHBPrescaler, Hse, HseMode, Pll, PllMul, PllRDiv, PllSource, Sysclk, mux,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals, pac};
use embassy_time::TICK_HZ;

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
    // The library computes with half of the bus clock. These clocks do not depend on it.
    config.rcc.mux.usart1sel = mux::Usart1sel::SYS;
    config.rcc.mux.i2c3sel = mux::I2csel::SYS;
    // The library switches from 16 MHz to the fast clock at once. Above 80 MHz the bus clock must
    // be half of it meanwhile, for at least 1 us (RM0440, 6.1.5 and 7.2.7).
    config.rcc.ahb_pre = AHBPrescaler::DIV2;
    let peripherals = embassy_stm32::init(config);
    leave_half_speed();
    // A crystal that fails breaks the bridge's timer and raises the NMI (`reset`).
    pac::RCC.cr().modify(|w| w.set_csson(true));
    peripherals
}

/// Doubles the clock of core, buses and timers to that of the PLL.
fn leave_half_speed() {
    pac::FLASH.acr().modify(|w| {
        w.set_latency(Latency::WS4);
        // Straight code waits less for the memory, and loops do not wait.
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
    while pac::FLASH.acr().read().latency() != Latency::WS4 {}
    cortex_m::asm::delay(CORE_HZ / 2 / 1_000_000);
    pac::RCC.cfgr().modify(|w| w.set_hpre(AHBPrescaler::DIV1));
    // The library's clock has just begun to count.
    let timer = pac::TIM2;
    timer
        .psc()
        .write_value((CORE_HZ / TICK_HZ as u32 - 1) as u16);
    timer.cr1().modify(|w| w.set_urs(Urs::COUNTER_ONLY));
    timer.egr().write(|w| w.set_ug(true));
    timer.cr1().modify(|w| w.set_urs(Urs::ANY_EVENT));
}

//! The three half bridges: TIM1, centre-aligned at 20 kHz.
//!
//! The gate drivers have no enable input. Their inputs are low, and all transistors open, while the
//! timer's main output enable (MOE) is 0. Software clears MOE; a break input clears it without
//! software: the comparators of [`super::over_current`], and the input "safe torque off".
//!
//! A pulse is centred on the counter's underflow, at which new compare values take effect. The
//! currents are sampled at the overflow, when all low sides conduct.

use crate::boards::stm32g4::clock::CORE_HZ;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_stm32::gpio::{Flex, OutputType, Pull};
use embassy_stm32::pac::timer::vals;
use embassy_stm32::peripherals::{PA8, PA9, PA10, PA12, PA15, PB15, PC13, TIM1};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::complementary_pwm::{
    ComplementaryPwm, ComplementaryPwmPin, Mms2, Ossi, Ossr,
};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::PwmPin;
use embassy_stm32::{Peri, pac};
use static_cell::StaticCell;
use tautrack::motor::bridge::PowerStage;

/// PWM periods per second, Hz.
pub const PWM_HZ: u32 = 20_000;
/// Compare value of a half bridge whose high side is always on. The counter counts up to it and
/// down again in a period.
pub const PERIOD: u16 = (CORE_HZ / PWM_HZ / 2) as u16;
/// The currents are sampled when the counter, counting down, reaches this value: 6 ns after its
/// overflow.
const SAMPLE_AT: u16 = PERIOD - 1;
/// Alternate function 9 of PA15: `TIM1_BKIN`.
const BREAK_FUNCTION: u8 = 9;

/// Timer and pins of the half bridges a, b and c.
pub struct Pins {
    /// The timer.
    pub timer: Peri<'static, TIM1>,
    /// Gates of the high sides.
    pub high: (Peri<'static, PA8>, Peri<'static, PA9>, Peri<'static, PA10>),
    /// Gates of the low sides.
    pub low: (
        Peri<'static, PC13>,
        Peri<'static, PA12>,
        Peri<'static, PB15>,
    ),
    /// Input "safe torque off": the bridge is open unless it is high.
    pub safe_torque_off: Peri<'static, PA15>,
    /// Time for which both transistors of a half bridge are off at each edge, ns.
    pub dead_time_ns: i32,
}

/// Opens all transistors, whatever state the timer is in. Usable before everything else and in
/// fault handlers.
#[inline]
pub fn open() {
    pac::RCC.apb2enr().modify(|w| w.set_tim1en(true));
    pac::TIM1.bdtr().modify(|w| w.set_moe(false));
}

/// Starts the timer with all transistors open.
pub fn start(pins: Pins) {
    static PWM: StaticCell<ComplementaryPwm<'static, TIM1>> = StaticCell::new();
    static SAFE_TORQUE_OFF: StaticCell<Flex<'static>> = StaticCell::new();
    let push_pull = OutputType::PushPull;
    let pwm = PWM.init(ComplementaryPwm::new(
        pins.timer,
        Some(PwmPin::new(pins.high.0, push_pull)),
        Some(ComplementaryPwmPin::new(pins.low.0, push_pull)),
        Some(PwmPin::new(pins.high.1, push_pull)),
        Some(ComplementaryPwmPin::new(pins.low.1, push_pull)),
        Some(PwmPin::new(pins.high.2, push_pull)),
        Some(ComplementaryPwmPin::new(pins.low.2, push_pull)),
        None,
        None,
        Hertz(PWM_HZ),
        CountingMode::CenterAlignedBothInterrupts,
    ));
    // The library's constructor sets MOE. No channel is enabled yet.
    pwm.set_master_output_enable(false);
    SAFE_TORQUE_OFF
        .init(Flex::new(pins.safe_torque_off))
        .set_as_af_unchecked(
            BREAK_FUNCTION,
            embassy_stm32::gpio::AfType::input(Pull::Down),
        );

    let timer = pac::TIM1;
    // While MOE is 0, the timer drives the gates low instead of releasing its pins.
    pwm.set_off_state_selection_idle(Ossi::IDLE_LEVEL);
    pwm.set_off_state_selection_run(Ossr::IDLE_LEVEL);
    // Before the break is enabled: the pin's reset polarity would open the bridge at once.
    timer.af1().modify(|w| {
        w.set_bkine(true);
        // The pin opens the bridge when it is low.
        w.set_bkinp(vals::Bkinp::INVERTED);
        for comparator in super::over_current::COMPARATORS {
            w.set_bkcmpe(comparator - 1, true);
        }
    });
    timer.bdtr().modify(|w| {
        w.set_dtg(dead_time(pins.dead_time_ns));
        w.set_bkp(0, vals::Bkp::ACTIVE_HIGH);
        w.set_bkf(0, vals::FilterValue::FCK_INT_N8);
        w.set_bke(0, true);
    });
    // The library rounds the period; with this value it is exact. The counter is stopped for it,
    // because a repetition counter written before the start makes the updates fall on the underflow
    // (RM0440, 29.3.3).
    timer.cr1().modify(|w| w.set_cen(false));
    timer.cnt().write(|w| w.set_cnt(0));
    timer.arr().write(|w| w.set_arr(PERIOD));
    pwm.set_repetition_counter(1);
    timer.ccr(3).write(|w| w.set_ccr(SAMPLE_AT));
    pwm.set_mms2(Mms2::COMPARE_OC4);
    for channel in [Channel::Ch1, Channel::Ch2, Channel::Ch3] {
        pwm.enable(channel);
    }
    timer.egr().write(|w| w.set_ug(true));
    // Dead time, idle levels and break cannot be changed any more until the next reset.
    timer.bdtr().modify(|w| w.set_lock(vals::Lock::LEVEL2));
    timer.cr1().modify(|w| w.set_cen(true));
}

/// Applies a command from the next underflow on. After a break, the bridge stays open until the
/// current loop has commanded [`PowerStage::Off`] for [`RELEASE_PERIODS`]: the drive is disabled.
#[inline]
pub fn apply(stage: PowerStage) {
    let timer = pac::TIM1;
    let compares = match stage {
        PowerStage::Off => {
            timer.bdtr().modify(|w| w.set_moe(false));
            let periods = OFF_PERIODS.load(Ordering::Relaxed).saturating_add(1);
            OFF_PERIODS.store(periods, Ordering::Relaxed);
            if periods >= RELEASE_PERIODS {
                // The flag stays set while a break input is active. Writing 1 leaves a flag as it
                // is.
                timer.sr().write(|w| w.0 = FLAGS_BUT_BREAK);
            }
            return;
        }
        PowerStage::Brake => [0; 3],
        PowerStage::Drive(compares) => compares,
    };
    OFF_PERIODS.store(0, Ordering::Relaxed);
    for (channel, compare) in compares.into_iter().enumerate() {
        timer.ccr(channel).write(|w| w.set_ccr(compare));
    }
    if !tripped() {
        timer.bdtr().modify(|w| w.set_moe(true));
    }
}

/// Whether a break input has opened the bridge, and the drive has not been disabled since.
#[inline]
pub fn tripped() -> bool {
    pac::TIM1.sr().read().bif(0)
}

/// PWM periods for which the current loop must command the bridge to be off before a break is
/// forgotten: 10 ms. An over-current opens the bridge for a few periods.
const RELEASE_PERIODS: u32 = PWM_HZ / 100;
/// PWM periods since the current loop last commanded something else than off.
static OFF_PERIODS: AtomicU32 = AtomicU32::new(0);
/// All flags of the timer but the one of break input 1 (RM0440, 29.6.5).
const FLAGS_BUT_BREAK: u32 = 0x00f3_3f7f;

/// Shortest dead time, ns, whatever the settings say.
const MINIMUM_DEAD_TIME_NS: i32 = 300;

/// Code of a dead time. The timer counts core clocks up to 127, then pairs of clocks up to 254
/// (1494 ns). A longer time counts as 254.
fn dead_time(nanoseconds: i32) -> u8 {
    let nanoseconds = Ord::max(nanoseconds, MINIMUM_DEAD_TIME_NS);
    let clocks = i64::from(nanoseconds) * i64::from(CORE_HZ) / 1_000_000_000;
    match clocks {
        ..128 => clocks as u8,
        128..254 => 0x80 | (clocks / 2 - 64) as u8,
        254.. => 0xbf,
    }
}

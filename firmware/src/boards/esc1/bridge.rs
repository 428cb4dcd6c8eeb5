//! The three half bridges: TIM1, centre-aligned at 20 kHz.
//!
//! The gate drivers have no enable input. Their inputs are low, and all transistors open, while the
//! timer's main output enable (MOE) is 0. Software clears MOE; a break clears it without software:
//!
//! * break input 1, which needs no clock: the input "safe torque off"
//! * the chip itself, which needs no clock either: a crystal that fails, a core that has locked up,
//!   a low supply of the chip, and an error of two bits in its flash memory
//! * break input 2, with a filter: the comparators of [`super::over_current`]
//!
//! A pulse is centred on the counter's underflow, at which new compare values take effect. The
//! currents are sampled at the overflow, when all low sides conduct.

use crate::boards::stm32g4::clock::CORE_HZ;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use embassy_stm32::gpio::{Flex, OutputType, Pull, Speed};
use embassy_stm32::pac::timer::vals;
use embassy_stm32::peripherals::{PA8, PA9, PA10, PA12, PA15, PB15, PC13, TIM1};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::Channel;
use embassy_stm32::timer::complementary_pwm::{
    ComplementaryPwm, ComplementaryPwmPin, Mms2, Ossi, Ossr,
};
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, PwmPinConfig};
use embassy_stm32::{Peri, pac};
use static_cell::StaticCell;
use tautrack::motor::bridge::{BridgeStop, PowerStage};

/// PWM periods per second, Hz.
pub const PWM_HZ: u32 = 20_000;
/// Compare value of a half bridge whose high side is always on. The counter counts up to it and
/// down again in a period.
pub const PERIOD: u16 = (CORE_HZ / PWM_HZ / 2) as u16;
/// Longest dead time that the board allows, ns.
const DEAD_TIME_NS: u64 = 600;
/// Time in which an op-amp settles after an edge, ns (FOC-Stim, `config_g431b_esc1.h`).
const SETTLING_NS: u64 = 1_300;
/// Time for which a low side conducts in each period, so that it charges the supply of the driver
/// of its high side, ns.
const CHARGING_NS: u64 = 500;
/// Largest compare value. The low side conducts for twice the distance to the period, less a dead
/// time.
pub const HIGHEST: u16 = PERIOD - clocks(u64::midpoint(CHARGING_NS, DEAD_TIME_NS));
/// Largest compare value at which a current is sampled: the dead time and the settling time pass
/// before the sample, and as much behind it.
pub const SAMPLED: u16 = PERIOD - clocks(DEAD_TIME_NS + SETTLING_NS);

/// Core clocks of a time, rounded up.
const fn clocks(nanoseconds: u64) -> u16 {
    (nanoseconds * CORE_HZ as u64).div_ceil(1_000_000_000) as u16
}

/// The currents are sampled when the counter, counting down, reaches this value: 0.1 us after its
/// overflow. The trigger is low for twice as long before, eight clocks of the converters.
const SAMPLE_AT: u16 = PERIOD - 17;
/// The comparators do not count near the underflow of the counter, where the high sides switch on
/// and off: below this value, so for 2 us of a period.
const BLANKED_BELOW: u16 = (CORE_HZ / 1_000_000) as u16;
/// Alternate function 9 of PA15: `TIM1_BKIN`.
const BREAK_FUNCTION: u8 = 9;
/// Level of the chip's supply below which the bridge opens: 2.9 V (data sheet, PVD6).
const LOW_SUPPLY: u8 = 6;

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

/// Stops the timer while a debug probe halts the core. The timer then switches its outputs off
/// (RM0440, 29.3.31): no handler of the program runs, not even after a fault.
pub fn freeze_when_halted() {
    pac::DBGMCU.apb2fzr().modify(|w| w.set_tim1(true));
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
    // PC13 bears low speed only (data sheet of the chip). Its edges of 25 ns are short enough for
    // all.
    let gate = PwmPinConfig {
        output_type: OutputType::PushPull,
        speed: Speed::Low,
        pull: Pull::Down,
    };
    let pwm = PWM.init(ComplementaryPwm::new(
        pins.timer,
        Some(PwmPin::new_with_config(pins.high.0, gate)),
        Some(ComplementaryPwmPin::new_with_config(pins.low.0, gate)),
        Some(PwmPin::new_with_config(pins.high.1, gate)),
        Some(ComplementaryPwmPin::new_with_config(pins.low.1, gate)),
        Some(PwmPin::new_with_config(pins.high.2, gate)),
        Some(ComplementaryPwmPin::new_with_config(pins.low.2, gate)),
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
    });
    timer.af2().modify(|w| {
        w.set_bk2ine(false);
        for comparator in super::over_current::COMPARATORS {
            w.set_bk2cmpe(comparator - 1, true);
        }
    });
    break_for_the_chip();
    timer.bdtr().modify(|w| {
        w.set_dtg(dead_time(pins.dead_time_ns));
        for input in 0..2 {
            w.set_bkp(input, vals::Bkp::ACTIVE_HIGH);
            w.set_bke(input, true);
        }
        // A filter needs the clock, so the first input has none.
        w.set_bkf(0, vals::FilterValue::NO_FILTER);
        // 8 samples at 21 MHz: 0.4 us, longer than an edge rings.
        w.set_bkf(1, vals::FilterValue::FDTS_DIV8_N8);
    });
    timer.ccmr3().modify(|w| w.set_ocm(0, vals::Ocm::PWM_MODE1));
    timer.ccr5().modify(|w| w.set_ccr(BLANKED_BELOW));
    timer.ccer().modify(|w| w.set_cce(4, true));
    // The library rounds the period; with this value it is exact. The counter is stopped for it,
    // because a repetition counter written before the start makes the updates fall on the underflow
    // (RM0440, 29.3.3).
    timer.cr1().modify(|w| w.set_cen(false));
    timer.cnt().write(|w| w.set_cnt(0));
    timer.arr().write(|w| w.set_arr(PERIOD));
    pwm.set_repetition_counter(1);
    timer.ccr(3).write(|w| w.set_ccr(SAMPLE_AT));
    pwm.set_mms2(Mms2::COMPARE_OC4);
    write(HALF);
    for channel in [Channel::Ch1, Channel::Ch2, Channel::Ch3] {
        pwm.enable(channel);
    }
    timer.egr().write(|w| w.set_ug(true));
    // Dead time, idle levels and break cannot be changed any more until the next reset.
    timer.bdtr().modify(|w| w.set_lock(vals::Lock::LEVEL2));
    timer.cr1().modify(|w| w.set_cen(true));
}

/// Connects the events of the chip with the break of the timer, until the next reset (RM0440,
/// 10.2.8). The event of the crystal is always connected.
fn break_for_the_chip() {
    pac::RCC.apb2enr().modify(|w| w.set_syscfgen(true));
    pac::PWR.cr2().modify(|w| {
        w.set_pls(LOW_SUPPLY);
        w.set_pvde(true);
    });
    pac::SYSCFG.cfgr2().modify(|w| {
        w.set_cll(true);
        w.set_spl(true);
        w.set_pvdl(true);
        w.set_eccl(true);
    });
}

/// Applies a command from the next underflow on. After a break, the bridge stays open until the
/// current loop has commanded [`PowerStage::Off`] for [`RELEASE_PERIODS`]: the drive is disabled.
#[inline]
pub fn apply(stage: PowerStage) {
    let timer = pac::TIM1;
    let compares = match stage {
        PowerStage::Off => {
            timer.bdtr().modify(|w| w.set_moe(false));
            // MOE acts at once, and compare values at the next underflow. So the bridge begins
            // with no voltage when it is driven again.
            write(HALF);
            let periods = OFF_PERIODS.load(Ordering::Relaxed).saturating_add(1);
            OFF_PERIODS.store(periods, Ordering::Relaxed);
            if periods >= RELEASE_PERIODS {
                // A flag stays set while its input is active. Writing 1 leaves a flag as it is.
                timer.sr().write(|w| w.0 = !BREAKS & FLAGS);
            }
            return;
        }
        PowerStage::Brake => [0; 3],
        PowerStage::Drive(compares) => compares,
    };
    OFF_PERIODS.store(0, Ordering::Relaxed);
    if !tripped() {
        timer.bdtr().modify(|w| w.set_moe(true));
        write(compares);
    }
    // A break may have come before MOE was written.
    if tripped() {
        timer.bdtr().modify(|w| w.set_moe(false));
        write(HALF);
    }
}

/// Compare values of a bridge that gives no voltage.
const HALF: [u16; 3] = [PERIOD / 2; 3];

/// Writes compare values, which take effect at the next underflow.
#[inline]
fn write(compares: [u16; 3]) {
    for (channel, compare) in compares.into_iter().enumerate() {
        pac::TIM1.ccr(channel).write(|w| w.set_ccr(compare));
    }
}

/// Whether a break has opened the bridge, and the drive has not been disabled since.
#[inline]
pub fn tripped() -> bool {
    pac::TIM1.sr().read().0 & BREAKS != 0
}

/// What has opened the bridge without software, and the drive has not been disabled since. The
/// first call says whether the last reset followed a failure.
pub fn stop() -> Option<BridgeStop> {
    let flags = pac::TIM1.sr().read().0;
    if CRASHED.swap(false, Ordering::Relaxed) {
        Some(BridgeStop::Crash)
    } else if flags & PROCESSOR != 0 {
        Some(BridgeStop::Processor)
    } else if flags & COMPARATOR != 0 {
        Some(BridgeStop::Comparator)
    } else if flags & SAFE_TORQUE_OFF != 0 {
        Some(BridgeStop::SafeTorqueOff)
    } else {
        None
    }
}

/// The last reset followed a failure of the crystal or the program, and nobody knows it yet.
static CRASHED: AtomicBool = AtomicBool::new(false);

/// Tells that the last reset followed a failure.
pub fn note_crash() {
    CRASHED.store(true, Ordering::Relaxed);
}

/// Forgets an event of the processor that is over.
pub fn forget_event() {
    pac::TIM1.sr().write(|w| w.0 = !PROCESSOR & FLAGS);
}

/// PWM periods for which the current loop must command the bridge to be off before a break is
/// forgotten: 10 ms. An over-current opens the bridge for a few periods.
const RELEASE_PERIODS: u32 = PWM_HZ / 100;
/// PWM periods since the current loop last commanded something else than off.
static OFF_PERIODS: AtomicU32 = AtomicU32::new(0);
/// Flags of the timer (RM0440, 29.6.5), and those of break inputs 1 and 2 and of the chip.
const FLAGS: u32 = 0x00f3_3fff;
const SAFE_TORQUE_OFF: u32 = 1 << 7;
const COMPARATOR: u32 = 1 << 8;
const PROCESSOR: u32 = 1 << 13;
const BREAKS: u32 = SAFE_TORQUE_OFF | COMPARATOR | PROCESSOR;

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

//! TIM4 counts the edges of an incremental encoder, and captures the count at its index; software
//! extends its 16 bits. Or Hall sensors are read instead (`halls`).

use super::halls;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use embassy_stm32::gpio::{AfType, Flex, Pull};
use embassy_stm32::peripherals::{PB6, PB7, PB8, TIM4};
use embassy_stm32::timer::qei::{Config, Qei};
use embassy_stm32::timer::{Ch1, Ch2};
use embassy_stm32::{Peri, pac};
use static_cell::StaticCell;

/// Counts since power-up; wraps.
static COUNT: AtomicU32 = AtomicU32::new(0);
/// Hall sensors are read instead.
static HALLS: AtomicBool = AtomicBool::new(false);
/// Longest pulse that the inputs ignore: 8 samples at 85 MHz, 94 ns.
const FILTER: pac::timer::vals::FilterValue = pac::timer::vals::FilterValue::FDTS_DIV2_N8;

/// Starts the counter.
pub fn start(timer: Peri<'static, TIM4>, a: Peri<'static, PB6>, b: Peri<'static, PB7>) {
    static ENCODER: StaticCell<Qei<'static, TIM4>> = StaticCell::new();
    let config = Config {
        ch1_pull: Pull::Up,
        ch2_pull: Pull::Up,
        ..Config::default()
    };
    ENCODER.init(Qei::new::<Ch1, Ch2>(timer, a, b, config));
    // The library starts the counter without input filters, which can be set only while the
    // channels are disabled.
    let timer = pac::TIM4;
    timer
        .ccer()
        .modify(|w| (0..2).for_each(|n| w.set_cce(n, false)));
    timer
        .ccmr_input(0)
        .modify(|w| (0..2).for_each(|n| w.set_icf(n, FILTER)));
    timer
        .ccer()
        .modify(|w| (0..2).for_each(|n| w.set_cce(n, true)));
}

/// Adds the counts since the last call, and returns the sum. Called in every PWM period, in which
/// an encoder makes fewer than 2^15 counts.
#[inline]
pub fn update() -> u32 {
    if HALLS.load(Ordering::Relaxed) {
        return update_halls();
    }
    let counted = pac::TIM4.cnt().read().cnt();
    let last = COUNT.load(Ordering::Relaxed);
    let moved = counted.wrapping_sub(last as u16) as i16;
    let count = last.wrapping_add_signed(i32::from(moved));
    COUNT.store(count, Ordering::Relaxed);
    count
}

#[cold]
fn update_halls() -> u32 {
    let last = COUNT.load(Ordering::Relaxed);
    let count = halls::update().unwrap_or(last);
    COUNT.store(count, Ordering::Relaxed);
    count
}

/// Reads Hall sensors on the pins of encoder and index, instead of [`start`].
pub fn start_halls(a: Peri<'static, PB6>, b: Peri<'static, PB7>, c: Peri<'static, PB8>) {
    halls::start(a, b, c);
    HALLS.store(true, Ordering::Relaxed);
}

/// Counts since power-up, as of the last PWM period; wraps at both ends of `i32`.
pub fn count() -> i32 {
    COUNT.load(Ordering::Relaxed).cast_signed()
}

/// Channel that captures the count at the index, and the alternate function of its pin.
const INDEX_CHANNEL: usize = 2;
const INDEX_FUNCTION: u8 = 2;

/// Captures the count at each rising edge of the index, after [`start`].
pub fn start_index(pin: Peri<'static, PB8>) {
    static PIN: StaticCell<Flex<'static>> = StaticCell::new();
    let pin = PIN.init(Flex::new(pin));
    pin.set_as_af_unchecked(INDEX_FUNCTION, AfType::input(Pull::Up));
    let timer = pac::TIM4;
    timer.ccmr_input(INDEX_CHANNEL / 2).modify(|w| {
        w.set_ccs(INDEX_CHANNEL % 2, pac::timer::vals::CcmrInputCcs::TI4);
        w.set_icf(INDEX_CHANNEL % 2, FILTER);
    });
    timer.ccer().modify(|w| w.set_cce(INDEX_CHANNEL, true));
}

/// Count at the newest edge of the index since the last call. It must be called before 2^15 counts
/// have passed.
pub fn index() -> Option<u32> {
    if HALLS.load(Ordering::Relaxed) || !pac::TIM4.sr().read().ccif(INDEX_CHANNEL) {
        return None;
    }
    // Reading the count clears the flag.
    let captured = pac::TIM4.ccr(INDEX_CHANNEL).read().ccr();
    let last = COUNT.load(Ordering::Relaxed);
    let moved = captured.wrapping_sub(last as u16) as i16;
    Some(last.wrapping_add_signed(i32::from(moved)))
}

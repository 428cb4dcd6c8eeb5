//! Watchdog, cause of the last reset, and what happens after a panic or a fault of the core: the
//! board switches off what moves, and the watchdog resets the chip.

use super::stack_guard;
use crate::boards::Selected;
use crate::watchdog::PERIOD_US;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};
use tautrack::fault_log::{FaultLog, Reset, WORDS};

/// Rate at which the watchdog counts, Hz: its oscillator of 32 kHz, divided by 4. The oscillator is
/// accurate to 6 % (data sheet of the chip).
const WATCHDOG_HZ: u64 = 8_000;

/// [`CRASHED`] if the crystal or the program has failed since power-up. A reset does not clear it.
#[unsafe(link_section = ".uninit.crash")]
static CRASH: AtomicU32 = AtomicU32::new(0);
/// A value that RAM does not have by chance.
const CRASHED: u32 = 0x9c3a_51e7;

/// The faults as words of a log. A reset does not clear them.
#[unsafe(link_section = ".uninit.faults")]
static FAULTS: [AtomicU32; WORDS] = [const { AtomicU32::new(0) }; WORDS];
/// Cause of the last reset.
static CAUSE: AtomicU8 = AtomicU8::new(Reset::Unknown as u8);

/// Returns the faults that were kept over the last reset.
pub fn kept_faults() -> FaultLog {
    let words = FAULTS.each_ref().map(|word| word.load(Ordering::Relaxed));
    FaultLog::new(&words, CAUSE.load(Ordering::Relaxed))
}

/// Keeps the faults over the next reset.
pub fn keep_faults(log: &FaultLog) {
    for (place, word) in FAULTS.iter().zip(log.to_words()) {
        place.store(word, Ordering::Relaxed);
    }
}

/// Starts the watchdog. It cannot be stopped again.
pub fn start_watchdog() {
    let watchdog = pac::IWDG;
    watchdog.kr().write(|w| w.set_key(Key::START));
    watchdog.kr().write(|w| w.set_key(Key::ENABLE));
    watchdog.pr().write(|w| w.set_pr(Pr::DIVIDE_BY4));
    watchdog
        .rlr()
        .write(|w| w.set_rl((PERIOD_US * WATCHDOG_HZ / 1_000_000 - 1) as u16));
    while watchdog.sr().read().0 != 0 {}
    feed_watchdog();
}

/// Restarts the watchdog's period.
pub fn feed_watchdog() {
    pac::IWDG.kr().write(|w| w.set_key(Key::RESET));
}

/// Writes the cause of the last reset to the log.
pub fn report_cause() {
    let cause = pac::RCC.csr().read();
    let (mut reset, text) = if cause.iwdgrstf() || cause.wwdgrstf() {
        (Reset::Watchdog, "watchdog")
    } else if cause.sftrstf() {
        (Reset::Software, "software")
    } else if cause.borrstf() {
        (Reset::Power, "power-up or brown-out")
    } else if cause.oblrstf() || cause.lpwrrstf() {
        (Reset::Other, "option bytes or low power")
    } else {
        (Reset::Pin, "reset pin")
    };
    defmt::info!("reset by {=str}", text);
    if CRASH.swap(0, Ordering::Relaxed) == CRASHED {
        reset = Reset::Crash;
        defmt::warn!("the crystal or the program had failed");
    }
    if matches!(reset, Reset::Watchdog | Reset::Crash) {
        Selected::note_crash();
    }
    CAUSE.store(reset as u8, Ordering::Relaxed);
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
}

/// Handles a panic of the guard's board: names the line. In a program of the motor board, a panic
/// is the instruction UDF itself, and nothing calls this.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    stop();
    CRASH.store(CRASHED, Ordering::Relaxed);
    if let Some(place) = info.location() {
        defmt::error!("panic in {=str}, line {=u32}", place.file(), place.line());
    }
    wait_for_watchdog()
}

/// Handles faults of the core, a stack that overflows, and panics of the motor board. It names the
/// address, which the ELF file translates into a line.
#[unsafe(no_mangle)]
unsafe extern "C" fn hard_fault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
    /// Bit of the register CFSR: the instruction is not defined, as UDF.
    const UNDEFINED_INSTRUCTION: u32 = 1 << 16;
    stop();
    CRASH.store(CRASHED, Ordering::Relaxed);
    // SAFETY: reads a register of the core, which has no other user.
    let cause = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    if stack_guard::has_overflowed(&raw const *frame as usize) {
        defmt::error!("the stack has overflowed");
    } else if cause & UNDEFINED_INSTRUCTION == 0 {
        defmt::error!("hard fault at {=u32:#x}", frame.pc());
    } else {
        defmt::error!("panic at {=u32:#x}", frame.pc());
    }
    wait_for_watchdog()
}

/// Handles a crystal that has failed: the core runs on its own oscillator, with which the bus
/// cannot work, so the board stops and is reset. Or an error in the flash memory: in the program,
/// the same.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() {
    if pac::RCC.cifr().read().cssf() {
        stop();
        pac::RCC.cicr().write(|w| w.set_cssc(true));
        CRASH.store(CRASHED, Ordering::Relaxed);
        defmt::error!("the crystal has failed");
        wait_for_watchdog();
    }
    if super::storage::has_error() && !super::storage::clear_error() {
        stop();
        CRASH.store(CRASHED, Ordering::Relaxed);
        defmt::error!("the flash memory has an error");
        wait_for_watchdog();
    }
}

/// Switches off what moves, and stops the interrupts from switching it on again.
fn stop() {
    cortex_m::interrupt::disable();
    Selected::make_safe();
}

/// Switches off what moves, and resets the chip.
pub fn restart() {
    stop();
    cortex_m::peripheral::SCB::sys_reset()
}

fn wait_for_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

//! Links the control ticks and nothing else, so that a test can inspect the symbols of the program.
//! A function that is not in this program cannot be called by a tick. The program is never started.
//!
//! The constructors are not linked, because they may compute in double precision and may fail with
//! a text. The states are therefore uninitialised memory, which a caller would have to fill before
//! starting the program.
#![no_std]
#![no_main]

// Includes the source file, because the library would add a panic handler and a fault handler that
// write text.
#[path = "../current_loop.rs"]
mod current_loop;

use core::cell::UnsafeCell;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
// Linked for its implementation of the critical section.
use cortex_m as _;
use tautrack::motor::bridge::Readings;
use tautrack::motor::capture::Request;
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{Config, CurrentLoop, Excitation};
use tautrack::node::axle::{self, Axle, BridgeDemand};
use tautrack::node::calibration::{self, Calibrator};
use tautrack::node::guard::{self, Guard};
use tautrack::node::screw::{self, Screw};

struct Slot<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: the program has one thread, and no interrupt accesses a slot.
unsafe impl<T> Sync for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// Returns the value in the slot; the compiler cannot see through the access.
    ///
    /// # Safety
    /// The caller has written a value into the slot, and no other reference to it exists.
    #[allow(clippy::mut_from_ref)] // the caller guarantees uniqueness
    unsafe fn get(&self) -> &mut T {
        // SAFETY: the pointer is that of a static; the caller guarantees the value and uniqueness.
        unsafe { (*black_box(self.0.get())).assume_init_mut() }
    }
}

static AXLE: Slot<(Axle, axle::Inputs)> = Slot::new();
static SCREW: Slot<(Screw, screw::Inputs)> = Slot::new();
static RECEIVED: Slot<guard::Inputs<'static>> = Slot::new();
static CURRENT: Slot<Readings> = Slot::new();
static CHANGES: Slot<(CurrentLoop, Wave, Request, Config)> = Slot::new();
static CALIBRATION: Slot<(Calibrator, calibration::Inputs)> = Slot::new();

macro_rules! guards {
    ($($folder:ident::$body:ident: $about:literal,)*) => {
        /// Ticks the guard of every robot.
        fn tick_guards(received: &guard::Inputs<'_>) {
            $({
                static GUARD: Slot<Guard<tautrack::robots::$folder::$body>> = Slot::new();
                // SAFETY: whoever starts the program writes the value; the slot has one reference.
                black_box(unsafe { GUARD.get() }.tick(received));
            })*
        }
    };
}

tautrack::every_robot!(guards);

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: whoever starts the program writes the values; each slot has one reference.
    let (axle, screw, received, current, changes, calibrator) = unsafe {
        (
            AXLE.get(),
            SCREW.get(),
            RECEIVED.get(),
            CURRENT.get(),
            CHANGES.get(),
            CALIBRATION.get(),
        )
    };
    let (current_loop, wave, request, config) = changes;
    current_loop::install(current_loop.clone());
    loop {
        black_box(axle.0.tick(&axle.1));
        black_box(screw.0.tick(&screw.1));
        tick_guards(received);
        black_box(current_loop::pwm_period(current));
        black_box(current_loop::take_means(|| None));
        black_box(current_loop::over_current());
        current_loop::set_limits(config);
        current_loop::set_cogging(black_box(1), *wave);
        current_loop::request_capture(*request);
        current_loop::demand(black_box(BridgeDemand::Off), black_box(0.0), black_box(0.0));
        black_box(
            calibrator
                .0
                .tick(black_box(1), black_box(true), black_box(0.0), &calibrator.1),
        );
        current_loop::excite(&black_box(Excitation::default()), black_box(0.0));
        black_box(current_loop::take_measurement(black_box(0.0)));
    }
}

/// Panic handler, which is linked only if something can panic. The test searches for the name of
/// the function that it calls.
#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    a_tick_can_panic()
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn a_tick_can_panic() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

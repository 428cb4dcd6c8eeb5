//! Nothing but the control ticks, linked to be looked at and never started: what its symbols do not hold, no tick can reach.
//!
//! Constructors may compute in double precision and refuse with text, so none is linked: the states are memory that whoever
//! starts the program would have to fill.
#![no_std]
#![no_main]

// The file itself, because the library brings a panic handler and a fault handler that write text.
#[path = "../current_loop.rs"]
mod current_loop;

use core::cell::UnsafeCell;
use core::hint::black_box;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
// The critical section.
use cortex_m as _;
use tautrack::node::axle::{self, Axle, BridgeDemand};
use tautrack::node::guard::{self, Guard};
use tautrack::node::screw::{self, Screw};
use tautrack::robots::b2p2::B2p2;
use tautrack::robots::crawler::Crawler;
use tautrack::robots::hylos::Hylos;
use tautrack::robots::rt_mover::RtMover;

struct Slot<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: one thread, and no interrupt touches a slot.
unsafe impl<T> Sync for Slot<T> {}

impl<T> Slot<T> {
    const fn new() -> Self {
        Self(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// What is in the slot; opaque to the compiler.
    ///
    /// # Safety
    /// Whoever started the program has put a value there, and no other reference to it exists.
    #[allow(clippy::mut_from_ref)] // the caller's promise
    unsafe fn get(&self) -> &mut T {
        // SAFETY: the pointer is that of a static, its value and uniqueness are the caller's promise.
        unsafe { (*black_box(self.0.get())).assume_init_mut() }
    }
}

static AXLE: Slot<(Axle, axle::Inputs)> = Slot::new();
static SCREW: Slot<(Screw, screw::Inputs)> = Slot::new();
static HEARD: Slot<guard::Inputs<'static>> = Slot::new();
static CURRENT: Slot<(f32, f32)> = Slot::new();

macro_rules! guards {
    ($($name:ident: $body:ty,)*) => {
        $(static $name: Slot<Guard<$body>> = Slot::new();)*

        /// Ticks the guard of every robot.
        fn tick_guards(received: &guard::Inputs<'_>) {
            // SAFETY: the values are the starter's business; each slot is referred to once.
            $(black_box(unsafe { $name.get() }.tick(received));)*
        }
    };
}

guards! {
    B2P2: B2p2,
    CRAWLER: Crawler,
    RT_MOVER: RtMover,
    HYLOS: Hylos,
}

#[cortex_m_rt::entry]
fn main() -> ! {
    // SAFETY: the values are the starter's business; each slot is referred to once.
    let (axle, screw, received, current) =
        unsafe { (AXLE.get(), SCREW.get(), HEARD.get(), CURRENT.get()) };
    loop {
        black_box(axle.0.tick(&axle.1));
        black_box(screw.0.tick(&screw.1));
        tick_guards(received);
        black_box(current_loop::pwm_period(current.0, current.1));
        black_box(current_loop::take_mean());
        current_loop::demand(black_box(BridgeDemand::Off));
    }
}

/// Linked only if something can panic; its name is what the test looks for.
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

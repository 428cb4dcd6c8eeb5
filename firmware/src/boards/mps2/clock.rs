//! Virtual time for `embassy-time`, and the executor, which polls tasks until none is ready.

use core::cell::RefCell;
use core::sync::atomic::{AtomicBool, Ordering};
use core::task::Waker;
use critical_section::Mutex;
use embassy_executor::raw::Executor;
use embassy_time_driver::Driver;
use embassy_time_queue_utils::Queue;
use static_cell::StaticCell;

struct VirtualClock(Mutex<RefCell<State>>);

struct State {
    now_us: u64,
    timers: Queue,
}

impl Driver for VirtualClock {
    fn now(&self) -> u64 {
        critical_section::with(|cs| self.0.borrow(cs).borrow().now_us)
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            let mut state = self.0.borrow(cs).borrow_mut();
            if at <= state.now_us {
                waker.wake_by_ref();
            } else {
                state.timers.schedule_wake(at, waker);
            }
        });
    }
}

embassy_time_driver::time_driver_impl!(static CLOCK: VirtualClock = VirtualClock(Mutex::new(RefCell::new(State {
    now_us: 0,
    timers: Queue::new(),
}))));

/// Time since power-up, us.
pub fn now() -> u64 {
    CLOCK.now()
}

/// Sets the clock; the next [`fire_timers`] fires the timers that expired. Ignores a time before
/// the current one.
pub fn set_now(now_us: u64) {
    critical_section::with(|cs| {
        let mut state = CLOCK.0.borrow(cs).borrow_mut();
        if now_us > state.now_us {
            state.now_us = now_us;
        }
    });
}

/// Wakes every task whose timer has expired.
pub fn fire_timers() {
    critical_section::with(|cs| {
        let mut state = CLOCK.0.borrow(cs).borrow_mut();
        let now = state.now_us;
        state.timers.next_expiration(now);
    });
}

static PENDING: AtomicBool = AtomicBool::new(false);

// SAFETY: the executor declares exactly this function, and no other crate in the program defines
// it.
#[unsafe(export_name = "__pender")]
fn pend(_context: *mut ()) {
    PENDING.store(true, Ordering::SeqCst);
}

/// Creates the executor. Must be called only once.
pub fn executor() -> &'static Executor {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    EXECUTOR.init(Executor::new(core::ptr::null_mut()))
}

/// Polls until no task is ready.
pub fn run_until_idle(executor: &'static Executor) {
    while PENDING.swap(false, Ordering::SeqCst) {
        // SAFETY: the board's only thread calls this, never from within a task, so it is not
        // re-entered.
        unsafe { executor.poll() };
    }
}

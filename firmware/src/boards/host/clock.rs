//! Time of the node that runs, for the drivers of the sensor chips. Nodes run one after the other
//! in a thread.

use core::cell::Cell;
use core::task::Waker;
use embassy_time_driver::Driver;
use std::thread_local;

/// Clock of a node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Clock {
    /// Time since power-up, us.
    pub now_us: u64,
    /// When a driver waits no longer, us since power-up.
    pub wake_us: u64,
}

impl Default for Clock {
    /// Nobody waits.
    fn default() -> Self {
        Self {
            now_us: 0,
            wake_us: u64::MAX,
        }
    }
}

thread_local! {
    static CLOCK: Cell<Clock> = const {
        Cell::new(Clock {
            now_us: 0,
            wake_us: u64::MAX,
        })
    };
}

/// Makes `clock` the one of this thread. Returns the one before.
pub(super) fn exchange(clock: Clock) -> Clock {
    CLOCK.replace(clock)
}

/// Whether the time has come that a driver waits for. From then on nobody waits.
pub(super) fn expired() -> bool {
    let clock = CLOCK.get();
    let expired = clock.wake_us <= clock.now_us;
    if expired {
        CLOCK.set(Clock {
            wake_us: u64::MAX,
            ..clock
        });
    }
    expired
}

struct VirtualClock;

impl Driver for VirtualClock {
    fn now(&self) -> u64 {
        CLOCK.get().now_us
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        let clock = CLOCK.get();
        if at <= clock.now_us {
            waker.wake_by_ref();
        } else {
            CLOCK.set(Clock {
                wake_us: clock.wake_us.min(at),
                ..clock
            });
        }
    }
}

embassy_time_driver::time_driver_impl!(static DRIVER: VirtualClock = VirtualClock);

//! Watchdog of the emulated board, in virtual time.

use super::clock;
use crate::watchdog::PERIOD_US;
use core::cell::Cell;
use core::fmt;
use critical_section::Mutex;

static FED_US: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Error: the watchdog was not fed in time.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Starved {
    /// Time of the last feed, us since power-up.
    pub fed_us: u64,
    /// Time of the check that found it, us since power-up.
    pub now_us: u64,
}

impl fmt::Display for Starved {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "watchdog: not fed from {} us to {} us, reset after {PERIOD_US} us; a part of the node has stopped",
            self.fed_us, self.now_us
        )
    }
}

/// Feeds the watchdog at the current time.
pub fn feed_watchdog() {
    let now_us = clock::now();
    critical_section::with(|cs| FED_US.borrow(cs).set(now_us));
}

/// Returns [`Starved`] if the last feed was more than [`PERIOD_US`] before `now_us`.
pub fn check(now_us: u64) -> Option<Starved> {
    let fed_us = critical_section::with(|cs| FED_US.borrow(cs).get());
    (now_us.saturating_sub(fed_us) > PERIOD_US).then_some(Starved { fed_us, now_us })
}

//! Checks that the parts of a node still run. It feeds the watchdog that otherwise resets the node.
//!
//! The monitored parts ("parties") are the PWM interrupt, the control tick and the thread.
//! [`Board::feed_watchdog`] is called only when every party of the role has run since the previous
//! call. The control tick reports for the PWM interrupt, because it notices whether new current
//! samples have come.

#[cfg(target_os = "none")]
use crate::boards::{Board, Selected};
use core::sync::atomic::{AtomicU8, Ordering};

/// Part of the firmware that must run regularly.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Party {
    /// PWM interrupt; a guard node has none.
    Pwm = 1,
    /// The control tick.
    Control = 2,
    /// The tasks of the thread, which carry frames.
    Thread = 4,
}

/// Time without being fed after which a board's watchdog resets the node, us. Every party runs at
/// least every 5 ms.
pub const PERIOD_US: u64 = 50_000;
/// Bit sets of [`Party`]: those that must run, and those that have run since the last feed.
struct Parties {
    required: AtomicU8,
    ran: AtomicU8,
}

impl Parties {
    const fn new() -> Self {
        Self {
            required: AtomicU8::new(0),
            ran: AtomicU8::new(0),
        }
    }

    fn require(&self, party: Party) {
        self.required.fetch_or(party as u8, Ordering::Relaxed);
    }

    /// Records that `party` has run. Returns whether all required parties have now run.
    fn ran(&self, party: Party) -> bool {
        let ran = self.ran.fetch_or(party as u8, Ordering::Relaxed) | party as u8;
        let required = self.required.load(Ordering::Relaxed);
        let all = ran & required == required;
        if all {
            self.ran.store(0, Ordering::Relaxed);
        }
        all
    }
}

#[cfg(target_os = "none")]
static PARTIES: Parties = Parties::new();

/// Makes `party` a condition for feeding the watchdog. Called at start.
#[cfg(target_os = "none")]
pub fn require(party: Party) {
    PARTIES.require(party);
}

/// Records that `party` has run; feeds the watchdog if it was the last one missing.
#[cfg(target_os = "none")]
pub fn ran(party: Party) {
    if PARTIES.ran(party) {
        Selected::feed_watchdog();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_fed_only_when_every_party_has_run() {
        use Party::{Control, Pwm, Thread};
        let drive = Parties::new();
        for party in [Pwm, Control, Thread] {
            drive.require(party);
        }
        for missing in [Pwm, Control, Thread] {
            let others = [Pwm, Control, Thread].map(|party| party != missing && drive.ran(party));
            assert_eq!(others, [false; 3], "fed without {missing:?}");
            for _ in 0..1_000 {
                for party in [Pwm, Control, Thread] {
                    assert!(
                        party == missing || !drive.ran(party),
                        "fed without {missing:?}"
                    );
                }
            }
            assert!(drive.ran(missing));
        }
    }

    #[test]
    fn a_guard_needs_no_pwm_interrupt() {
        let guard = Parties::new();
        guard.require(Party::Control);
        guard.require(Party::Thread);
        assert!(!guard.ran(Party::Control));
        assert!(guard.ran(Party::Thread));
        assert!(!guard.ran(Party::Thread));
    }
}

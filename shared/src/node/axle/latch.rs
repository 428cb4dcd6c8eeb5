//! Latches faults, and reports them in emergency frames.

use crate::faults::{Fault, Faults};

/// Faults that were raised and that no reset has cleared.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Latch {
    latched: Faults,
    /// Faults that were raised, but not sent in an emergency frame yet.
    unreported: Faults,
    /// An emergency frame has reported a fault since the last "all clear".
    reported: bool,
}

impl Latch {
    /// Adds the faults that are present now.
    #[inline]
    pub fn raise(&mut self, present: Faults) {
        self.unreported = self.unreported.or(present.without(self.latched));
        self.latched = self.latched.or(present);
    }

    /// Clears every fault that is no longer present.
    pub fn reset(&mut self, present: Faults) {
        self.latched = self.latched.and(present);
    }

    /// Returns the latched faults.
    #[inline]
    pub fn faults(&self) -> Faults {
        self.latched
    }

    /// Returns the error code of the strongest latched fault; 0 if there is none.
    #[inline]
    pub fn code(&self) -> u16 {
        let fault = self.latched.strongest();
        fault.map_or(0, Fault::code)
    }

    /// Returns the code of the emergency frame that is due in this tick. Each raised fault is due
    /// once, the strongest first; 0 ("all clear") is due when no fault is latched any more.
    #[inline]
    pub fn emergency(&mut self) -> Option<u16> {
        if let Some(fault) = self.unreported.strongest() {
            self.unreported = self.unreported.without(Faults::of(fault));
            self.reported = true;
            return Some(fault.code());
        }
        let clear = self.reported && self.latched.is_empty();
        if clear {
            self.reported = false;
        }
        clear.then_some(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::Fault::{Blocked, CommandLost, GuardLost, OverCurrent};

    fn set<const N: usize>(faults: [crate::faults::Fault; N]) -> Faults {
        faults
            .into_iter()
            .fold(Faults::NONE, |set, fault| set.or(Faults::of(fault)))
    }

    #[test]
    fn every_fault_is_reported_once_and_the_end_of_the_last_one() {
        let mut latch = Latch::default();
        assert_eq!(latch.emergency(), None);
        latch.raise(set([CommandLost, OverCurrent]));
        latch.raise(set([CommandLost, Blocked]));
        // Faults that are cleared before they were reported are still reported.
        latch.reset(Faults::NONE);
        let sent: [_; 5] = core::array::from_fn(|_| latch.emergency());
        assert_eq!(
            sent,
            [Some(0x2310), Some(0x7121), Some(0x8250), Some(0), None]
        );
    }

    #[test]
    fn a_reset_leaves_what_is_present_still() {
        let mut latch = Latch::default();
        latch.raise(set([GuardLost, CommandLost]));
        latch.reset(set([GuardLost]));
        assert_eq!(latch.faults(), set([GuardLost]));
        assert_eq!(latch.code(), 0x8130);
    }
}

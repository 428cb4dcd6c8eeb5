//! Errors of the node's CAN controller, and their emergency codes (CiA 301).

/// A frame was lost, because the controller or its queue was full.
const OVERRUN: u16 = 0x8110;
/// The controller has got error passive: much that it sends or receives is disturbed.
const PASSIVE: u16 = 0x8120;
/// The controller has recovered from bus-off.
const RECOVERED: u16 = 0x8140;
/// Ticks without an overrun, or a PDO that is too short, after which the next one is reported, and
/// ticks between two reports of error passive.
pub(super) const QUIET: u16 = 1_000;

/// Condition of the controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Condition {
    /// A received frame was lost since the last tick.
    pub overrun: bool,
    /// The controller is error passive.
    pub passive: bool,
    /// The controller takes no part in the bus.
    pub off: bool,
}

/// What was reported of a controller.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Controller {
    off: bool,
    /// The controller is error passive, and that was reported.
    passive: bool,
    /// Ticks until an overrun is reported again, and until error passive is.
    overrun_quiet: u16,
    passive_quiet: u16,
}

impl Controller {
    /// Returns the code of what is new in this tick.
    pub fn tick(&mut self, now: Condition) -> Option<u16> {
        let overruns = now.overrun && self.overrun_quiet == 0;
        self.overrun_quiet = if now.overrun {
            QUIET
        } else {
            self.overrun_quiet.saturating_sub(1)
        };
        self.passive_quiet = self.passive_quiet.saturating_sub(1);
        self.passive &= now.passive;
        let was_off = core::mem::replace(&mut self.off, now.off);
        if was_off && !now.off {
            return Some(RECOVERED);
        }
        if now.passive && !now.off && !self.passive && self.passive_quiet == 0 {
            self.passive = true;
            self.passive_quiet = QUIET;
            return Some(PASSIVE);
        }
        overruns.then_some(OVERRUN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(conditions: impl Iterator<Item = Condition>) -> heapless::Vec<u16, 8> {
        let mut controller = Controller::default();
        conditions.filter_map(|now| controller.tick(now)).collect()
    }

    fn reported(conditions: &[(Condition, usize)]) -> heapless::Vec<u16, 8> {
        let conditions = conditions.iter();
        codes(conditions.flat_map(|(it, ticks)| core::iter::repeat_n(*it, *ticks)))
    }

    const GOOD: Condition = Condition {
        overrun: false,
        passive: false,
        off: false,
    };
    const PASSIVE_NOW: Condition = Condition {
        passive: true,
        ..GOOD
    };
    const OFF: Condition = Condition {
        passive: true,
        off: true,
        ..GOOD
    };
    const OVERRUN_NOW: Condition = Condition {
        overrun: true,
        ..GOOD
    };

    #[test]
    fn each_condition_is_reported_when_it_begins_and_bus_off_when_it_ends() {
        assert!(reported(&[(GOOD, 100)]).is_empty());
        assert_eq!(
            reported(&[(PASSIVE_NOW, 50), (GOOD, 950), (PASSIVE_NOW, 9)]),
            [0x8120; 2]
        );
        let short = [(PASSIVE_NOW, 2), (OFF, 90), (PASSIVE_NOW, 3), (GOOD, 9)];
        assert_eq!(reported(&short), [0x8120, 0x8140]);
        assert_eq!(reported(&[(OFF, 9), (GOOD, 9)]), [0x8140]);
    }

    #[test]
    fn error_passive_is_reported_once_a_second_and_not_forgotten() {
        let flickers = [PASSIVE_NOW, GOOD].into_iter().cycle();
        assert_eq!(codes(flickers.clone().take(1_000)), [0x8120]);
        assert_eq!(codes(flickers.take(3_000)), [0x8120; 3]);
        // It begins in the quiet second, and goes on.
        let begun = [(PASSIVE_NOW, 1), (GOOD, 1), (PASSIVE_NOW, 998)];
        assert_eq!(reported(&begun), [0x8120]);
        let lasting = [(PASSIVE_NOW, 1), (GOOD, 1), (PASSIVE_NOW, 9_000)];
        assert_eq!(reported(&lasting), [0x8120; 2]);
    }

    #[test]
    fn a_flood_is_reported_once() {
        let flood = [
            (OVERRUN_NOW, 1),
            (GOOD, 2),
            (OVERRUN_NOW, 1),
            (GOOD, 900),
            (OVERRUN_NOW, 1),
        ];
        assert_eq!(reported(&flood), [0x8110]);
        assert_eq!(
            reported(&[(OVERRUN_NOW, 5), (GOOD, 1_001), (OVERRUN_NOW, 5)]),
            [0x8110; 2]
        );
    }
}

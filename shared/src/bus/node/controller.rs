//! Errors of the node's CAN controller, and their emergency codes (CiA 301).

/// A frame was lost, because the controller or its queue was full.
const OVERRUN: u16 = 0x8110;
/// The controller has got error passive: much that it sends or receives is disturbed.
const PASSIVE: u16 = 0x8120;
/// The controller has recovered from bus-off.
const RECOVERED: u16 = 0x8140;
/// Ticks without an overrun, or a PDO that is too short, after which the next one is reported.
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
    before: Condition,
    /// Ticks until an overrun is reported again.
    quiet: u16,
}

impl Controller {
    /// Returns the code of what is new in this tick.
    pub fn tick(&mut self, now: Condition) -> Option<u16> {
        let before = core::mem::replace(&mut self.before, now);
        let overruns = now.overrun && self.quiet == 0;
        self.quiet = if now.overrun {
            QUIET
        } else {
            self.quiet.saturating_sub(1)
        };
        match (before, now) {
            _ if before.off && !now.off => Some(RECOVERED),
            _ if now.passive && !before.passive && !now.off => Some(PASSIVE),
            _ if overruns => Some(OVERRUN),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reported(conditions: &[(Condition, usize)]) -> heapless::Vec<u16, 8> {
        let mut controller = Controller::default();
        let ticks = conditions
            .iter()
            .flat_map(|(it, ticks)| core::iter::repeat_n(*it, *ticks));
        ticks.filter_map(|now| controller.tick(now)).collect()
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
            reported(&[(PASSIVE_NOW, 50), (GOOD, 9), (PASSIVE_NOW, 9)]),
            [0x8120; 2]
        );
        let short = [(PASSIVE_NOW, 2), (OFF, 90), (PASSIVE_NOW, 3), (GOOD, 9)];
        assert_eq!(reported(&short), [0x8120, 0x8140]);
        assert_eq!(reported(&[(OFF, 9), (GOOD, 9)]), [0x8140]);
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

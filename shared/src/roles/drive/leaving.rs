//! How a drive leaves operation before it restarts: it comes to rest, and then lets go.

use crate::bus::cia402::{CONTROL_HALT, controlword};

/// Ticks in a row for which the shaft must stand.
const STANDS: u16 = 20;
/// Ticks after which a shaft that does not come to rest is waited for no longer.
const MOST: u16 = 2_000;
/// Ticks from then on after which a drive that still has current restarts anyway.
const LETTING_GO: u16 = 500;

/// A drive that is to restart.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Leaving {
    ticks: u16,
    /// Ticks in a row for which the shaft stands.
    stands: u16,
    /// Ticks since the drive is to let go.
    letting_go: u16,
}

/// What a drive that is to restart does next.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Next {
    /// It follows this controlword.
    Command(u16),
    /// It waits until its shaft, which coasts, stands.
    Wait,
    /// It restarts.
    Restart,
}

impl Leaving {
    /// Returns what comes next for a drive whose shaft `stands` or not, and that has current or
    /// not. One that operates halts, whatever its option codes are. Another one goes on holding.
    pub fn next(&mut self, stands: bool, current: bool, operates: bool) -> Next {
        self.ticks = self.ticks.saturating_add(1);
        self.stands = if stands {
            self.stands.saturating_add(1)
        } else {
            0
        };
        let rests = self.stands >= STANDS || self.ticks >= MOST;
        match (current, rests || self.letting_go > 0) {
            (false, true) => Next::Restart,
            (false, false) => Next::Wait,
            (true, false) if operates => {
                Next::Command(controlword::ENABLE_OPERATION | CONTROL_HALT)
            }
            (true, false) => Next::Command(controlword::QUICK_STOP),
            (true, true) => {
                self.letting_go += 1;
                if self.letting_go < LETTING_GO {
                    Next::Command(controlword::DISABLE_VOLTAGE)
                } else {
                    Next::Restart
                }
            }
        }
    }
}

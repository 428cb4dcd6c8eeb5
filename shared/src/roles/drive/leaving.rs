//! How a drive leaves operation before it restarts: it ramps to standstill, and then lets go.

use crate::bus::cia402::controlword;

/// Ticks of the quick stop: at least, and at most if the shaft does not come to rest.
const LEAST: u16 = 50;
const MOST: u16 = 2_000;
/// Ticks from then on after which a drive that still has current restarts anyway.
const LETTING_GO: u16 = 500;
/// Speed below which the shaft rests, rad/s.
const REST: f32 = 0.05;

/// A drive that is to restart.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Leaving {
    ticks: u16,
    /// Ticks since the drive stood.
    stood: u16,
}

impl Leaving {
    /// Returns the controlword of the next tick for a drive that has current, with this velocity,
    /// rad/s; `None` if it waits no longer.
    pub fn next(&mut self, velocity: f32) -> Option<u16> {
        self.ticks = self.ticks.saturating_add(1);
        let rests = self.ticks > LEAST && velocity.abs() < REST;
        if self.stood == 0 && !rests && self.ticks < MOST {
            return Some(controlword::QUICK_STOP);
        }
        self.stood += 1;
        (self.stood < LETTING_GO).then_some(controlword::DISABLE_VOLTAGE)
    }
}

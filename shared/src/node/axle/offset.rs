//! Torque feed-forward of the guard (object 0x60B2), as a current that is added to the current of
//! the loops.

use crate::bus::network::OFFSET_SYNCS;
use crate::constants::CONTROL_PERIOD;
use crate::motor::cascade::Cascade;
use crate::settings::{Setting, Settings};

/// A torque feed-forward and its age. It acts in operation only, and ends when the mode or the
/// state changes.
#[derive(Clone, Debug)]
pub(super) struct Offset {
    /// A per unit of 0x60B2.
    amperes: f32,
    /// Current, in units of the cascade, up to 2^26.
    current: i32,
    /// Lifetime of a new feed-forward, and what is left of the present one, in ticks.
    life: i32,
    left: i32,
}

impl Offset {
    /// Creates an empty feed-forward. `amperes` is the current, A, of one unit of 0x60B2.
    ///
    /// A feed-forward ends when it is older than the command timeout. It lasts for at least two
    /// periods of the guard's feed-forward frames, even if these are longer.
    pub fn new(settings: &Settings, amperes: f32) -> Self {
        let tick_us = (CONTROL_PERIOD * 1e6) as u64;
        let apart = settings.get(Setting::SyncPeriod) as u64 * u64::from(OFFSET_SYNCS);
        let timeout = settings.milliseconds(Setting::CommandTimeout);
        let life = if timeout > 2 * apart {
            timeout
        } else {
            2 * apart
        };
        Self {
            amperes,
            current: 0,
            life: (life / tick_us) as i32,
            left: 0,
        }
    }

    /// Advances by one control period, and takes the newest feed-forward if one came.
    #[inline]
    pub fn update(&mut self, newest: Option<i16>, cascade: &Cascade) {
        // The counter may wrap below zero. The current is 0 by then and stays 0.
        self.left = self.left.wrapping_sub(1);
        if self.left < 0 {
            self.current = 0;
        }
        if let Some(torque) = newest {
            self.current = cascade.current(f32::from(torque) * self.amperes);
            self.left = self.life;
        }
    }

    /// Converts the current from the units of one cascade to those of another.
    pub fn convert(&mut self, from: &Cascade, to: &Cascade) {
        self.current = to.current(from.amperes(self.current));
    }

    /// Ends the feed-forward.
    #[inline]
    pub fn clear(&mut self) {
        self.current = 0;
    }

    /// Returns the current, A, of one unit of torque on the bus.
    #[inline]
    pub fn amperes(&self) -> f32 {
        self.amperes
    }

    /// Returns the current to add, in units of the cascade.
    #[inline]
    pub fn current(&self) -> i32 {
        self.current
    }
}

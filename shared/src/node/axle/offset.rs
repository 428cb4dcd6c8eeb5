//! Torque feed-forward of the guard (object 0x60B2), as a current beside that of the loops.

use crate::bus::network::OFFSET_SYNCS;
use crate::constants::CONTROL_PERIOD;
use crate::motor::cascade::Cascade;
use crate::settings::{Setting, Settings};

/// A torque offset and its age. It is taken in operation only, and forgotten when the mode or the state changes.
#[derive(Clone, Debug)]
pub(super) struct Offset {
    /// A per unit of 0x60B2.
    amperes: f32,
    /// In units of the cascade, up to 2^26.
    current: i32,
    /// How many ticks a new one counts, and how many this one still does.
    life: i32,
    left: i32,
}

impl Offset {
    /// None yet; `amperes` make one unit of 0x60B2. One that is older than the command timeout is none any more, but two that the guard sends may
    /// lie farther apart than that.
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

    /// Takes one control period, and the newest offset if one came.
    #[inline]
    pub fn update(&mut self, newest: Option<i16>, cascade: &Cascade) {
        // Below zero it may wrap: what it ended stays ended.
        self.left = self.left.wrapping_sub(1);
        if self.left < 0 {
            self.current = 0;
        }
        if let Some(torque) = newest {
            self.current = cascade.current(f32::from(torque) * self.amperes);
            self.left = self.life;
        }
    }

    /// Forgets it.
    #[inline]
    pub fn clear(&mut self) {
        self.current = 0;
    }

    /// Current to add, in units of the cascade.
    #[inline]
    pub fn current(&self) -> i32 {
        self.current
    }
}

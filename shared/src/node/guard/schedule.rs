//! Distributes the guard's work over a SYNC period, so that no tick has to do all of it.

use crate::bus::network::OFFSET_SYNCS;
use crate::settings::{Setting, Settings};

/// Work that is due in a tick, in this order.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(clippy::struct_excessive_bools)] // four duties
pub(super) struct Due {
    /// Evaluate how the robot stands. The drives have answered the last SYNC by now.
    pub evaluation: bool,
    /// Update the robot's position.
    pub position: bool,
    /// Send the drives their torque feed-forward.
    pub offsets: bool,
    /// Send SYNC and set-points.
    pub sync: bool,
}

/// Place of the guard within the SYNC period.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // a setting, and what is still due in this period
pub(super) struct Schedule {
    period_us: u64,
    next_sync_us: u64,
    evaluated: bool,
    estimated: bool,
    syncs: u32,
    feed_forward: bool,
    offsets_due: bool,
}

impl Schedule {
    pub fn new(settings: &Settings) -> Self {
        Self {
            period_us: settings.get(Setting::SyncPeriod) as u64,
            next_sync_us: 0,
            evaluated: false,
            estimated: false,
            syncs: 0,
            feed_forward: settings.get(Setting::FeedForward) == 1,
            offsets_due: false,
        }
    }

    /// Returns the SYNC period, s; at most 0.1 s.
    pub fn period(&self) -> f32 {
        self.period_us as u32 as f32 * 1e-6
    }

    /// Returns the work that is due at `now_us`, and marks it as done. The evaluation is due in the
    /// second half of a period, the position in the last quarter. Both are due at the next SYNC at
    /// the latest.
    pub fn due(&mut self, now_us: u64) -> Due {
        let half = self.period_us / 2;
        let sync = now_us >= self.next_sync_us;
        let within = |time: u64| sync || now_us + time >= self.next_sync_us;
        let due = Due {
            evaluation: !self.evaluated && within(half),
            position: !self.estimated && within(half / 2),
            offsets: !self.estimated && within(half / 2) && self.offsets_due && !sync,
            sync,
        };
        self.evaluated |= due.evaluation;
        self.estimated |= due.position;
        if sync {
            self.begin(now_us);
        }
        due
    }

    /// Begins a new period. A late tick does not move the next SYNC, unless it is late by a whole
    /// period.
    fn begin(&mut self, now_us: u64) {
        self.next_sync_us += self.period_us;
        if self.next_sync_us <= now_us {
            self.next_sync_us = now_us + self.period_us;
        }
        (self.evaluated, self.estimated) = (false, false);
        self.syncs = self.syncs.wrapping_add(1);
        self.offsets_due = self.feed_forward && self.syncs.is_multiple_of(OFFSET_SYNCS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts the work in `ticks` ticks of a millisecond, with a SYNC every 4 ms: evaluation,
    /// position, torque feed-forward, SYNC.
    fn duties(ticks: u64, start_us: u64) -> [usize; 4] {
        let mut schedule = Schedule::new(&Settings::default());
        assert_eq!(schedule.period_us, 4_000);
        let mut counted = [0; 4];
        for tick in 0..ticks {
            let due = schedule.due(start_us + tick * 1_000);
            let found = [due.evaluation, due.position, due.offsets, due.sync];
            for (count, one) in counted.iter_mut().zip(found) {
                *count += usize::from(one);
            }
            assert!(!(due.offsets && due.sync));
        }
        counted
    }

    #[test]
    fn each_duty_comes_once_a_period_and_torques_with_each_fourth_sync() {
        // The first SYNC comes in the first tick.
        assert_eq!(duties(4_001, 0), [1_001, 1_001, 250, 1_001]);
    }

    #[test]
    fn a_guard_that_begins_late_catches_nothing_up() {
        assert_eq!(duties(400, 1_000_000)[3], 100);
    }

    /// Tick within a SYNC period of 4 ms in which each duty comes, after the first period.
    #[test]
    fn the_evaluation_comes_at_half_a_period_and_the_position_a_quarter_before_the_next() {
        let mut schedule = Schedule::new(&Settings::default());
        for tick in 0..400_u64 {
            let due = schedule.due(tick * 1_000);
            let found = (due.evaluation, due.position, due.sync);
            let expected = match tick % 4 {
                0 => (tick == 0, tick == 0, true),
                phase => (phase == 2, phase == 3, false),
            };
            assert_eq!(found, expected, "tick {tick}");
            // Of the fourth SYNC, at tick 12, and every fourth after it.
            assert_eq!(due.offsets, tick % 16 == 15, "tick {tick}");
        }
    }
}

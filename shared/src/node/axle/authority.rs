//! Decides who may command the axle: the guard while its heartbeat is alive, otherwise a client in
//! bench mode, otherwise nobody.

use crate::bus::heartbeat::Monitor;
use crate::settings::{Setting, Settings};

/// State of the guard's heartbeat, of the newest set-point and of bench mode.
#[derive(Clone, Debug)]
pub(super) struct Authority {
    guard: Monitor,
    bench: bool,
    command_timeout_us: u64,
    command_until_us: u64,
}

impl Authority {
    /// Creates the state before anything was received.
    pub fn new(settings: &Settings) -> Self {
        Self {
            guard: Monitor::new(settings.milliseconds(Setting::HeartbeatTimeout)),
            bench: false,
            command_timeout_us: settings.milliseconds(Setting::CommandTimeout),
            command_until_us: 0,
        }
    }

    /// Records a heartbeat of the guard.
    #[inline]
    pub fn guard_received(&mut self, now_us: u64) {
        self.guard.received(now_us);
    }

    /// Records a set-point.
    #[inline]
    pub fn command_received(&mut self, now_us: u64) {
        // Microseconds in 64 bits do not wrap. If they did, the command would count as old.
        self.command_until_us = now_us.wrapping_add(self.command_timeout_us);
    }

    /// Returns whether no set-point came for longer than the command timeout.
    #[inline]
    pub fn command_lost(&self, now_us: u64) -> bool {
        now_us > self.command_until_us
    }

    /// Returns whether the guard was received once, is silent now, and bench mode does not replace
    /// it.
    #[inline]
    pub fn guard_lost(&self, now_us: u64) -> bool {
        !self.bench && self.guard.lost(now_us)
    }

    /// Returns whether the guard commands the axle.
    #[inline]
    pub fn guarded(&self, now_us: u64) -> bool {
        self.guard.alive(now_us)
    }

    /// Returns whether bench mode is on.
    #[inline]
    pub fn bench(&self) -> bool {
        self.bench
    }

    /// Returns whether somebody may enable the axle.
    #[inline]
    pub fn any(&self, now_us: u64) -> bool {
        self.bench || self.guard.alive(now_us)
    }

    /// Sets bench mode to `requested`, unless something ends it: the guard's heartbeat, a latched
    /// fault, or no set-point for longer than the command timeout, counted from the start of bench
    /// mode. Returns whether bench mode has begun or ended.
    #[inline]
    pub fn update_bench(&mut self, requested: bool, faultless: bool, now_us: u64) -> bool {
        if !requested && !self.bench {
            return false;
        }
        let before = self.bench;
        let may = requested && faultless && !self.guard.alive(now_us);
        if may && !before {
            self.command_received(now_us);
        }
        self.bench = may && !self.command_lost(now_us);
        self.bench != before
    }
}

//! Recognises a second node that sends with a drive's identifiers, by what one node cannot send:
//! more motions than there are SYNCs, a jump of the position, or heartbeats in quick succession.

use crate::bus::network::NmtState;
use crate::bus::pdo::DriveMotion;
use crate::bus::scale::{Position, Scale};
use crate::settings::{Setting, Settings};

/// Motions beyond one per SYNC that a single node sends, because some came late.
const LATE_MOTIONS: u8 = 2;
/// Largest step of a position besides that which its velocity explains, in turns and in m.
const STEP_TURNS: f32 = 0.02;
const STEP_METRES: f32 = 0.002;
/// Factor on the step that the velocity explains: it may change between two motions.
const EXPLAINED: f32 = 2.0;
/// Shortest time between two heartbeats, as a fraction of their period.
const SHORTEST: f32 = 0.6;

/// What came with the identifiers of one drive.
#[derive(Clone, Debug)]
pub(super) struct Identity {
    doubled: bool,
    /// Motions beyond one per SYNC.
    excess: u8,
    motion: Option<(Position, i32, u64)>,
    step: f32,
    /// Turns/s or m/s per unit of a velocity on the bus.
    rate: f32,
    heartbeat_us: Option<u64>,
    shortest_us: u64,
}

impl Identity {
    pub fn new(scale: Scale, settings: &Settings) -> Self {
        let (step, rate) = match scale {
            Scale::Turning { .. } => (STEP_TURNS, 1e-6 / core::f32::consts::TAU),
            Scale::Linear(_) => (STEP_METRES, 1e-9),
        };
        let period_us = settings.milliseconds(Setting::HeartbeatPeriod) as f32;
        Self {
            doubled: false,
            excess: 0,
            motion: None,
            step,
            rate,
            heartbeat_us: None,
            shortest_us: (SHORTEST * period_us) as u64,
        }
    }

    /// Records that the guard sends a SYNC.
    pub fn note_sync(&mut self) {
        self.excess = self.excess.saturating_sub(1);
    }

    /// Takes a motion. `homes`: the drive may be finding its home position, which sets its position
    /// anew.
    pub fn motion(&mut self, motion: DriveMotion, position: Position, homes: bool, now_us: u64) {
        self.excess = self.excess.saturating_add(1);
        self.doubled |= self.excess > LATE_MOTIONS;
        let velocity = motion.velocity.saturating_abs();
        if let Some((before, speed, before_us)) = self.motion.replace((position, velocity, now_us))
        {
            let seconds = now_us.saturating_sub(before_us) as u32 as f32 * 1e-6;
            let fastest = if speed > velocity { speed } else { velocity };
            let explained = EXPLAINED * (fastest as f32 * self.rate) * seconds;
            let moved = position.turns_since(before).abs();
            self.doubled |= moved > self.step + explained && !homes;
        }
    }

    /// Takes a heartbeat. With its boot-up message a node begins anew.
    pub fn heartbeat(&mut self, network: NmtState, now_us: u64) {
        if network == NmtState::BootUp {
            (self.motion, self.heartbeat_us) = (None, None);
        } else if let Some(before_us) = self.heartbeat_us.replace(now_us) {
            self.doubled |= now_us.saturating_sub(before_us) < self.shortest_us;
        }
    }

    /// Returns whether a second node was seen.
    pub fn doubled(&self) -> bool {
        self.doubled
    }

    /// Forgets that a second node was seen.
    pub fn forget(&mut self) {
        (self.doubled, self.excess, self.motion) = (false, 0, None);
    }
}

//! What the bus has brought to a drive since its last tick.

use super::targets::Targets;
use crate::bus::network::{self, NmtState, OFFSET_SYNCS};
use crate::bus::pace::Pace;
use crate::bus::pdo::{DriveMotion, receive};
use crate::can::Frame;
use crate::constants::CONTROL_PERIOD;
use crate::faults::{Fault, Faults};
use crate::settings::{Setting, Settings};

/// What the bus has brought since the last tick.
#[allow(clippy::struct_excessive_bools)] // independent facts, not states
pub(super) struct Heard {
    pub own: u8,
    guard_id: u8,
    /// Identifier of the joint's motion, for a screw.
    joint_id: Option<u16>,
    pub sync_period_us: u32,
    pub set_point: bool,
    /// A controlword had the bit of a fault reset.
    pub reset: bool,
    pub targets: Targets,
    pub offset: bool,
    pub parameters: bool,
    pub capture: bool,
    pub guard: bool,
    pub found: Faults,
    /// The joint's motion with its time of measurement, us.
    pub joint: Option<(DriveMotion, u64)>,
    sync_us: u64,
    set_points: Pace,
    offsets: Pace,
    motions: Pace,
}

impl Heard {
    pub fn new(settings: &Settings, joint_id: Option<u16>) -> Self {
        Self {
            own: settings.id(Setting::NodeId),
            guard_id: settings.id(Setting::GuardId),
            joint_id,
            sync_period_us: settings.get(Setting::SyncPeriod).unsigned_abs(),
            set_point: false,
            reset: false,
            targets: Targets::default(),
            offset: false,
            parameters: false,
            capture: false,
            guard: false,
            found: Faults::NONE,
            joint: None,
            sync_us: 0,
            set_points: Pace::NEW,
            offsets: Pace::NEW,
            motions: Pace::NEW,
        }
    }

    /// Records what a frame means besides its objects.
    pub fn note(&mut self, frame: &Frame, now_us: u64) {
        if network::is_sync(frame) {
            self.sync_us = now_us;
        }
        self.found
            .insert_if(Fault::DuplicateId, network::is_of(frame, self.own));
        // A guard that waits for its drives commands none of them.
        let ready = (self.guard_id, NmtState::Operational);
        self.guard |= network::as_heartbeat(frame) == Some(ready);
    }

    /// Records that process data have come. The joint's `motion` was measured one control period
    /// before the last SYNC, which all nodes received at the same time.
    pub fn received(&mut self, id: u16, motion: DriveMotion, now_us: u64) {
        let period_us = self.sync_period_us;
        let (fault, twice) = if id & !0x7f == receive(3) {
            self.offset = true;
            let period_us = period_us * OFFSET_SYNCS;
            (
                Fault::SecondMaster,
                self.offsets.is_exceeded(now_us, period_us),
            )
        } else if Some(id) == self.joint_id {
            let measured_us = self.sync_us.saturating_sub((CONTROL_PERIOD * 1e6) as u64);
            self.joint = Some((motion, measured_us));
            (
                Fault::DuplicateId,
                self.motions.is_exceeded(now_us, period_us),
            )
        } else {
            self.set_point = true;
            (
                Fault::SecondMaster,
                self.set_points.is_exceeded(now_us, period_us),
            )
        };
        self.found.insert_if(fault, twice);
    }
}

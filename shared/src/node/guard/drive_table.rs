//! All drives of the robot: their frames, their fault reports, their commands.

use super::FaultReport;
use super::drive_link::Drive;
use super::scales::{SDO_RESPONSE, ScaleReader};
use crate::bus::network::function;
use crate::can::Frame;
use crate::faults::Fault;
use crate::robots::{Body, DriveState, Goal, MAX_DRIVES, Offset};
use crate::settings::{Setting, Settings};
use heapless::Vec;

/// Age from which the report of a drive no longer shows that it stands, us.
const RECENT_US: u64 = 100_000;

/// Position scale of a drive, and the one that the robot's equations use (object 0x400A).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ScaleMismatch {
    /// Node id of the drive.
    pub node: u8,
    /// `Scale::code` that the guard uses.
    pub expected: u16,
    /// `Scale::code` that the drive has; 0 if it has no such object.
    pub found: u16,
}

/// The robot's drives, in the order of [`crate::robots::Body::drive_ids`].
#[derive(Clone, Debug)]
pub(super) struct Drives {
    nodes: Vec<Drive, MAX_DRIVES>,
    states: Vec<DriveState, MAX_DRIVES>,
    scales: Vec<ScaleReader, MAX_DRIVES>,
    expected_scales: Vec<u16, MAX_DRIVES>,
    /// The first drive whose scale differs from the one that the robot's equations use.
    mismatch: Option<ScaleMismatch>,
    /// Node id of the guard itself.
    own_id: u8,
    /// One bit for each node id whose frames concern the guard.
    concerned: [u32; 4],
    /// Node id in a frame of another node, whose identifier only the guard may use.
    foreign: Option<u8>,
    /// The newest drive that has let go without a command.
    let_go: Option<FaultReport>,
    /// Numbers of the guard's own NMT and SYNC frames that have not come back to it yet.
    own_frames: [u8; 2],
}

impl Drives {
    pub fn new<B: Body>(settings: &Settings) -> Self {
        let ids = B::drive_ids(settings);
        let own_id = settings.id(Setting::NodeId);
        let mut concerned = [0; 4];
        for id in ids.iter().chain(&[0, own_id]) {
            concerned[usize::from(id >> 5 & 3)] |= 1 << (id & 31);
        }
        Self {
            nodes: (0..)
                .zip(&ids)
                .map(|(drive, id)| {
                    let wheel = B::ODOMETRY.contains(&drive);
                    Drive::new(*id, wheel, B::scale(drive), settings)
                })
                .collect(),
            states: ids.iter().map(|_| DriveState::default()).collect(),
            scales: ids.iter().map(|_| ScaleReader::default()).collect(),
            expected_scales: (0..ids.len()).map(|drive| B::scale(drive).code()).collect(),
            mismatch: None,
            own_id,
            concerned,
            foreign: None,
            let_go: None,
            own_frames: [0; 2],
        }
    }

    pub fn states(&self) -> &[DriveState] {
        &self.states
    }

    /// Returns the node id of the guard itself.
    pub fn own_id(&self) -> u8 {
        self.own_id
    }

    /// Returns when the oldest of the drives that odometry uses was received, us; `None` before
    /// each of them was.
    pub fn odometry_us<B: Body>(&self) -> Option<u64> {
        let mut oldest = u64::MAX;
        for index in B::ODOMETRY {
            let received_us = self.states.get(*index)?.received_us?;
            if received_us < oldest {
                oldest = received_us;
            }
        }
        Some(oldest)
    }

    /// Returns whether every drive was received since the start, and its scale is known.
    pub fn complete(&self) -> bool {
        self.nodes.iter().all(Drive::seen)
            && self.scales.iter().all(|scale| scale.found().is_some())
    }

    /// Returns whether every track or wheel has reported lately that it does not turn.
    pub fn stand(&self, now_us: u64) -> bool {
        let recent = |received| now_us.saturating_sub(received) < RECENT_US;
        let drives = self.nodes.iter().zip(&self.states);
        drives
            .filter(|(node, _)| node.wheel)
            .all(|(_, state)| !state.rolls && state.received_us.is_some_and(recent))
    }

    /// Returns whether every drive has sent its status since it started.
    pub fn have_status(&self) -> bool {
        self.nodes.iter().all(Drive::has_status)
    }

    pub fn receive(&mut self, frame: &Frame, now_us: u64) {
        // The low seven bits of an identifier are the node id, the others are the function code.
        let (node, function) = ((frame.id() & 0x7f) as u8, frame.id() & !0x7f);
        if !self.concerns(node) {
            return;
        }
        self.watch_identifiers(node, function);
        let mut answered = false;
        let drives = self.nodes.iter_mut().zip(&mut self.states);
        for ((drive, state), scale) in drives.zip(&mut self.scales) {
            if drive.id == node {
                drive.receive(frame, state, now_us);
                self.let_go = drive.take_let_go().or(self.let_go);
                answered |= function == SDO_RESPONSE && scale.receive(frame, node);
            }
        }
        if answered {
            self.compare_scales();
        }
    }

    /// Returns whether frames of this node id concern the guard: those of a drive, those that all
    /// nodes follow (id 0), and those with its own id. A full bus brings mostly others.
    #[inline]
    fn concerns(&self, node: u8) -> bool {
        let word = self.concerned.get(usize::from(node >> 5));
        word.is_some_and(|word| word >> (node & 31) & 1 != 0)
    }

    /// Records a frame of another node whose identifier only the guard may use.
    fn watch_identifiers(&mut self, node: u8, function: u16) {
        let foreign = match (function, node) {
            // The guard's own SYNC and NMT frames come back to it once.
            (function::NMT | function::SYNC_OR_EMERGENCY, 0) => {
                let sent = &mut self.own_frames[usize::from(function != function::NMT)];
                let own = *sent > 0;
                *sent = sent.saturating_sub(1);
                !own
            }
            (function::SYNC_OR_EMERGENCY | function::HEARTBEAT, node) => node == self.own_id,
            (function, node) if function::TPDO.contains(&function) => node == self.own_id,
            (function, node) if function::RPDO.contains(&function) => {
                self.nodes.iter().any(|drive| drive.id == node)
            }
            _ => false,
        };
        if foreign && self.foreign.is_none() {
            self.foreign = Some(node);
        }
    }

    /// Records that the guard sends one SYNC, and a network management command if `network_command`
    /// is true.
    pub fn note_sent(&mut self, network_command: bool) {
        for (sent, more) in self.own_frames.iter_mut().zip([network_command, true]) {
            // A frame from before may still be on its way back.
            let count = *sent + u8::from(more);
            *sent = if count < 2 { count } else { 2 };
        }
        self.nodes.iter_mut().for_each(Drive::note_sync);
    }

    /// Returns the newest drive that has let go without a command since the last call.
    pub fn take_let_go(&mut self) -> Option<FaultReport> {
        self.let_go.take()
    }

    /// Returns the report of a second master, if there is one.
    pub fn second_master(&self) -> Option<FaultReport> {
        let code = Fault::SecondMaster.code();
        self.foreign.map(|node| FaultReport { node, code })
    }

    /// Returns the first fault report. `driving` is true while the robot is or was under power.
    pub fn fault(&self, now_us: u64, driving: bool) -> Option<FaultReport> {
        let second_master = self.second_master();
        if second_master.is_some() {
            return second_master;
        }
        let mut drives = self.nodes.iter().zip(&self.states);
        let fault = drives.find_map(|(drive, state)| drive.fault(state, now_us, driving));
        fault.or_else(|| {
            let ScaleMismatch { node, .. } = self.mismatch()?;
            let code = Fault::ScaleMismatch.code();
            Some(FaultReport { node, code })
        })
    }

    /// Returns the first drive whose scale differs from the one that the robot's equations use.
    pub fn mismatch(&self) -> Option<ScaleMismatch> {
        self.mismatch
    }

    /// Compares the scales that are known so far.
    fn compare_scales(&mut self) {
        let scales = self.scales.iter().zip(&self.expected_scales);
        let mut drives = self.nodes.iter().zip(scales);
        self.mismatch = drives.find_map(|(drive, (scale, expected))| {
            let found = scale.found().filter(|found| found != expected)?;
            Some(ScaleMismatch {
                node: drive.id,
                expected: *expected,
                found,
            })
        });
    }

    /// Returns the drives that have a fault, one bit for each, in their order.
    pub fn faulty(&self) -> u16 {
        let bit = |(index, drive): (usize, &Drive)| u16::from(drive.error_code() != 0) << index;
        self.nodes.iter().enumerate().map(bit).sum()
    }

    /// Clears what the operator acknowledges, and begins a fault reset of each drive that needs
    /// one.
    pub fn begin_reset(&mut self) {
        self.foreign = None;
        let scales = self.scales.iter_mut().zip(&self.expected_scales);
        for (drive, (scale, expected)) in self.nodes.iter_mut().zip(scales) {
            // A restart since the last SYNC counts, although the reset forgets it.
            let restarted = drive.check_restart(false);
            drive.begin_reset();
            if restarted || scale.found() != Some(*expected) {
                scale.forget();
            }
        }
        self.compare_scales();
    }

    /// Returns whether a fault reset is under way.
    pub fn reset_under_way(&self) -> bool {
        self.nodes.iter().any(Drive::resets)
    }

    /// Looks for drives that have restarted. Their scales must be read again.
    pub fn check_restarts(&mut self, driving: bool) {
        let mut forgotten = false;
        for (drive, scale) in self.nodes.iter_mut().zip(&mut self.scales) {
            if drive.check_restart(driving) {
                scale.forget();
                forgotten = true;
            }
        }
        if forgotten {
            self.compare_scales();
        }
    }

    /// Returns whether a drive waits for the network's start command, which the guard sends now.
    pub fn take_start(&mut self) -> bool {
        let waiting = self.nodes.iter_mut().map(Drive::take_start);
        waiting.fold(false, |any, waits| any | waits)
    }

    /// Creates the requests that are due for scales that are not known yet.
    pub fn scale_requests(&mut self, now_us: u64) -> impl Iterator<Item = Frame> {
        let drives = self.nodes.iter().zip(&mut self.scales);
        drives.filter_map(move |(drive, scale)| scale.request(drive.id, now_us))
    }

    /// Creates the set-point frames that bring the drives nearer to their goals; with
    /// `known_only`, of those drives that have sent their status.
    pub fn commands(
        &mut self,
        now_us: u64,
        known_only: bool,
        goal: impl Fn(usize, &DriveState) -> Goal,
    ) -> impl Iterator<Item = Frame> {
        let both = self.nodes.iter_mut().zip(&self.states).enumerate();
        both.filter(move |(_, (drive, _))| !known_only || drive.has_status())
            .map(move |(index, (drive, state))| {
                drive.command(goal(index, state), state.homed, now_us)
            })
    }

    /// Creates the frames with the drives' torque feed-forward.
    pub fn offsets(&self, offsets: &[Offset]) -> impl Iterator<Item = Frame> {
        offsets.iter().filter_map(|offset| {
            let drive = self.nodes.get(offset.drive)?;
            Some(drive.feed_forward(offset.load))
        })
    }
}

#[cfg(test)]
mod tests;

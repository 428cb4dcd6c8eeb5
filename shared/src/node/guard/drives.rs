//! What the guard knows of the drives, from what they put on the bus, and how it commands them.

use super::Trouble;
use crate::bus::heartbeat::Monitor;
use crate::bus::network::{as_emergency, as_heartbeat};
use crate::bus::pdo::{
    DriveMotion, DriveStatus, Payload, PositionSetPoint, TorqueOffset, VelocitySetPoint, receive,
    transmit,
};
use crate::can::Frame;
use crate::faults::Fault;
use crate::node::axle::mode;
use crate::node::cia402::{
    CONTROL_FAULT_RESET, CONTROL_START, State, controlword, status, toward_operation,
};
use crate::robots::{DriveState, Goal, MAX_DRIVES, Offset};
use crate::settings::{Setting, Settings};
use heapless::Vec;

/// Set-points and states come with every SYNC; a drive whose motion is this old no longer moves under control.
const MOTION_TIMEOUT_US: u64 = 60_000;

/// What the guard has to know of one drive beside its [`DriveState`].
#[derive(Clone, Debug)]
struct Drive {
    id: u8,
    heartbeat: Monitor,
    status: DriveStatus,
    emergency: u16,
    reset: bool,
}

impl Drive {
    fn new(id: u8, timeout_us: u64) -> Self {
        Self {
            id,
            heartbeat: Monitor::new(timeout_us),
            status: DriveStatus::default(),
            emergency: 0,
            reset: false,
        }
    }

    fn hear(&mut self, frame: &Frame, state: &mut DriveState, now_us: u64) {
        if let Some(motion) = DriveMotion::from_frame(frame, transmit(1), self.id) {
            state.heard_us = Some(now_us);
            state.position = motion.position;
            state.velocity = motion.velocity;
        } else if let Some(status) = DriveStatus::from_frame(frame, transmit(2), self.id) {
            self.status = status;
            state.torque = status.torque;
            state.referenced = status.statusword & status::REFERENCED != 0;
            state.enabled = self.state() == State::OperationEnabled;
            if status.error_code == 0 {
                self.reset = false;
            }
        } else if as_heartbeat(frame).is_some() {
            self.heartbeat.heard(now_us);
        } else if let Some(emergency) = as_emergency(frame) {
            self.emergency = emergency.code;
        }
    }

    fn state(&self) -> State {
        State::from_statusword(self.status.statusword).unwrap_or(State::SwitchOnDisabled)
    }

    fn trouble(&self, state: &DriveState, now_us: u64, driving: bool) -> Option<Trouble> {
        let silent = state
            .heard_us
            .is_some_and(|heard| now_us.saturating_sub(heard) > MOTION_TIMEOUT_US);
        let code = if self.emergency != 0 {
            self.emergency
        } else if self.heartbeat.lost(now_us) || (driving && silent) {
            Fault::NodeLost.description().code
        } else {
            return None;
        };
        Some(Trouble {
            node: self.id,
            code,
        })
    }

    /// The set-point frame that brings this drive nearer to `goal`.
    fn command(&self, goal: Goal, referenced: bool) -> Frame {
        let state = self.state();
        let mut word = match goal {
            Goal::Off => controlword::DISABLE_VOLTAGE,
            Goal::Hold if state == State::OperationEnabled || state == State::QuickStopActive => {
                controlword::QUICK_STOP
            }
            Goal::Hold => controlword::DISABLE_VOLTAGE,
            _ => toward_operation(state),
        };
        if self.reset {
            word = controlword::DISABLE_VOLTAGE | CONTROL_FAULT_RESET;
        } else if goal == Goal::Reference && state == State::OperationEnabled && !referenced {
            word |= CONTROL_START;
        }
        let (mode, target) = match goal {
            Goal::Off | Goal::Hold => (0, 0),
            Goal::Reference => (mode::HOMING, 0),
            Goal::Position(target) => (mode::CYCLIC_POSITION, target),
            Goal::MoveTo(target) => (mode::PROFILE_POSITION, target),
            Goal::Taut => (mode::TAUT, 0),
            Goal::Velocity(target) => {
                let set_point = VelocitySetPoint {
                    controlword: word,
                    mode: mode::CYCLIC_VELOCITY,
                    target,
                };
                return set_point.frame(receive(2), self.id);
            }
        };
        PositionSetPoint {
            controlword: word,
            mode,
            target,
        }
        .frame(receive(1), self.id)
    }
}

/// The robot's drives, in the order of [`crate::robots::Body::drive_ids`].
#[derive(Clone, Debug)]
pub(super) struct Drives {
    drives: Vec<Drive, MAX_DRIVES>,
    states: Vec<DriveState, MAX_DRIVES>,
}

impl Drives {
    pub fn new(ids: &[u8], settings: &Settings) -> Self {
        let timeout = settings.milliseconds(Setting::HeartbeatTimeout);
        Self {
            drives: ids.iter().map(|id| Drive::new(*id, timeout)).collect(),
            states: ids.iter().map(|_| DriveState::default()).collect(),
        }
    }

    pub fn states(&self) -> &[DriveState] {
        &self.states
    }

    /// Every drive was heard since the start.
    pub fn all_seen(&self) -> bool {
        self.drives.iter().all(|drive| drive.heartbeat.seen())
    }

    pub fn hear(&mut self, frame: &Frame, now_us: u64) {
        // The low seven bits of every identifier that a drive sends are its id.
        let sender = (frame.id() & 0x7f) as u8;
        for (drive, state) in self.drives.iter_mut().zip(&mut self.states) {
            if drive.id == sender {
                drive.hear(frame, state, now_us);
            }
        }
    }

    pub fn trouble(&self, now_us: u64, driving: bool) -> Option<Trouble> {
        self.drives
            .iter()
            .zip(&self.states)
            .find_map(|(drive, state)| drive.trouble(state, now_us, driving))
    }

    pub fn reset_faults(&mut self) {
        for drive in &mut self.drives {
            drive.reset = drive.status.error_code != 0 || drive.emergency != 0;
            drive.emergency = 0;
        }
    }

    /// The set-point frames that bring the drives nearer to their goals.
    pub fn commands(&self, goal: impl Fn(usize) -> Goal) -> impl Iterator<Item = Frame> {
        let both = self.drives.iter().zip(&self.states).enumerate();
        both.map(move |(index, (drive, state))| drive.command(goal(index), state.referenced))
    }

    /// The frames that tell drives their torques in advance.
    pub fn offsets(&self, offsets: &[Offset]) -> impl Iterator<Item = Frame> {
        offsets.iter().filter_map(|offset| {
            let drive = self.drives.get(offset.drive)?;
            let torque = offset.torque;
            Some(TorqueOffset { torque }.frame(receive(3), drive.id))
        })
    }
}

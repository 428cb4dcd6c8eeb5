//! What the guard knows of the four drives, from what they put on the bus, and how it commands them.

use super::Trouble;
use crate::bus::heartbeat::Monitor;
use crate::bus::network::{as_emergency, as_heartbeat};
use crate::bus::pdo::{
    DriveMotion, DriveStatus, Payload, PositionSetPoint, VelocitySetPoint, receive, transmit,
};
use crate::can::Frame;
use crate::faults::Fault;
use crate::node::axle::mode;
use crate::node::cia402::{
    CONTROL_FAULT_RESET, CONTROL_START, State, controlword, status, toward_operation,
};
use crate::settings::{Setting, Settings};

/// What a drive moves.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Role {
    Left = 0,
    Right = 1,
    Joint = 2,
    Screw = 3,
}

/// All roles, in order.
pub(super) const ROLES: [Role; 4] = [Role::Left, Role::Right, Role::Joint, Role::Screw];

/// What a drive shall do.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Goal {
    /// Bridge off.
    Off,
    /// Ramp down and hold.
    Hold,
    /// Find the reference switch.
    Reference,
    /// Follow this position, 2^-32 turn or 2^-24 m.
    Position(i32),
    /// Move to this position by itself, same units.
    MoveTo(i32),
    /// Run at this speed, 1e-6 rad/s.
    Velocity(i32),
    /// Keep the belt taut.
    Taut,
}

/// Set-points and states come with every SYNC; a drive whose motion is this old no longer moves under control.
const MOTION_TIMEOUT_US: u64 = 60_000;

/// One drive as the bus shows it.
#[derive(Clone, Debug)]
pub(super) struct Drive {
    id: u8,
    heartbeat: Monitor,
    motion: Option<(DriveMotion, u64)>,
    status: DriveStatus,
    emergency: u16,
    reset: bool,
}

impl Drive {
    fn hear(&mut self, frame: &Frame, now_us: u64) {
        if as_heartbeat(frame).is_some_and(|(node, _)| node == self.id) {
            self.heartbeat.heard(now_us);
        } else if let Some(motion) = DriveMotion::from_frame(frame, transmit(1), self.id) {
            self.motion = Some((motion, now_us));
        } else if let Some(status) = DriveStatus::from_frame(frame, transmit(2), self.id) {
            self.status = status;
            if status.error_code == 0 {
                self.reset = false;
            }
        } else if let Some(emergency) =
            as_emergency(frame).filter(|emergency| emergency.node == self.id)
        {
            self.emergency = emergency.code;
        }
    }

    /// Position in the drive's bus units; 0 before the first.
    pub fn position(&self) -> i32 {
        self.motion.map_or(0, |(motion, _)| motion.position)
    }

    /// When its motion was last heard, us since power-up.
    pub fn moved_us(&self) -> Option<u64> {
        self.motion.map(|(_, heard_us)| heard_us)
    }

    /// The node was heard since the start.
    pub fn seen(&self) -> bool {
        self.heartbeat.seen()
    }

    /// The drive says that its position is referenced.
    pub fn referenced(&self) -> bool {
        self.status.statusword & status::REFERENCED != 0
    }

    /// State in its statusword.
    pub fn state(&self) -> Option<State> {
        State::from_statusword(self.status.statusword)
    }

    fn trouble(&self, now_us: u64, driving: bool) -> Option<Trouble> {
        let code = self.emergency;
        let silent = self
            .motion
            .is_some_and(|(_, heard)| now_us.saturating_sub(heard) > MOTION_TIMEOUT_US);
        let code = if code != 0 {
            code
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
}

/// The four drives, indexed by [`Role`].
#[derive(Clone, Debug)]
pub(super) struct Drives {
    drives: [Drive; 4],
}

impl Drives {
    pub fn new(settings: &Settings) -> Self {
        let ids = [
            Setting::LeftId,
            Setting::RightId,
            Setting::JointId,
            Setting::ScrewId,
        ];
        let timeout = settings.milliseconds(Setting::HeartbeatTimeout);
        Self {
            drives: ids.map(|setting| Drive {
                id: settings.id(setting),
                heartbeat: Monitor::new(timeout),
                motion: None,
                status: DriveStatus::default(),
                emergency: 0,
                reset: false,
            }),
        }
    }

    pub fn of(&self, role: Role) -> &Drive {
        &self.drives[role as usize]
    }

    pub fn all(&self, condition: impl Fn(&Drive) -> bool) -> bool {
        self.drives.iter().all(condition)
    }

    pub fn hear(&mut self, frame: &Frame, now_us: u64) {
        for drive in &mut self.drives {
            drive.hear(frame, now_us);
        }
    }

    pub fn trouble(&self, now_us: u64, driving: bool) -> Option<Trouble> {
        self.drives
            .iter()
            .find_map(|drive| drive.trouble(now_us, driving))
    }

    pub fn reset_faults(&mut self) {
        for drive in &mut self.drives {
            drive.reset = drive.status.error_code != 0 || drive.emergency != 0;
            drive.emergency = 0;
        }
    }

    /// The set-point frame that brings this drive nearer to `goal`.
    pub fn command(&self, role: Role, goal: Goal) -> Frame {
        let drive = self.of(role);
        let state = drive.state().unwrap_or(State::SwitchOnDisabled);
        let mut word = match goal {
            Goal::Off => controlword::DISABLE_VOLTAGE,
            Goal::Hold if state == State::OperationEnabled || state == State::QuickStopActive => {
                controlword::QUICK_STOP
            }
            Goal::Hold => controlword::DISABLE_VOLTAGE,
            _ => toward_operation(state),
        };
        if drive.reset {
            word = controlword::DISABLE_VOLTAGE | CONTROL_FAULT_RESET;
        } else if goal == Goal::Reference && state == State::OperationEnabled && !drive.referenced()
        {
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
                return set_point.frame(receive(2), drive.id);
            }
        };
        PositionSetPoint {
            controlword: word,
            mode,
            target,
        }
        .frame(receive(1), drive.id)
    }
}

//! One drive as the guard knows it: what it publishes, whether it is in the commanded state, and
//! the set-point frame that it gets next.

use super::FaultReport;
use super::identity::Identity;
use crate::bus::cia402::{
    CONTROL_FAULT_RESET, CONTROL_START, State, controlword, mode, status, toward_operation,
};
use crate::bus::heartbeat::Monitor;
use crate::bus::network::{NmtState, as_emergency, as_heartbeat, is_remark};
use crate::bus::pdo::{
    BeltStatus, DriveMotion, DriveStatus, Payload, PositionSetPoint, TorqueOffset,
    VelocitySetPoint, receive, transmit,
};
use crate::bus::scale::{BusUnits, Scale, from_centi};
use crate::can::Frame;
use crate::faults::Fault;
use crate::robots::{DriveState, Goal};
use crate::settings::{Setting, Settings};

/// Timeout of a drive's motion and status. Motion comes with every SYNC, status with every fifth,
/// and two statuses in a row may be lost.
const MIN_STATE_TIMEOUT_US: u64 = 60_000;
const STATE_TIMEOUT_SYNCS: u64 = 15;
/// Time in which a drive must reach the state that a new goal commands: three transitions, each
/// with its own status.
const MIN_SETTLE_US: u64 = 200_000;
const SETTLE_SYNCS: u64 = 25;

/// Commands of one fault reset. The reset bit is low first, so that an edge follows; then high;
/// then low until the drive has answered. A reset ends after all of these commands, whatever the
/// drive reports.
const RESET_COMMANDS: u8 = 12;
const RESET_HIGH: core::ops::Range<u8> = 7..11;

/// Speed above which a drive without power turns freely, 1e-6 rad/s or nm/s.
const FREE: u32 = 100_000;
/// Speed above which the robot rolls, in the same units. Two tracks of B2P2 that turn against each
/// other so slowly turn the robot by 0.15 degree/s.
const ROLLING: u32 = 10_000;

/// State of the drive's state machine that a goal requires.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Duty {
    Off,
    Hold,
    Operate,
}

impl Duty {
    fn of(goal: Goal) -> Self {
        match goal {
            Goal::Off => Self::Off,
            Goal::Hold => Self::Hold,
            _ => Self::Operate,
        }
    }

    fn is_met_by(self, state: State) -> bool {
        match self {
            Self::Off => !is_powered(state),
            Self::Hold => state != State::OperationEnabled,
            Self::Operate => state == State::OperationEnabled,
        }
    }
}

/// Returns whether a drive in `state` moves or holds its axle.
fn is_powered(state: State) -> bool {
    matches!(state, State::OperationEnabled | State::QuickStopActive)
}

/// One drive as the guard knows it; see the module.
#[derive(Clone, Debug)]
#[allow(clippy::struct_excessive_bools)] // independent facts, not states
pub(super) struct Drive {
    pub id: u8,
    /// The robot rolls on it.
    pub wheel: bool,
    units: BusUnits,
    heartbeat: Monitor,
    identity: Identity,
    /// The drive was commanded to find its home position, and has not reported it since.
    homes: bool,
    state_timeout_us: u64,
    settle_us: u64,
    status: DriveStatus,
    status_us: Option<u64>,
    emergency: u16,
    /// Number of commands that are left of the present fault reset.
    reset: u8,
    duty: Duty,
    /// The drive has been in the commanded state since it was commanded.
    met: bool,
    /// When the commanded state was first commanded, us.
    duty_since_us: u64,
    /// The drive is under power by its newest status, and was not commanded off since.
    powered: bool,
    /// The drive was under power by any status, and was not commanded off since.
    was_powered: bool,
    /// Why the drive has let go since the last [`Self::take_let_go`], although it was not commanded
    /// off; 0 if it has not.
    let_go: u16,
    /// The drive has restarted and lost its state.
    restarted: bool,
    /// Its heartbeat says that it exchanges no process data.
    waits_for_start: bool,
}

impl Drive {
    /// Creates the frame with the drive's torque feed-forward: N m, for a screw N.
    pub fn feed_forward(&self, load: f32) -> Frame {
        let torque = self.units.load(load);
        TorqueOffset { torque }.frame(receive(3), self.id)
    }

    pub fn new(id: u8, wheel: bool, scale: Scale, settings: &Settings) -> Self {
        let syncs = |count: u64, minimum: u64| {
            let time_us = count * settings.get(Setting::SyncPeriod) as u64;
            if time_us > minimum { time_us } else { minimum }
        };
        Self {
            id,
            wheel,
            units: scale.units(),
            heartbeat: Monitor::new(settings.milliseconds(Setting::HeartbeatTimeout)),
            identity: Identity::new(scale, settings),
            homes: false,
            state_timeout_us: syncs(STATE_TIMEOUT_SYNCS, MIN_STATE_TIMEOUT_US),
            settle_us: syncs(SETTLE_SYNCS, MIN_SETTLE_US),
            status: DriveStatus::default(),
            status_us: None,
            emergency: 0,
            reset: 0,
            duty: Duty::Hold,
            met: false,
            duty_since_us: 0,
            powered: false,
            was_powered: false,
            let_go: 0,
            restarted: false,
            waits_for_start: false,
        }
    }

    pub fn receive(&mut self, frame: &Frame, state: &mut DriveState, now_us: u64) {
        if let Some(motion) = DriveMotion::from_frame(frame, transmit(1), self.id) {
            state.received_us = Some(now_us);
            state.position = self.units.position(motion.position);
            self.identity
                .motion(motion, state.position, self.homes, now_us);
            let unpowered = self.state().is_some_and(|state| !is_powered(state));
            let turns = unpowered && motion.velocity.unsigned_abs() > FREE;
            state.rolls = self.wheel && motion.velocity.unsigned_abs() > ROLLING;
            state.turns_freely = turns && (self.wheel || self.was_powered);
        } else if let Some(status) = DriveStatus::from_frame(frame, transmit(2), self.id) {
            self.status = status;
            self.status_us = Some(now_us);
            state.torque = from_centi(status.torque);
            state.homed = status.statusword & status::HOMED != 0;
            state.enabled = self.state() == Some(State::OperationEnabled);
            if status.statusword & status::ALIGNING != 0 {
                // The drive bounds the time of the alignment.
                self.duty_since_us = now_us;
            }
            if let Some(state) = self.state() {
                self.met |= self.duty.is_met_by(state);
                self.watch_power(is_powered(state), Fault::UnexpectedState);
            }
        } else if let Some(belts) = BeltStatus::from_frame(frame, transmit(3), self.id) {
            state.belt_tension = f32::from(belts.tension) * 0.1;
        } else if let Some((_, network)) = as_heartbeat(frame) {
            self.heartbeat.received(now_us);
            self.identity.heartbeat(network, now_us);
            self.waits_for_start |= network != NmtState::Operational;
            if network == NmtState::BootUp {
                self.restarted = true;
                self.status_us = None;
                self.status = DriveStatus::default();
                self.watch_power(false, Fault::NodeLost);
                *state = DriveState::default();
            }
        } else if let Some(emergency) = as_emergency(frame)
            && !is_remark(emergency.code)
        {
            self.emergency = emergency.code;
        }
    }

    /// Records whether the drive is under power. One that lets go although it was not commanded off
    /// is reported: with its own fault, or else with `fault`.
    fn watch_power(&mut self, powered: bool, fault: Fault) {
        if self.duty == Duty::Off {
            return;
        }
        if self.powered && !powered {
            let own = self.error_code();
            self.let_go = if own == 0 { fault.code() } else { own };
        }
        self.powered = powered;
        self.was_powered |= powered;
    }

    /// Returns why the drive has let go since the last call, if it has.
    pub fn take_let_go(&mut self) -> Option<FaultReport> {
        let code = core::mem::take(&mut self.let_go);
        (code != 0).then_some(FaultReport {
            node: self.id,
            code,
        })
    }

    /// Returns the state in the newest statusword; `None` before the first one, and for a word that
    /// no state has.
    fn state(&self) -> Option<State> {
        self.status_us?;
        State::from_statusword(self.status.statusword)
    }

    /// Records that the guard sends a SYNC.
    pub fn note_sync(&mut self) {
        self.identity.note_sync();
    }

    /// Returns whether the drive was received since the guard started.
    pub fn seen(&self) -> bool {
        self.heartbeat.seen()
    }

    /// Returns whether the drive has sent its status since it started.
    pub fn has_status(&self) -> bool {
        self.status_us.is_some()
    }

    /// Returns whether the drive has restarted. Forgets it unless the robot is `driving`.
    pub fn check_restart(&mut self, driving: bool) -> bool {
        let restarted = self.restarted;
        self.restarted &= driving;
        restarted
    }

    /// Returns whether the drive waits for the network's start command, which the guard sends now.
    pub fn take_start(&mut self) -> bool {
        core::mem::take(&mut self.waits_for_start)
    }

    /// Returns the error code of the drive; 0 for none. A code that a reset may clear still counts.
    pub fn error_code(&self) -> u16 {
        if self.emergency != 0 {
            self.emergency
        } else {
            self.status.error_code
        }
    }

    /// Returns the fault report of the drive, if it has a fault. `driving` is true while the robot
    /// is or was under power.
    pub fn fault(&self, state: &DriveState, now_us: u64, driving: bool) -> Option<FaultReport> {
        let older = |received: Option<u64>| {
            received.is_some_and(|received| now_us.saturating_sub(received) > self.state_timeout_us)
        };
        let silent = (driving || self.powered)
            && (older(state.received_us) || older(self.status_us) || self.restarted);
        let code = if self.emergency != 0 {
            self.emergency
        } else if self.heartbeat.lost(now_us) || silent {
            Fault::NodeLost.code()
        } else if self.identity.doubled() {
            Fault::DuplicateNode.code()
        } else if self.resets() {
            // The status of a drive that is being reset still shows the old fault.
            return None;
        } else if self.status.error_code != 0 {
            self.status.error_code
        } else if self.deviates(now_us) {
            Fault::UnexpectedState.code()
        } else {
            return None;
        };
        Some(FaultReport {
            node: self.id,
            code,
        })
    }

    /// Returns whether the newest status is not as commanded, although the drive had the time to
    /// reach the commanded state or was in it before.
    fn deviates(&self, now_us: u64) -> bool {
        let meets = match self.state() {
            Some(state) => self.duty.is_met_by(state),
            None => self.duty != Duty::Operate,
        };
        let settled = now_us.saturating_sub(self.duty_since_us) > self.settle_us;
        !meets && (self.met || settled)
    }

    /// Begins a fault reset of a drive that has a fault, unless one is under way.
    pub fn begin_reset(&mut self) {
        let faulty = self.error_code() != 0 || self.state() == Some(State::Fault);
        self.emergency = 0;
        self.restarted = false;
        self.identity.forget();
        if faulty && self.reset == 0 {
            self.reset = RESET_COMMANDS;
        }
    }

    /// Returns whether a fault reset is under way.
    pub fn resets(&self) -> bool {
        self.reset != 0
    }

    /// Creates the set-point frame that brings the drive one step nearer to `goal`. A target for
    /// another kind of axle holds the drive.
    pub fn command(&mut self, goal: Goal, homed: bool, now_us: u64) -> Frame {
        let wire = match goal {
            Goal::Position(target) | Goal::MoveTo(target) => self.units.target(target),
            Goal::Belt(slack) if slack > 0.0 => self.units.length(slack),
            _ => Some(0),
        };
        let (goal, target) = wire.map_or((Goal::Hold, 0), |wire| (goal, wire));
        let duty = Duty::of(goal);
        self.powered &= duty != Duty::Off;
        self.was_powered &= duty != Duty::Off;
        self.homes = goal == Goal::Home || self.homes && !homed;
        if duty != self.duty || self.resets() {
            self.duty = duty;
            self.met = false;
            self.duty_since_us = now_us;
        }
        let state = self.state();
        let mut word = match (duty, state) {
            (Duty::Off, _) => controlword::DISABLE_VOLTAGE,
            // In every state, "quick stop" holds what is under power and enables nothing.
            (Duty::Hold, _) | (Duty::Operate, None | Some(State::Fault)) => controlword::QUICK_STOP,
            // The drive was in operation, and left it by itself or by another node's command.
            (Duty::Operate, Some(state)) if self.met && state != State::OperationEnabled => {
                controlword::QUICK_STOP
            }
            (Duty::Operate, Some(state)) => toward_operation(state),
        };
        if self.resets() {
            self.reset -= 1;
            if RESET_HIGH.contains(&self.reset) {
                word |= CONTROL_FAULT_RESET;
            }
        } else if goal == Goal::Home && state == Some(State::OperationEnabled) && !homed {
            word |= CONTROL_START;
        }
        let mode = match goal {
            Goal::Off | Goal::Hold => 0,
            Goal::Home => mode::HOMING,
            Goal::Position(_) => mode::CYCLIC_POSITION,
            Goal::MoveTo(_) => mode::PROFILE_POSITION,
            Goal::Belt(_) if target > 0 => mode::RELEASED,
            Goal::Belt(_) => mode::TAUT,
            Goal::Velocity(target) => {
                let set_point = VelocitySetPoint {
                    controlword: word,
                    mode: mode::CYCLIC_VELOCITY,
                    target: self.units.velocity(target),
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

#[cfg(test)]
mod tests;

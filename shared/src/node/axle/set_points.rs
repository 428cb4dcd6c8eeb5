//! Computes a current from a set-point, by the mode of operation.

use super::handshake::Handshake;
use super::torque::TorqueMode;
use super::{ActiveLimit, Axle, Belt, Inputs};
use crate::bus::cia402::{
    CONTROL_FAULT_RESET, CONTROL_HALT, CONTROL_START, DriveCommand, State, mode,
};
use crate::constants::CONTROL_PERIOD;
use crate::faults::Reaction;
use crate::math::{Bound, Turns, limit};
use crate::motor::cascade::{Demand, FeedForward};
use crate::motor::profile::Motion;

/// Set-point that one RPDO carries.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SetPoint {
    /// Controlword of CiA 402.
    pub controlword: u16,
    /// Mode of operation, one of [`mode`]. An unknown mode holds the position.
    pub mode: i8,
    /// Target in bus units: a velocity in the velocity modes, a torque in torque mode, otherwise a
    /// position.
    pub target: i32,
}

/// Command of the newest controlword.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewestCommand {
    pub command: DriveCommand,
    /// Time since which no other command came, us.
    pub since_us: u64,
    /// The command has changed since the axle began to hold.
    renewed: bool,
    /// Time since which a fault reset is requested, us, until it is done.
    reset_us: Option<u64>,
}

impl NewestCommand {
    /// Creates the command of an axle that has received nothing.
    pub fn new() -> Self {
        Self {
            command: DriveCommand::DisableVoltage,
            since_us: 0,
            renewed: false,
            reset_us: None,
        }
    }

    /// Counts as received at `now_us` only, because another node sends commands, too.
    pub fn doubt(&mut self, now_us: u64) {
        self.since_us = now_us;
        self.reset_us = self.reset_us.map(|_| now_us);
    }
}

/// Time for which a command that a drive under power follows must come from the guard alone, us.
const CERTAIN_US: u64 = 20_000;

impl Axle {
    /// Takes a set-point, and runs the state machine.
    pub(super) fn take_commands(&mut self, inputs: &Inputs) {
        let Some(set_point) = inputs.set_point else {
            return;
        };
        let risen = set_point.controlword & !self.controlword;
        let command = DriveCommand::from_controlword(set_point.controlword);
        let changes = command != self.newest.command;
        if changes {
            self.newest.since_us = inputs.now_us;
        }
        self.newest.command = command;
        self.controlword = set_point.controlword;
        let resets = self.take_reset(set_point.controlword, risen, inputs.now_us);
        // A master that keeps commanding "enable" through a stop does not mean that the axle shall
        // start again by itself.
        self.newest.renewed = !resets && (self.newest.renewed || changes);
        let after = self.state.after(command);
        if after != self.state {
            let stale = !self.newest.renewed && self.state == State::QuickStopActive;
            let allowed = !after.is_above(self.state)
                || !(resets || stale) && self.may_come_under_power(inputs.now_us);
            if allowed && self.is_certain(command, inputs.now_us) {
                self.pass(after, command);
            }
        } else if command == DriveCommand::EnableOperation
            && self.exit.is_some()
            && changes
            && !resets
            && self.authority.any(inputs.now_us)
        {
            // A new "enable operation" in operation cancels an exit. A fault would have ended
            // operation.
            self.enter(after);
        }
        if set_point.mode != self.mode {
            // The modes of the belt are one law: its set-point goes on.
            let goes_on = mode::follows_joint(self.mode) && mode::follows_joint(set_point.mode);
            self.mode = set_point.mode;
            // A hold has no mode: the axle stays where it is, with the limits that it has.
            if self.state != State::QuickStopActive && !goes_on {
                self.select_envelope();
                self.anchor();
            }
            self.homing.abort();
            self.handshake = Handshake::default();
        }
        if self.state == State::OperationEnabled
            && self.mode == mode::HOMING
            && risen & CONTROL_START != 0
        {
            self.start_homing(inputs.switches);
        }
        self.take_target(set_point, risen);
        self.command = set_point;
        self.interpolate();
    }

    /// Resets the faults once for each rising edge of the reset bit. Under a living guard the bit
    /// must come for two SYNC periods, and no frame without it: a frame of another node resets
    /// nothing. Returns whether `controlword` belongs to a reset.
    fn take_reset(&mut self, controlword: u16, risen: u16, now_us: u64) -> bool {
        if controlword & CONTROL_FAULT_RESET == 0 {
            self.newest.reset_us = None;
        } else if risen & CONTROL_FAULT_RESET != 0 {
            self.newest.reset_us = Some(now_us);
        }
        let Some(since_us) = self.newest.reset_us else {
            return false;
        };
        // The frames may be a tick nearer to each other.
        let lasts_us = u64::from((2 * self.sync_ticks).saturating_sub(1)) * 1_000;
        if !self.authority.guarded(now_us) || now_us.wrapping_sub(since_us) >= lasts_us {
            self.newest.reset_us = None;
            self.reset_faults();
        }
        true
    }

    /// Returns whether somebody is in command and no latched fault forbids power. An axle without
    /// power whose faults require it to hold may hold for the guard, which brakes what rolls.
    fn may_come_under_power(&self, now_us: u64) -> bool {
        match self.reaction() {
            None => self.authority.any(now_us),
            Some(Reaction::Hold) => {
                !self.powered() && self.commutation.knows_angle() && self.authority.guarded(now_us)
            }
            Some(Reaction::Brake | Reaction::Off) => false,
        }
    }

    /// Returns whether the guard has certainly sent `command`. Under power, a command other than
    /// "quick stop" must have come for [`CERTAIN_US`] without another one in between. A frame of
    /// another node is soon followed by one of the guard.
    fn is_certain(&self, command: DriveCommand, now_us: u64) -> bool {
        command == DriveCommand::QuickStop
            || !(self.powered() && self.authority.guarded(now_us))
            || now_us.wrapping_sub(self.newest.since_us) >= CERTAIN_US
    }

    /// Passes to the state `after` by `command`.
    #[inline(never)] // the tick is smaller in parts
    fn pass(&mut self, after: State, command: DriveCommand) {
        match (self.state, command) {
            (State::OperationEnabled, DriveCommand::QuickStop) => self.quick_stop(),
            // The quick stop ends in "switch on disabled".
            (State::QuickStopActive, DriveCommand::EnableOperation) if self.exit.is_some() => {}
            (State::OperationEnabled | State::QuickStopActive, _)
                if after != State::OperationEnabled =>
            {
                self.leave(after, command);
            }
            (State::SwitchedOn, DriveCommand::EnableOperation) if self.reaction().is_some() => {
                self.hold_in_fault();
            }
            (State::SwitchedOn, DriveCommand::EnableOperation) if self.commutation.start() => {}
            _ => self.enter(after),
        }
    }

    pub(super) fn enter(&mut self, state: State) {
        if state == State::OperationEnabled || state == State::QuickStopActive {
            if !self.powered() {
                self.envelope.cascade.reset();
                self.sign_probe.start();
            }
            if self.homing.stage.is_running() {
                self.homing.abort();
            }
            self.anchor();
        }
        self.commutation.abort();
        self.newest.renewed &= state != State::QuickStopActive;
        self.state = state;
        self.select_envelope();
        self.exit = None;
        self.stopping.halted = false;
        self.handshake = Handshake::default();
    }

    /// Sets the set-point to the measured motion, so that nothing jumps after a change of mode or a
    /// stop.
    pub(super) fn anchor(&mut self) {
        self.motion = Motion {
            position: self.position(),
            velocity: self.velocity(),
            acceleration: 0.0,
        };
        // A closed switch stops it there, and does not pull it back to where the switch has closed.
        self.end_stops.clear();
        self.interpolation_ticks = 0;
        self.torque = TorqueMode::at(self.demand);
        self.offset.clear();
    }

    /// Computes the velocity that carries the set-point to the new target within one SYNC period.
    fn interpolate(&mut self) {
        let stops = self.controlword & CONTROL_HALT != 0 || self.exit.is_some();
        let follows = self.mode == mode::CYCLIC_POSITION && self.homed && !stops;
        if follows && self.state == State::OperationEnabled {
            let target = self.target_position();
            let distance = (target - self.motion.position).radians();
            let wanted = distance * self.syncs_per_second;
            self.motion.velocity = limit(wanted, self.envelope.limits.velocity);
            self.motion.acceleration = 0.0;
            // One more period, so that a late set-point does not stop the axle between two.
            self.interpolation_ticks = 2 * self.sync_ticks;
        }
    }

    fn target_position(&mut self) -> Turns {
        let target = self
            .scale
            .position_from_bus(self.command.target, self.position());
        self.within_travel(target)
    }

    pub(super) fn control(&mut self, inputs: &Inputs, belt: Option<Belt>) -> Option<Demand> {
        self.active_limit = ActiveLimit::None;
        self.stopping.strains = false;
        self.finish_exit();
        self.align(inputs);
        if !self.powered() {
            if !self.commutation.aligns() {
                self.brake.drop_in();
            }
            self.end_stops.clear();
            return None;
        }
        let released = self.exit.is_some() || self.brake.release();
        let stops = self.halts() || self.exit.is_some() || self.state == State::QuickStopActive;
        Some(if stops {
            self.stop(inputs)
        } else if !released {
            self.hold_on_brake(inputs)
        } else {
            self.operate(inputs, belt)
        })
    }

    fn operate(&mut self, inputs: &Inputs, belt: Option<Belt>) -> Demand {
        self.offset
            .update(inputs.torque_offset, &self.envelope.cascade);
        let before = self.motion.position;
        let needs_homing = mode::follows_joint(self.mode)
            || matches!(self.mode, mode::CYCLIC_POSITION | mode::PROFILE_POSITION);
        match (self.mode, belt) {
            _ if needs_homing && !self.homed => {
                self.active_limit = ActiveLimit::NotHomed;
                self.motion
                    .toward_velocity(0.0, self.envelope.limits, CONTROL_PERIOD);
            }
            (mode::TAUT | mode::RELEASED, Some(Ok(motion))) => {
                self.motion = motion;
                if self.lacks_slack {
                    self.active_limit = ActiveLimit::Slack;
                }
            }
            (mode::CYCLIC_POSITION, _) => {
                self.interpolation_ticks = self.interpolation_ticks.saturating_sub(1);
                if self.interpolation_ticks == 0 {
                    self.motion.velocity = 0.0;
                }
                self.motion.advance(self.motion.velocity * CONTROL_PERIOD);
            }
            (mode::PROFILE_POSITION, _) if self.shakes_hands() => self.move_to_target(),
            (mode::PROFILE_POSITION, _) => {
                let target = self.target_position();
                let limits = self.options.profile(self.envelope.limits);
                self.motion.toward_position(target, limits, CONTROL_PERIOD);
            }
            (mode::HOMING, _) => self.home(inputs.switches),
            (mode::CYCLIC_TORQUE, _) => return self.control_torque(inputs),
            (mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY, _) => {
                let target = self.scale.velocity_from_bus(self.command.target);
                let limits = match self.mode {
                    mode::PROFILE_VELOCITY => self.options.profile(self.envelope.limits),
                    _ => self.envelope.limits,
                };
                self.motion.toward_velocity(target, limits, CONTROL_PERIOD);
                self.motion.position = self.position();
                self.stop_at_ends(inputs.switches, None);
                let ahead = self.feed_forward();
                let cascade = &self.envelope.cascade;
                let velocity = cascade.rate(self.velocity());
                return cascade.velocity(
                    ahead.velocity,
                    ahead.current,
                    velocity,
                    self.envelope.full,
                );
            }
            _ => self
                .motion
                .toward_velocity(0.0, self.envelope.limits, CONTROL_PERIOD),
        }
        self.stop_at_ends(inputs.switches, Some(before));
        if matches!(self.mode, mode::CYCLIC_POSITION | mode::PROFILE_POSITION) {
            self.watch_windows();
        }
        self.follow(self.envelope.full)
    }

    pub(super) fn follow(&self, bound: Bound) -> Demand {
        let (error, cascade) = (self.following_error(), &self.envelope.cascade);
        let velocity = cascade.rate(self.velocity());
        cascade.position(error, self.feed_forward(), velocity, bound)
    }

    /// Returns how far the set-point is ahead of the axle.
    pub(super) fn following_error(&self) -> Turns {
        self.motion.position - self.position()
    }

    fn feed_forward(&self) -> FeedForward {
        let mut feed_forward = self.envelope.cascade.feed_forward(&self.motion);
        feed_forward.current += self.offset.current();
        feed_forward
    }
}

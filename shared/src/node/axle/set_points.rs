//! Computes a current from a set-point, by the mode of operation.

use super::handshake::Handshake;
use super::{ActiveLimit, Axle, Inputs};
use crate::bus::cia402::{CONTROL_FAULT_RESET, CONTROL_START, DriveCommand, State, mode};
use crate::constants::CONTROL_PERIOD;
use crate::faults::Fault;
use crate::math::{Bound, limit};
use crate::motor::cascade::{Demand, FeedForward};
use crate::motor::profile::Motion;
use crate::motor::to_radians;
use crate::sensors::Switches;

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

impl Axle {
    /// Takes a set-point, and runs the state machine.
    pub(super) fn take_commands(&mut self, inputs: &Inputs) {
        let Some(set_point) = inputs.set_point else {
            return;
        };
        let risen = set_point.controlword & !self.controlword;
        let command = DriveCommand::from_controlword(set_point.controlword);
        // A master that keeps commanding "enable" through a stop does not mean that the axle shall
        // start again by itself.
        let stale = command == self.asked;
        self.asked = command;
        self.controlword = set_point.controlword;
        let resets = risen & CONTROL_FAULT_RESET != 0;
        if resets {
            self.reset_faults();
        }
        let after = self.state.after(command);
        if after != self.state {
            let allowed = !after.is_above(self.state)
                || !(resets || stale && self.state == State::QuickStopActive)
                    && self.latch.faults().is_empty()
                    && self.authority.any(inputs.now_us);
            if allowed {
                self.pass(after, command);
            }
        } else if command == DriveCommand::EnableOperation
            && self.exit.is_some()
            && !(stale || resets)
            && self.authority.any(inputs.now_us)
        {
            // A new "enable operation" in operation cancels an exit. A fault would have ended
            // operation.
            self.enter(after);
        }
        if set_point.mode != self.mode {
            self.mode = set_point.mode;
            self.select_envelope();
            self.anchor();
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

    /// Passes to the state `after` by `command`.
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
            (State::SwitchedOn, DriveCommand::EnableOperation) if self.commutation.start() => {}
            _ => self.enter(after),
        }
    }

    pub(super) fn enter(&mut self, state: State) {
        if state == State::OperationEnabled || state == State::QuickStopActive {
            if !self.powered() {
                self.force.cascade.reset();
                self.sign_probe.start();
            }
            if self.homing.stage.is_running() {
                self.homing.abort();
            }
            self.anchor();
        }
        self.commutation.abort();
        self.state = state;
        self.select_envelope();
        self.exit = None;
        self.halted = false;
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
        self.interpolation_ticks = 0;
        self.torque_current = self.demand;
        self.barrier = None;
        self.offset.clear();
    }

    /// Computes the velocity that carries the set-point to the new target within one SYNC period.
    fn interpolate(&mut self) {
        let follows = self.mode == mode::CYCLIC_POSITION && self.homed;
        if follows && self.state == State::OperationEnabled {
            let target = self.target_position();
            let distance = to_radians(target.wrapping_sub(self.motion.position));
            let wanted = distance * self.syncs_per_second;
            self.motion.velocity = limit(wanted, self.force.limits.velocity);
            self.motion.acceleration = 0.0;
            // One more period, so that a late set-point does not stop the axle between two.
            self.interpolation_ticks = 2 * self.sync_ticks;
        }
    }

    fn target_position(&mut self) -> i64 {
        let target = self
            .scale
            .position_from_bus(self.command.target, self.position());
        self.within_travel(target)
    }

    pub(super) fn control(
        &mut self,
        inputs: &Inputs,
        taut: Option<Result<Motion, Fault>>,
    ) -> Option<Demand> {
        self.active_limit = ActiveLimit::None;
        self.finish_exit();
        self.align(inputs);
        if !self.powered() {
            if !self.commutation.aligns() {
                self.brake.drop_in();
            }
            self.stops = [None; 2];
            return None;
        }
        let released = self.exit.is_some() || self.brake.release();
        let stops = self.halts() || self.exit.is_some() || self.state == State::QuickStopActive;
        Some(if stops {
            self.stop(inputs)
        } else if !released {
            self.hold_on_brake(inputs)
        } else {
            self.operate(inputs, taut)
        })
    }

    fn operate(&mut self, inputs: &Inputs, taut: Option<Result<Motion, Fault>>) -> Demand {
        self.offset
            .update(inputs.torque_offset, &self.force.cascade);
        let needs_homing = matches!(
            self.mode,
            mode::TAUT | mode::CYCLIC_POSITION | mode::PROFILE_POSITION
        );
        match (self.mode, taut) {
            _ if needs_homing && !self.homed => {
                self.active_limit = ActiveLimit::NotHomed;
                self.motion
                    .toward_velocity(0.0, self.force.limits, CONTROL_PERIOD);
            }
            (mode::TAUT, Some(Ok(motion))) => self.motion = motion,
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
                self.motion
                    .toward_position(target, self.force.limits, CONTROL_PERIOD);
            }
            (mode::HOMING, _) => self.home(inputs.switches),
            (mode::CYCLIC_TORQUE, _) => return self.control_torque(inputs),
            (mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY, _) => {
                let target = self.scale.velocity_from_bus(self.command.target);
                self.motion
                    .toward_velocity(target, self.force.limits, CONTROL_PERIOD);
                self.motion.position = self.position();
                self.stop_at_switch(inputs.switches, false);
                let ahead = self.feed_forward();
                let cascade = &self.force.cascade;
                let velocity = cascade.rate(self.velocity());
                return cascade.velocity(ahead.velocity, ahead.current, velocity, self.force.full);
            }
            _ => self
                .motion
                .toward_velocity(0.0, self.force.limits, CONTROL_PERIOD),
        }
        self.stop_at_switch(inputs.switches, true);
        if matches!(self.mode, mode::CYCLIC_POSITION | mode::PROFILE_POSITION) {
            self.watch_windows();
        }
        self.follow(self.force.full)
    }

    pub(super) fn follow(&self, bound: Bound) -> Demand {
        let (error, cascade) = (self.following_error(), &self.force.cascade);
        let velocity = cascade.rate(self.velocity());
        cascade.position(error, self.feed_forward(), velocity, bound)
    }

    /// Returns how far the set-point is ahead of the axle, 2^-32 turn.
    pub(super) fn following_error(&self) -> i64 {
        self.motion.position.wrapping_sub(self.position())
    }

    fn feed_forward(&self) -> FeedForward {
        let mut feed_forward = self.force.cascade.feed_forward(&self.motion);
        feed_forward.current += self.offset.current();
        feed_forward
    }

    /// Prevents the set-point from moving outward while a limit switch is closed. It stops where
    /// the switch closed, or at its farthest place inward since then. Inward motion is free.
    pub(super) fn stop_at_switch(&mut self, switches: Switches, in_position: bool) {
        if !(switches.positive_limit || switches.negative_limit) {
            self.stops = [None; 2];
            return;
        }
        let closed = [switches.positive_limit, switches.negative_limit];
        let position = self.position();
        for (direction, closed) in closed.into_iter().enumerate() {
            if !closed {
                self.stops[direction] = None;
                continue;
            }
            let sign = if direction == 0 { 1 } else { -1 };
            let beyond = |place| self.motion.position.wrapping_sub(place).wrapping_mul(sign);
            let mut stop = self.stops[direction].unwrap_or(position);
            if beyond(stop) < 0 {
                stop = self.motion.position;
            }
            self.stops[direction] = Some(stop);
            let outward = self.motion.velocity * sign as f32;
            if outward > 0.0 || in_position && outward == 0.0 && beyond(stop) > 0 {
                self.motion = Motion::at(stop);
                self.active_limit = ActiveLimit::Switch;
            }
        }
    }
}

//! What the axle is told, and what it makes of it: from a set-point over the mode of operation to a current.

use super::super::cia402::{CONTROL_FAULT_RESET, CONTROL_START, Command, State};
use super::super::{CONTROL_PERIOD, Switches};
use super::homing::Homing;
use super::{ActiveLimit, Axle, Inputs};
use crate::faults::Fault;
use crate::math::{Bound, limit};
use crate::motor::cascade::Demand;
use crate::motor::profile::SetPoint as Motion;
use crate::motor::to_radians;

/// Modes of operation (object 0x6060). Negative ones are tautrack's own.
pub mod mode {
    /// The screw keeps the belt taut: its set-point is computed from the chassis joint.
    pub const TAUT: i8 = -1;
    /// Profile position: a trapezoid to the target.
    pub const PROFILE_POSITION: i8 = 1;
    /// Profile velocity: a ramp to the target.
    pub const PROFILE_VELOCITY: i8 = 3;
    /// Reference run.
    pub const HOMING: i8 = 6;
    /// Cyclic synchronous position: the target is interpolated between two SYNCs.
    pub const CYCLIC_POSITION: i8 = 8;
    /// Cyclic synchronous velocity.
    pub const CYCLIC_VELOCITY: i8 = 9;
}

/// Set-point of one RPDO.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct SetPoint {
    /// Controlword of `CiA` 402.
    pub controlword: u16,
    /// One of [`mode`]; an unknown mode holds the position.
    pub mode: i8,
    /// Target in bus units: of velocity in the velocity modes, else of position.
    pub target: i32,
}

impl Axle {
    /// Takes a set-point and walks the state machine.
    pub(super) fn obey(&mut self, inputs: &Inputs) {
        let Some(set_point) = inputs.set_point else {
            return;
        };
        // Microseconds in 64 bits do not wrap; if they did, the command would be old.
        self.command_until_us = inputs.now_us.wrapping_add(self.command_timeout_us);
        let risen = set_point.controlword & !self.controlword;
        let command = Command::from_controlword(set_point.controlword);
        // A master that went on commanding "enable" through a fault does not mean the axle to start at its reset.
        let stale = command == self.asked;
        self.asked = command;
        self.controlword = set_point.controlword;
        if risen & CONTROL_FAULT_RESET != 0 {
            self.reset_fault();
        }
        let after = self.state.after(command);
        let re_enabling = self.state == State::QuickStopActive && after == State::OperationEnabled;
        if after != self.state && !(re_enabling && (stale || self.fault.is_some())) {
            self.enter(after);
        }
        if set_point.mode != self.mode {
            self.mode = set_point.mode;
            self.anchor();
            if self.homing != Homing::Done {
                self.homing = Homing::Idle;
            }
        }
        if self.state == State::OperationEnabled
            && self.mode == mode::HOMING
            && risen & CONTROL_START != 0
        {
            self.homing = if inputs.switches.reference {
                Homing::BackOff
            } else {
                Homing::Seek
            };
            self.homing_ticks = 0;
        }
        self.command = set_point;
        self.interpolate();
    }

    pub(super) fn enter(&mut self, state: State) {
        if state == State::OperationEnabled || state == State::QuickStopActive {
            if self.state != State::OperationEnabled {
                self.cascade.reset();
            }
            self.anchor();
        }
        self.state = state;
    }

    /// Set-point onto the measured motion: nothing jumps after a change of mode or a stop.
    pub(super) fn anchor(&mut self) {
        self.motion = Motion {
            position: self.position(),
            velocity: self.velocity(),
            acceleration: 0.0,
        };
        self.interpolation_ticks = 0;
        self.offset.clear();
    }

    /// Velocity that carries the set-point to the new target within one SYNC period.
    fn interpolate(&mut self) {
        let follows = self.mode == mode::CYCLIC_POSITION && self.referenced;
        if follows && self.state == State::OperationEnabled {
            let target = self.target_position();
            let distance = to_radians(target.wrapping_sub(self.motion.position));
            let wanted = distance * self.syncs_per_second;
            self.motion.velocity = limit(wanted, self.limits.velocity);
            self.motion.acceleration = 0.0;
            // One period more, so that a late set-point does not stop the axle between two.
            self.interpolation_ticks = 2 * self.sync_ticks;
        }
    }

    fn target_position(&mut self) -> i64 {
        let target = self
            .scale
            .position_from_bus(self.command.target, self.position());
        match self.travel {
            Some((low, _)) if self.referenced && target < low => {
                self.active_limit = ActiveLimit::Travel;
                low
            }
            Some((_, high)) if self.referenced && target > high => {
                self.active_limit = ActiveLimit::Travel;
                high
            }
            _ => target,
        }
    }

    pub(super) fn control(
        &mut self,
        inputs: &Inputs,
        taut: Option<Result<Motion, Fault>>,
    ) -> Option<Demand> {
        self.active_limit = ActiveLimit::None;
        match self.state {
            State::OperationEnabled => Some(self.operate(inputs, taut)),
            State::QuickStopActive => {
                self.motion
                    .toward_velocity(0.0, self.limits, CONTROL_PERIOD);
                let standing = self.motion.velocity == 0.0;
                Some(self.follow(if standing { self.hold } else { self.full }))
            }
            _ => None,
        }
    }

    fn operate(&mut self, inputs: &Inputs, taut: Option<Result<Motion, Fault>>) -> Demand {
        self.offset.update(inputs.torque_offset, &self.cascade);
        let needs_reference = matches!(
            self.mode,
            mode::TAUT | mode::CYCLIC_POSITION | mode::PROFILE_POSITION
        );
        match (self.mode, taut) {
            _ if needs_reference && !self.referenced => {
                self.active_limit = ActiveLimit::NotReferenced;
                self.motion
                    .toward_velocity(0.0, self.limits, CONTROL_PERIOD);
            }
            (mode::TAUT, Some(Ok(motion))) => self.motion = motion,
            (mode::CYCLIC_POSITION, _) => {
                self.interpolation_ticks = self.interpolation_ticks.saturating_sub(1);
                if self.interpolation_ticks == 0 {
                    self.motion.velocity = 0.0;
                }
                self.motion.advance(self.motion.velocity * CONTROL_PERIOD);
            }
            (mode::PROFILE_POSITION, _) => {
                let target = self.target_position();
                self.motion
                    .toward_position(target, self.limits, CONTROL_PERIOD);
            }
            (mode::HOMING, _) => self.home(inputs.switches),
            (mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY, _) => {
                let target = self.scale.velocity_from_bus(self.command.target);
                self.motion
                    .toward_velocity(target, self.limits, CONTROL_PERIOD);
                self.motion.position = self.position();
                self.stop_at_switch(inputs.switches);
                let reference = self.cascade.reference(&self.motion);
                let velocity = self.cascade.rate(self.velocity());
                return self.cascade.velocity(
                    reference.velocity,
                    reference.current + self.offset.current(),
                    velocity,
                    self.full,
                );
            }
            _ => self
                .motion
                .toward_velocity(0.0, self.limits, CONTROL_PERIOD),
        }
        self.stop_at_switch(inputs.switches);
        self.follow(self.full)
    }

    fn follow(&mut self, bound: Bound) -> Demand {
        let (position, velocity) = (self.position(), self.cascade.rate(self.velocity()));
        let mut reference = self.cascade.reference(&self.motion);
        reference.current += self.offset.current();
        self.cascade.position(&reference, position, velocity, bound)
    }

    fn stop_at_switch(&mut self, switches: Switches) {
        let outward = (switches.positive_limit && self.motion.velocity > 0.0)
            || (switches.negative_limit && self.motion.velocity < 0.0);
        if outward {
            self.motion = Motion::at(self.position());
            self.active_limit = ActiveLimit::Switch;
        }
    }
}

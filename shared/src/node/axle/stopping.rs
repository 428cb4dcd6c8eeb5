//! Stops: quick stop, halt, and ramps to standstill before the bridge goes off. The option codes of
//! CiA 402 select the ramps.

use super::options::Ramp;
use super::{Axle, DriveCommand, Inputs};
use crate::bus::cia402::{CONTROL_HALT, State};
use crate::constants::CONTROL_PERIOD;
use crate::faults::Reaction;
use crate::motor::cascade::Demand;

/// State of the present stop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stopping {
    ramp: Ramp,
    /// The controlword halts the axle.
    pub halted: bool,
    /// The axle holds, and needs more than the hold current.
    pub strains: bool,
    /// This has lasted so long that it was reported.
    pub overloaded: bool,
}

impl Stopping {
    /// Creates the state of an axle that does not stop.
    pub fn new() -> Self {
        Self {
            ramp: Ramp::Quick,
            halted: false,
            strains: false,
            overloaded: false,
        }
    }
}

/// Exit from power that waits for standstill.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exit {
    /// State after it.
    to: State,
    /// The axle ramps to standstill first.
    ramps: bool,
    /// Ticks since the ramp ended.
    waited: u32,
}

/// Ticks after the end of the ramp at which a shaft counts as standing, whatever its speed is.
const SETTLING_TICKS: u32 = 500;

impl Axle {
    /// Follows a command that leads from a state under power to `to`, which is not under power.
    pub(super) fn leave(&mut self, to: State, command: DriveCommand) {
        let codes = &self.options.codes;
        let ramps = match (self.state, command) {
            (State::OperationEnabled, DriveCommand::Shutdown) => codes.shutdown == 1,
            (State::OperationEnabled, DriveCommand::SwitchOn) => codes.disable_operation == 1,
            _ => false,
        };
        // A turning axle has no time to engage its brake before the bridge goes off.
        let brakes = self.brake.takes_time() && self.stands();
        if !(ramps || brakes) {
            self.enter(to);
            return;
        }
        if self.exit.is_none() {
            // Without a ramp, the feed-forward carries the load on.
            if ramps {
                self.stopping.ramp = Ramp::Slow;
                self.anchor();
            }
            self.exit_to(to);
        }
        if let Some(exit) = &mut self.exit {
            (exit.to, exit.ramps) = (to, exit.ramps && ramps);
        }
    }

    /// Follows the command "quick stop" in operation.
    pub(super) fn quick_stop(&mut self) {
        let code = self.options.codes.quick_stop;
        if code == 0 {
            self.leave(State::SwitchOnDisabled, DriveCommand::QuickStop);
            return;
        }
        self.hold(if matches!(code, 1 | 5) {
            Ramp::Slow
        } else {
            Ramp::Quick
        });
        if code <= 2 {
            self.exit_to(State::SwitchOnDisabled);
        }
    }

    /// Ramps to standstill and holds.
    pub(super) fn hold(&mut self, ramp: Ramp) {
        self.stopping.ramp = ramp;
        self.enter(State::QuickStopActive);
    }

    /// Follows a fault whose reaction is to hold. An exit that has begun goes on.
    pub(super) fn hold_in_fault(&mut self) {
        let exit = self.exit;
        self.hold(if self.options.codes.fault_reaction == 1 {
            Ramp::Slow
        } else {
            Ramp::Quick
        });
        self.exit = exit;
    }

    /// Returns the reaction to the latched faults: that of the table of faults, or the stronger one
    /// of the fault reaction option code.
    pub(super) fn reaction(&self) -> Option<Reaction> {
        match self.latch.faults().reaction() {
            Some(Reaction::Hold) if self.options.codes.fault_reaction == 0 => Some(Reaction::Off),
            reaction => reaction,
        }
    }

    fn exit_to(&mut self, to: State) {
        self.exit = Some(Exit {
            to,
            ramps: true,
            waited: 0,
        });
    }

    /// Engages the brake once the axle stands, and then ends the exit.
    pub(super) fn finish_exit(&mut self) {
        let (standing, stopped) = (self.stands(), self.motion.velocity == 0.0);
        let Some(exit) = &mut self.exit else {
            return;
        };
        if exit.ramps {
            if !stopped {
                return;
            }
            exit.waited += 1;
            if !standing && exit.waited < SETTLING_TICKS {
                return;
            }
        }
        exit.ramps = false;
        let to = exit.to;
        if self.brake.engage() {
            self.enter(to);
        }
    }

    /// Returns whether the shaft stands: it turns with less than 1 % of the velocity limit.
    pub fn stands(&self) -> bool {
        self.velocity().abs() < self.envelope.stall.standing
    }

    /// Returns whether the controlword halts the axle. The set-point starts at the measured motion
    /// when a halt begins and when it ends.
    pub(super) fn halts(&mut self) -> bool {
        let halts = self.state == State::OperationEnabled && self.controlword & CONTROL_HALT != 0;
        if halts != self.stopping.halted {
            self.stopping.halted = halts;
            if halts {
                self.stopping.ramp = if self.options.codes.halt == 1 {
                    Ramp::Slow
                } else {
                    Ramp::Quick
                };
                self.homing.abort();
            }
            self.anchor();
        }
        halts
    }

    /// Ramps to standstill, and holds there with the current that this takes. A hold that takes
    /// more than the hold current is supervised: a bound would let the load turn the axle.
    pub(super) fn stop(&mut self, inputs: &Inputs) -> Demand {
        let limits = self.options.stop(self.stopping.ramp, self.envelope.limits);
        let before = self.motion.position;
        self.motion.toward_velocity(0.0, limits, CONTROL_PERIOD);
        self.stop_at_ends(inputs.switches, Some(before));
        let holding = self.motion.velocity == 0.0 && self.state == State::QuickStopActive;
        let demand = self.follow(self.envelope.full);
        let bears = self.envelope.hold.limit(demand.current) == demand.current;
        self.stopping.strains = holding && self.exit.is_none() && !bears;
        demand
    }
}

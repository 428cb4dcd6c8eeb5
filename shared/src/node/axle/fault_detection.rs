//! Raises the faults of the axle from its readings, and applies their reaction.

use super::homing::Stage;
use super::options::Ramp;
use super::sign_probe::Sign;
use super::watches::{Power, Readings};
use super::{Axle, Belt, Inputs};
use crate::bus::cia402::{State, mode};
use crate::faults::{Fault, Faults, Reaction};
use crate::math::Turns;
use crate::motor::back_emf::{Findings, Observed};
use crate::motor::bridge::BridgeStop;

/// Faults that a reset clears although homing has not been repeated yet.
const HOMING_FAULTS: Faults = Faults::of(Fault::HomingFailed).or(Faults::of(Fault::HomingMismatch));

impl Axle {
    /// Raises the faults whose conditions are met, even if other faults are latched already, and
    /// applies the strongest reaction.
    #[inline(never)] // the tick is smaller in two parts
    pub(super) fn raise_faults<const WATCHES: bool>(
        &mut self,
        inputs: &Inputs,
        belt: Option<Belt>,
    ) {
        let (enabled, powered) = (self.state == State::OperationEnabled, self.energized());
        let aligns = self.commutation.aligns();
        let in_position = enabled && mode::controls_position(self.mode);
        let sign = if self.powered() {
            let doubtful = self.encoder.is_doubtful();
            self.sign_probe.tick(self.position(), doubtful, self.demand)
        } else {
            Sign::default()
        };
        let motor = self.check_motor::<WATCHES>(inputs, aligns);
        let readings = Readings {
            current: inputs.current,
            demand: self.demand,
            supply_voltage: inputs.supply_voltage,
            velocity: self.velocity(),
            commanded_velocity: self.motion.velocity,
            following_error: if in_position {
                self.following_error()
            } else {
                Turns::ZERO
            },
            power: match powered {
                true if self.stopping.strains => Power::Strained,
                true => Power::On,
                false => Power::Off,
            },
            motor,
            misaligned: self.commutation.take_failure() || sign.against,
            noisy: self.encoder.is_noisy(),
            temperatures: inputs.temperatures,
            electrical: inputs.electrical,
        };
        let stall = self.envelope.stall;
        let mut present = self.watches.check(&readings, &self.bounds, stall);
        present.insert_if(Fault::Blocked, sign.stands);
        // A calibration, which measures the zero, runs without this state.
        let ready = self.state == State::SwitchedOn || self.powered();
        let wrong_zero = inputs.electrical.wrong_zero;
        present.insert_if(Fault::InvalidReading, ready && wrong_zero);
        if let Some(stop) = inputs.bridge_stop {
            let (fault, counts) = match stop {
                BridgeStop::SafeTorqueOff => (Fault::SafeTorqueOff, ready),
                BridgeStop::Comparator => (Fault::ShortCircuit, ready),
                BridgeStop::Processor => (Fault::ProcessorEvent, ready),
                BridgeStop::Crash => (Fault::ProcessorEvent, true),
            };
            present.insert_if(fault, counts);
        }
        // Also without power: counts that are lost then are lost for good.
        present.insert_if(Fault::EncoderNoise, inputs.encoder_broken);
        if WATCHES && let Some(shaft) = &self.shaft {
            present.insert_if(Fault::ShaftMismatch, shaft.has_drifted());
        }
        if let Some(fault) = self.commutation.check_index(inputs.electrical.index) {
            present.insert_if(fault, true);
        }
        if powered {
            let now_us = inputs.now_us;
            present.insert_if(Fault::GuardLost, self.authority.guard_lost(now_us));
            present.insert_if(Fault::CommandLost, self.authority.command_lost(now_us));
        }
        if enabled && self.mode == mode::HOMING {
            let stage = self.homing.stage;
            present.insert_if(Fault::HomingFailed, stage == Stage::Failed);
            present.insert_if(Fault::HomingMismatch, stage == Stage::Mismatch);
        }
        if self.follows_joint()
            && let Some(Err(fault)) = belt
        {
            present.insert_if(fault, true);
        }
        present = present.or(self.take_reported(inputs.now_us));
        // An overload is reported once, so that a reset leads to operation, which holds the load.
        let overloaded = present.contains(Fault::HoldOverload);
        if core::mem::replace(&mut self.stopping.overloaded, overloaded) {
            present = present.without(Faults::of(Fault::HoldOverload));
        }
        self.present = present;
        if self.snapshot.is_none() {
            self.snapshot = self.take_snapshot(present, inputs);
        }
        self.latch.raise(present);
        self.commutation.doubt(present);
        self.react();
        let faultless = self.latch.faults().is_empty();
        let bench_changes =
            self.authority
                .update_bench(inputs.bench_mode, faultless, inputs.now_us);
        if bench_changes {
            if !self.authority.bench() && self.state == State::OperationEnabled {
                self.hold(Ramp::Quick);
            }
            self.select_envelope();
        }
    }

    /// Returns what the voltage of the bridge shows. While the rotor aligns, its angle is not
    /// known.
    #[inline]
    fn check_motor<const WATCHES: bool>(&mut self, inputs: &Inputs, aligns: bool) -> Findings {
        let observed = Observed {
            current: inputs.current,
            demand: self.limiter.demand(),
            velocity: self.velocity(),
            supply_voltage: inputs.supply_voltage,
            electrical: inputs.electrical,
        };
        let powered = self.powered();
        let mut watch = if WATCHES {
            self.angle_watch.as_mut()
        } else {
            None
        };
        let ripple = watch.as_mut().map(|watch| watch.ripple());
        let mut motor = self.back_emf.check(&observed, ripple);
        if let Some(watch) = watch {
            motor.slipped |= watch.tick(&observed, powered);
            if aligns {
                watch.forget_angle();
            }
        }
        if aligns {
            self.back_emf.forget_angle();
            motor = motor.of_turning_field();
        }
        motor
    }

    /// Returns the faults that the bus has found since the previous tick.
    fn take_reported(&mut self, now_us: u64) -> Faults {
        let reported = core::mem::take(&mut self.reported);
        // A client in bench mode sends as often as it wants.
        if !self.authority.guarded(now_us) {
            return reported.without(Faults::of(Fault::SecondMaster));
        }
        if reported.contains(Fault::SecondMaster) {
            // The newest command may have hidden one of the guard in the same tick.
            self.newest.doubt(now_us);
        }
        reported
    }

    /// Enters the state that the strongest reaction of the latched faults requires.
    fn react(&mut self) {
        match self.reaction() {
            Some(Reaction::Brake | Reaction::Off) => self.enter(State::Fault),
            Some(Reaction::Hold) if self.state == State::OperationEnabled => self.hold_in_fault(),
            Some(Reaction::Hold) | None => {}
        }
    }

    /// Clears the faults whose cause is gone. Leaves the state "fault" if no remaining fault
    /// requires it.
    pub(super) fn reset_faults(&mut self) {
        let mut present = self.present;
        if self.homing.stage.is_failure() {
            self.homing.abort();
            present = present.without(HOMING_FAULTS);
        }
        self.latch.reset(present);
        let reaction = self.reaction();
        if self.state == State::Fault && reaction <= Some(Reaction::Hold) {
            self.enter(State::SwitchOnDisabled);
        }
    }
}

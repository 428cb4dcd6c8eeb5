//! Converts a demanded current to outputs: the bridge's command, after the current limiter, and the
//! node's messages.

use super::homing::Stage;
use super::{ActiveLimit, Axle, BridgeDemand, Inputs, Outputs};
use crate::bus::cia402::{State, mode, status};
use crate::bus::pdo::{DriveMotion, DriveStatus};
use crate::bus::scale::{milli, milli_i32};
use crate::faults::Reaction;
use crate::math::{root_of_sum, saturate, to_i16};
use crate::motor::alignment::Progress;
use crate::motor::angle_watch::AngleWatch;
use crate::motor::cascade::Demand;
use crate::motor::limits::{Conditions, Limited};
use crate::sensors::Switches;

fn conditions(inputs: &Inputs, velocity: f32) -> Conditions {
    Conditions {
        current: inputs.current,
        supply_voltage: inputs.supply_voltage,
        voltage: inputs.electrical.voltage.map_or(0.0, length),
        velocity,
        temperatures: inputs.temperatures,
    }
}

/// Length of a vector.
fn length([d, q]: [f32; 2]) -> f32 {
    root_of_sum(d * d + q * q)
}

/// Word of object 0x60fd.
fn digital_inputs(switches: Switches) -> u32 {
    u32::from(switches.negative_limit)
        | u32::from(switches.positive_limit) << 1
        | u32::from(switches.home) << 2
}

impl Axle {
    /// Returns the outputs of a tick.
    pub(super) fn outputs<const WATCHES: bool>(
        &mut self,
        inputs: &Inputs,
        demand: Option<Demand>,
    ) -> Outputs {
        if demand.is_some_and(|demand| demand.cut() != 0) && self.active_limit == ActiveLimit::None
        {
            self.active_limit = ActiveLimit::VelocityOrCurrent;
        }
        let limited = demand.map(|demand| self.limit::<WATCHES>(inputs, demand));
        let aligning = self.commutation.demand();
        let aligning = aligning.map(|progress| self.limit_alignment(inputs, progress));
        if limited.is_none() && aligning.is_none() {
            self.limiter.idle(inputs.current);
        }
        self.demand = limited.map_or(0.0, |limited| limited.current);
        let bridge = match (limited, self.state) {
            _ if let Some(bridge) = aligning => bridge,
            (
                Some(Limited {
                    current, direct, ..
                }),
                _,
            ) if direct != 0.0 => BridgeDemand::Braking { current, direct },
            (Some(Limited { current, .. }), _) => BridgeDemand::Current(current),
            (None, State::Fault) if self.reaction() != Some(Reaction::Off) => BridgeDemand::Brake,
            (None, _) => BridgeDemand::Off,
        };
        Outputs {
            bridge,
            velocity: self.velocity(),
            motion: DriveMotion {
                position: self.scale.position_to_bus(self.position()),
                velocity: self.scale.velocity_to_bus(self.velocity()),
            },
            status: DriveStatus {
                statusword: self.statusword(),
                error_code: self.latch.code(),
                torque: to_i16(inputs.current * self.torque_per_ampere),
                current: milli(inputs.current),
            },
            mode: self.mode,
            active_limit: self.active_limit,
            emergency: self.latch.emergency(),
            bench_mode: self.authority.bench(),
            homing_difference: saturate(self.homing.difference.to_bits()),
            faults: self.latch.faults(),
            brake_released: self.brake.is_energized(),
            snapshot: self.snapshot.take(),
            heat: self.limiter.heat(),
            alignment: self.commutation.state(),
            supply_voltage: milli_i32(inputs.supply_voltage).max(0).unsigned_abs(),
            belt_tension: 0,
            digital_inputs: digital_inputs(inputs.switches),
        }
    }

    /// The current limiter of the control task. It is defined for every input. docs/nodes.md, "What
    /// limits what", lists the gates before it and after it.
    fn limit<const WATCHES: bool>(&mut self, inputs: &Inputs, demand: Demand) -> Limited {
        let amperes = self.envelope.cascade.amperes(demand.current);
        let conditions = conditions(inputs, self.velocity());
        let bound = self.sign_probe.bound(self.envelope.current_limit);
        let watch = if WATCHES { &self.angle_watch } else { &None };
        let probe = watch.as_ref().map(AngleWatch::probe);
        let left = probe.map_or(bound, |probe| probe.bound(bound));
        let mut limited = self.limiter.limit(amperes, left, &conditions);
        if let Some(probe) = probe
            && limited.direct == 0.0
        {
            let direct = probe.direct();
            limited.direct = self.limiter.add_direct(direct, bound, &conditions);
        }
        if limited.cause == ActiveLimit::None && amperes.abs() > bound {
            limited.cause = ActiveLimit::SignProbe;
        }
        if limited.cause != ActiveLimit::None {
            self.active_limit = limited.cause;
        }
        // The angle probe takes from the current without a cause.
        let left = limited.cause != ActiveLimit::None || demand.is_torque();
        let left = left.then_some(limited.current);
        self.envelope.cascade.advance(&demand, left);
        limited
    }

    /// Limits the current of an alignment as any other.
    fn limit_alignment(&mut self, inputs: &Inputs, progress: Progress) -> BridgeDemand {
        let conditions = conditions(inputs, self.velocity());
        let mut limit = |current| {
            let bound = self.envelope.current_limit;
            self.limiter.limit(current, bound, &conditions).current
        };
        self.active_limit = ActiveLimit::Alignment;
        match progress {
            Progress::Drive(current, field) => BridgeDemand::Align {
                current: limit(current),
                field,
            },
            Progress::Done(error) => {
                limit(0.0);
                BridgeDemand::Aligned(error)
            }
            Progress::Failed => BridgeDemand::Off,
        }
    }

    fn statusword(&self) -> u16 {
        let mut word = self.state.statusword();
        if self.mode == mode::HOMING && !self.stopping.halted {
            word |= match self.homing.stage {
                Stage::Done => status::TARGET_REACHED | status::FOLLOWING,
                Stage::Failed | Stage::Mismatch if self.stands() => {
                    status::TARGET_REACHED | status::ERROR_OF_MODE
                }
                Stage::Failed | Stage::Mismatch => status::ERROR_OF_MODE,
                Stage::Idle => status::TARGET_REACHED,
                _ => 0,
            };
        } else {
            word |= self.status_of_mode();
        }
        if self.active_limit != ActiveLimit::None {
            word |= status::LIMIT_ACTIVE;
        }
        if self.commutation.aligns() {
            word |= status::ALIGNING;
        }
        if self.homed {
            word |= status::HOMED;
        }
        word
    }
}

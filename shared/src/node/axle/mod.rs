//! One motor's node: sense, estimate, supervise, follow, limit. It knows nothing of the robot but
//! its own axle.
//!
//! `authority`: who may command the axle. `latch`: its latched faults. `envelope`: the limits in
//! force. `set_points`: from a set-point to a current. `offset`: the torque feed-forward. `homing`:
//! how the position becomes known. Here is the tick around them.

mod authority;
mod envelope;
mod homing;
mod latch;
mod offset;
mod set_points;

pub use set_points::{SetPoint, mode};

use super::cia402::{Command, State, status};
use super::scale::Scale;
use super::supervisor::{Bounds, Readings, Supervisor};
use super::{CONTROL_PERIOD, Switches};
use crate::bus::pdo::{DriveMotion, DriveStatus};
use crate::faults::{Fault, Faults, Reaction};
use crate::math::{limit, saturate, to_i16};
use crate::motor::cascade::Demand;
use crate::motor::from_radians;
use crate::motor::observer::Observer;
use crate::motor::profile::SetPoint as Motion;
use crate::settings::{Setting, Settings};
use authority::Authority;
use envelope::{Envelope, Envelopes};
use homing::{Homing, Stage};
use latch::Latch;
use offset::Offset;

/// What the node sensed and heard since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Wrapping counter of the rotor's encoder.
    pub encoder: i32,
    /// Motor current, A, mean over the tick; NaN if no sample was taken.
    pub current: f32,
    /// Supply voltage, V.
    pub bus_voltage: f32,
    /// End and reference switches.
    pub switches: Switches,
    /// The newest set-point, if one came.
    pub set_point: Option<SetPoint>,
    /// The newest torque offset (object 0x60B2), if one came: 0.01 N m, screw: N.
    pub torque_offset: Option<i16>,
    /// The guard's heartbeat came.
    pub guard_heard: bool,
    /// A client asks for bench mode (object 0x2001).
    pub bench_mode: bool,
}

/// What the bridge shall do until the next tick.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Bridge {
    /// All switches open: the motor turns freely.
    Off,
    /// Windings shorted: the motor resists.
    Brake,
    /// Current loop on, with this demand in A.
    Current(f32),
}

/// What the node does and tells.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Outputs {
    /// Demand to the bridge; its current never exceeds the current limit.
    pub bridge: Bridge,
    /// Payload of TPDO 1.
    pub motion: DriveMotion,
    /// Payload of TPDO 2.
    pub status: DriveStatus,
    /// Mode in force (object 0x6061).
    pub mode: i8,
    /// What limits the axle now (object 0x2000).
    pub active_limit: ActiveLimit,
    /// Code of an emergency frame to send now; 0 is "all clear".
    pub emergency: Option<u16>,
    /// Bench mode is on (object 0x2001).
    pub bench_mode: bool,
    /// Distance of the places at which the two approaches of homing found the switch, 2^-32 turn
    /// (object 0x2002).
    pub homing_difference: i32,
    /// The latched faults.
    pub faults: Faults,
}

/// What keeps the axle from following its set-point exactly (object 0x2000).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ActiveLimit {
    /// Nothing.
    None = 0,
    /// The velocity or the current limit.
    VelocityOrCurrent = 1,
    /// The ends of travel in the settings.
    Travel = 2,
    /// A limit switch.
    Switch = 3,
    /// The axle is not referenced yet.
    NotReferenced = 4,
}

const OBSERVER_BANDWIDTH: f32 = 600.0;

/// What a reset clears although homing has not been repeated yet.
const HOMING_FAULTS: Faults = Faults::of(Fault::HomingFailed).or(Faults::of(Fault::HomingMismatch));

/// State of one axle.
#[derive(Clone, Debug)]
pub struct Axle {
    scale: Scale,
    bounds: Bounds,
    envelopes: Envelopes,
    /// The envelope in force.
    force: Envelope,
    /// Bus units of torque per A.
    torque_per_ampere: f32,
    travel: Option<(i64, i64)>,
    sync_ticks: u32,
    syncs_per_second: f32,

    observer: Observer,
    /// The observer has started at a reading of the encoder.
    sensed: bool,
    supervisor: Supervisor,
    authority: Authority,
    latch: Latch,
    /// Faults whose condition is met in this tick.
    present: Faults,

    state: State,
    mode: i8,
    controlword: u16,
    /// Command of the newest controlword.
    asked: Command,
    command: SetPoint,
    motion: Motion,
    offset: Offset,
    interpolation_ticks: u32,
    homing: Homing,
    referenced: bool,
    /// Where the positive and the negative limit switch closed, while they are closed.
    stops: [Option<i64>; 2],
    active_limit: ActiveLimit,
    /// Current commanded in the tick before, A.
    demand: f32,
}

impl Axle {
    /// Axle with these settings, its bridge off, knowing nothing of its position.
    pub fn new(settings: &Settings) -> Self {
        let scale = Scale::Turning {
            bits: settings.get(Setting::PositionBits) as u32,
        };
        let reference = from_radians(settings.scaled(Setting::ReferencePosition, 1e-6));
        let travel = (
            from_radians(settings.scaled(Setting::PositionMinimum, 1e-3)),
            from_radians(settings.scaled(Setting::PositionMaximum, 1e-3)),
        );
        Self::with_scale(
            settings,
            scale,
            reference,
            (travel.0 < travel.1).then_some(travel),
        )
    }

    /// Axle whose positions on the bus have another scale: for the screw.
    pub(super) fn with_scale(
        settings: &Settings,
        scale: Scale,
        reference_position: i64,
        travel: Option<(i64, i64)>,
    ) -> Self {
        let velocity_limit = settings.scaled(Setting::VelocityLimit, 1e-3);
        let current_limit = settings.scaled(Setting::CurrentLimit, 1e-3);
        let gear = settings.scaled(Setting::GearRatio, 1e-3);
        let torque_constant = settings.scaled(Setting::TorqueConstant, 1e-6) * gear;
        let torque_per_ampere = torque_constant * scale.torque_units();
        let sync_ticks = (settings.get(Setting::SyncPeriod) as u32 / 1_000).max(1);
        let (envelopes, force) = Envelopes::new(settings);
        Self {
            scale,
            bounds: Bounds::new(
                current_limit,
                velocity_limit,
                from_radians(settings.scaled(Setting::FollowingLimit, 1e-3)),
            ),
            envelopes,
            force,
            torque_per_ampere,
            travel,
            sync_ticks,
            syncs_per_second: 1.0 / (sync_ticks as f32 * CONTROL_PERIOD),
            observer: Observer::new(
                settings.get(Setting::EncoderCounts),
                settings.get(Setting::GearRatio),
                OBSERVER_BANDWIDTH,
                0,
            ),
            sensed: false,
            supervisor: Supervisor::default(),
            authority: Authority::new(settings),
            latch: Latch::default(),
            present: Faults::NONE,
            state: State::SwitchOnDisabled,
            mode: 0,
            controlword: 0,
            asked: Command::DisableVoltage,
            command: SetPoint {
                controlword: 0,
                mode: 0,
                target: 0,
            },
            motion: Motion::default(),
            offset: Offset::new(settings, 1.0 / torque_per_ampere),
            interpolation_ticks: 0,
            homing: Homing::new(settings, reference_position),
            referenced: settings.get(Setting::ReferenceDirection) == 0,
            stops: [None; 2],
            active_limit: ActiveLimit::None,
            demand: 0.0,
        }
    }

    /// One control period: sense, estimate, supervise, control, last limiter.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.tick_following(inputs, None)
    }

    /// As [`Axle::tick`], with the set-point of mode [`mode::TAUT`], or the fault that keeps it from being known.
    pub(super) fn tick_following(
        &mut self,
        inputs: &Inputs,
        taut: Option<Result<Motion, Fault>>,
    ) -> Outputs {
        self.sense(inputs);
        self.supervise(inputs, taut);
        self.obey(inputs);
        let demand = self.control(inputs, taut);
        self.outputs(inputs, demand)
    }

    /// Scale of its positions and velocities on the bus.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// True once the position is known.
    pub fn referenced(&self) -> bool {
        self.referenced
    }

    /// The bridge was on in the last tick, in `mode`.
    pub(super) fn drives_in(&self, mode: i8) -> bool {
        self.powered() && self.mode == mode
    }

    /// The current loop is on.
    fn powered(&self) -> bool {
        matches!(self.state, State::OperationEnabled | State::QuickStopActive)
    }

    /// Measured position of the output shaft, 2^-32 turn.
    pub fn position(&self) -> i64 {
        self.observer.position()
    }

    /// Estimated velocity of the output shaft, rad/s.
    pub fn velocity(&self) -> f32 {
        self.observer.velocity()
    }

    fn sense(&mut self, inputs: &Inputs) {
        if !self.sensed {
            self.observer.start(inputs.encoder);
            self.sensed = true;
        }
        self.observer.update(inputs.encoder, CONTROL_PERIOD);
        if inputs.guard_heard {
            self.authority.guard_heard(inputs.now_us);
        }
        if inputs.set_point.is_some() {
            self.authority.command_heard(inputs.now_us);
        }
    }

    /// Raises the faults whose conditions are met, whatever is latched already, and applies the
    /// strongest reaction.
    fn supervise(&mut self, inputs: &Inputs, taut: Option<Result<Motion, Fault>>) {
        let (enabled, powered) = (self.state == State::OperationEnabled, self.powered());
        let in_position =
            enabled && !matches!(self.mode, mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY);
        let readings = Readings {
            current: inputs.current,
            demand: self.demand,
            bus_voltage: inputs.bus_voltage,
            velocity: self.velocity(),
            commanded_velocity: self.motion.velocity,
            following_error: if in_position {
                self.motion.position.wrapping_sub(self.position())
            } else {
                0
            },
            powered,
        };
        let mut present = self
            .supervisor
            .check(&readings, &self.bounds, self.force.stall);
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
        if enabled
            && self.mode == mode::TAUT
            && let Some(Err(fault)) = taut
        {
            present.insert_if(fault, true);
        }
        self.present = present;
        self.latch.raise(present);
        self.react();
        let faultless = self.latch.faults().is_empty();
        let bench_changes =
            self.authority
                .update_bench(inputs.bench_mode, faultless, inputs.now_us);
        if bench_changes {
            self.select_envelope();
            if !self.authority.bench() && self.state == State::OperationEnabled {
                self.enter(State::QuickStopActive);
            }
        }
    }

    /// Enters the state that the strongest reaction of the latched faults asks for.
    fn react(&mut self) {
        match self.latch.faults().reaction() {
            Some(Reaction::Brake | Reaction::Off) => self.state = State::Fault,
            Some(Reaction::Hold) if self.state == State::OperationEnabled => {
                self.enter(State::QuickStopActive);
            }
            Some(Reaction::Hold) | None => {}
        }
    }

    /// Clears the faults whose cause is gone. Leads out of the state "fault" if no fault is left
    /// that needs it.
    fn reset_faults(&mut self) {
        let mut present = self.present;
        if self.homing.stage.is_failure() {
            self.homing.abort();
            present = present.without(HOMING_FAULTS);
        }
        self.latch.reset(present);
        let reaction = self.latch.faults().reaction();
        if self.state == State::Fault && reaction <= Some(Reaction::Hold) {
            self.state = State::SwitchOnDisabled;
        }
    }

    /// The envelope of mode and bench mode.
    fn select_envelope(&mut self) {
        let homing = self.mode == mode::HOMING;
        self.envelopes
            .select(homing, self.authority.bench(), &mut self.force);
        self.offset.clear();
    }

    fn outputs(&mut self, inputs: &Inputs, demand: Option<Demand>) -> Outputs {
        if demand.is_some_and(|demand| demand.cut != 0) && self.active_limit == ActiveLimit::None {
            self.active_limit = ActiveLimit::VelocityOrCurrent;
        }
        // The last limiter: total, and behind everything else.
        let current = demand.map_or(0.0, |demand| {
            let amperes = self.force.cascade.amperes(demand.current);
            limit(amperes, self.force.current_limit)
        });
        self.demand = current;
        let bridge = match (demand, self.state) {
            (Some(_), _) => Bridge::Current(current),
            (None, State::Fault) if self.latch.faults().reaction() != Some(Reaction::Off) => {
                Bridge::Brake
            }
            (None, _) => Bridge::Off,
        };
        Outputs {
            bridge,
            motion: DriveMotion {
                position: self.scale.position_to_bus(self.position()),
                velocity: self.scale.velocity_to_bus(self.velocity()),
            },
            status: DriveStatus {
                statusword: self.statusword(),
                error_code: self.latch.code(),
                torque: to_i16(inputs.current * self.torque_per_ampere),
                current: to_i16(inputs.current * 1e3),
            },
            mode: self.mode,
            active_limit: self.active_limit,
            emergency: self.latch.emergency(),
            bench_mode: self.authority.bench(),
            homing_difference: saturate(self.homing.difference),
            faults: self.latch.faults(),
        }
    }

    fn statusword(&self) -> u16 {
        let mut word = self.state.statusword();
        if self.mode == mode::HOMING {
            match self.homing.stage {
                Stage::Done => word |= status::TARGET_REACHED | status::FOLLOWING,
                Stage::Failed | Stage::Mismatch => word |= status::HOMING_ERROR,
                _ => {}
            }
        } else if self.state == State::OperationEnabled {
            word |= status::FOLLOWING;
        }
        if self.active_limit != ActiveLimit::None {
            word |= status::LIMIT_ACTIVE;
        }
        if self.referenced {
            word |= status::REFERENCED;
        }
        word
    }
}

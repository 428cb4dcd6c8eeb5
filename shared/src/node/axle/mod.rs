//! One motor's node: sense, estimate, supervise, obey, limit. It knows nothing of the robot but its own axle.
//!
//! `set_points`: what it is told, and the current that follows from it. `offset`: the torque it is told in advance. `homing`: the reference run. Here is the tick around both.

mod homing;
mod offset;
mod set_points;

pub use set_points::{SetPoint, mode};

use super::cia402::{Command, State, status};
use super::scale::Scale;
use super::supervisor::{Bounds, Readings, Supervisor};
use super::{CONTROL_PERIOD, Switches};
use crate::bus::heartbeat::Monitor;
use crate::bus::pdo::{DriveMotion, DriveStatus};
use crate::faults::{Fault, Reaction};
use crate::math::{Bound, limit, to_i16};
use crate::motor::cascade::{Cascade, Demand, Gains};
use crate::motor::from_radians;
use crate::motor::observer::Observer;
use crate::motor::profile::{Limits, SetPoint as Motion};
use crate::settings::{Setting, Settings};
use homing::Homing;
use offset::Offset;

/// What the node sensed and heard since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Wrapping counter of the rotor's encoder.
    pub encoder: i32,
    /// Motor current, A, mean over the tick.
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
}

/// What keeps the axle from doing just what it was told (object 0x2000).
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

/// State of one axle.
#[derive(Clone, Debug)]
pub struct Axle {
    scale: Scale,
    limits: Limits,
    bounds: Bounds,
    /// A.
    current_limit: f32,
    /// Bounds of the cascade: the current limit, and the one for holding a position after a loss or a fault.
    full: Bound,
    hold: Bound,
    /// Bus units of torque per A.
    torque_per_ampere: f32,
    travel: Option<(i64, i64)>,
    reference_direction: f32,
    reference_position: i64,
    reference_speed: f32,
    sync_ticks: u32,
    syncs_per_second: f32,
    command_timeout_us: u64,

    observer: Observer,
    /// The observer has started at a reading of the encoder.
    sensed: bool,
    cascade: Cascade,
    supervisor: Supervisor,
    guard: Monitor,

    state: State,
    mode: i8,
    controlword: u16,
    /// What the controlword asks for.
    asked: Command,
    command: SetPoint,
    command_until_us: u64,
    motion: Motion,
    offset: Offset,
    interpolation_ticks: u32,
    homing: Homing,
    homing_ticks: u32,
    referenced: bool,
    fault: Option<Fault>,
    active_limit: ActiveLimit,
    /// Current asked for in the tick before, A.
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
        let hold_current = settings.scaled(Setting::HoldCurrent, 1e-3);
        let gear = settings.scaled(Setting::GearRatio, 1e-3);
        let torque_constant = settings.scaled(Setting::TorqueConstant, 1e-6) * gear;
        let torque_per_ampere = torque_constant * scale.torque_units();
        let sync_ticks = (settings.get(Setting::SyncPeriod) as u32 / 1_000).max(1);
        let cascade = Cascade::new(&Gains {
            position: settings.scaled(Setting::PositionGain, 1e-3),
            velocity: settings.scaled(Setting::VelocityGain, 1e-3),
            integral_time: settings.scaled(Setting::VelocityIntegralTime, 1e-6),
            acceleration: settings.scaled(Setting::AccelerationFeedForward, 1e-6),
            velocity_limit,
            current_limit,
            period: CONTROL_PERIOD,
        });
        Self {
            scale,
            limits: Limits {
                velocity: velocity_limit,
                acceleration: settings.scaled(Setting::AccelerationLimit, 1e-3),
            },
            current_limit,
            bounds: Bounds::new(
                current_limit,
                velocity_limit,
                from_radians(settings.scaled(Setting::FollowingLimit, 1e-3)),
            ),
            full: cascade.bound(current_limit),
            hold: cascade.bound(limit(hold_current, current_limit)),
            torque_per_ampere,
            travel,
            reference_direction: settings.get(Setting::ReferenceDirection) as f32,
            reference_position,
            reference_speed: settings.scaled(Setting::ReferenceSpeed, 1e-3),
            sync_ticks,
            syncs_per_second: 1.0 / (sync_ticks as f32 * CONTROL_PERIOD),
            command_timeout_us: settings.milliseconds(Setting::CommandTimeout),
            observer: Observer::new(
                settings.get(Setting::EncoderCounts),
                settings.get(Setting::GearRatio),
                OBSERVER_BANDWIDTH,
                0,
            ),
            sensed: false,
            cascade,
            supervisor: Supervisor::default(),
            guard: Monitor::new(settings.milliseconds(Setting::HeartbeatTimeout)),
            state: State::SwitchOnDisabled,
            mode: 0,
            controlword: 0,
            asked: Command::DisableVoltage,
            command: SetPoint {
                controlword: 0,
                mode: 0,
                target: 0,
            },
            command_until_us: 0,
            motion: Motion::default(),
            offset: Offset::new(settings, 1.0 / torque_per_ampere),
            interpolation_ticks: 0,
            homing: Homing::Idle,
            homing_ticks: 0,
            referenced: settings.get(Setting::ReferenceDirection) == 0,
            fault: None,
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
        let fault_before = self.fault;
        self.sense(inputs);
        self.supervise(inputs, taut);
        self.obey(inputs);
        let demand = self.control(inputs, taut);
        self.outputs(inputs, demand, fault_before)
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
        let driving = matches!(self.state, State::OperationEnabled | State::QuickStopActive);
        driving && self.mode == mode
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
            self.guard.heard(inputs.now_us);
        }
    }

    fn supervise(&mut self, inputs: &Inputs, taut: Option<Result<Motion, Fault>>) {
        let enabled = self.state == State::OperationEnabled;
        let in_position =
            enabled && !matches!(self.mode, mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY);
        let readings = Readings {
            current: inputs.current,
            demand: self.demand,
            bus_voltage: inputs.bus_voltage,
            velocity: self.velocity(),
            following_error: if in_position {
                self.motion.position.wrapping_sub(self.position())
            } else {
                0
            },
            powered: enabled,
        };
        let mut found = self.supervisor.check(&readings, &self.bounds);
        if enabled && found.is_none() {
            found = match taut {
                Some(Err(fault)) if self.mode == mode::TAUT => Some(fault),
                _ if self.guard.lost(inputs.now_us) => Some(Fault::GuardLost),
                _ if inputs.now_us > self.command_until_us && inputs.set_point.is_none() => {
                    Some(Fault::CommandLost)
                }
                _ if self.homing == Homing::Failed && self.mode == mode::HOMING => {
                    Some(Fault::ReferenceFailed)
                }
                _ => None,
            };
        }
        if let (Some(fault), None) = (found, self.fault) {
            self.raise(fault);
        }
    }

    fn raise(&mut self, fault: Fault) {
        self.fault = Some(fault);
        match fault.description().reaction {
            Reaction::Brake => self.state = State::Fault,
            Reaction::Hold if self.state == State::OperationEnabled => {
                self.enter(State::QuickStopActive);
            }
            Reaction::Hold => {}
        }
    }

    fn reset_fault(&mut self) {
        if self.fault.take().is_some() {
            self.supervisor = Supervisor::default();
            self.homing = if self.homing == Homing::Failed {
                Homing::Idle
            } else {
                self.homing
            };
            if self.state == State::Fault {
                self.state = State::SwitchOnDisabled;
            }
        }
    }

    fn outputs(
        &mut self,
        inputs: &Inputs,
        demand: Option<Demand>,
        fault_before: Option<Fault>,
    ) -> Outputs {
        if demand.is_some_and(|demand| demand.cut != 0) && self.active_limit == ActiveLimit::None {
            self.active_limit = ActiveLimit::VelocityOrCurrent;
        }
        // The last limiter: total, and behind everything else.
        let current = demand.map_or(0.0, |demand| {
            limit(self.cascade.amperes(demand.current), self.current_limit)
        });
        self.demand = current;
        let bridge = match (demand, self.state) {
            (Some(_), _) => Bridge::Current(current),
            (None, State::Fault) => Bridge::Brake,
            (None, _) => Bridge::Off,
        };
        let code = self.fault.map_or(0, |fault| fault.description().code);
        Outputs {
            bridge,
            motion: DriveMotion {
                position: self.scale.position_to_bus(self.position()),
                velocity: self.scale.velocity_to_bus(self.velocity()),
            },
            status: DriveStatus {
                statusword: self.statusword(),
                error_code: code,
                torque: to_i16(inputs.current * self.torque_per_ampere),
                current: to_i16(inputs.current * 1e3),
            },
            mode: self.mode,
            active_limit: self.active_limit,
            emergency: (fault_before != self.fault).then_some(code),
        }
    }

    fn statusword(&self) -> u16 {
        let mut word = self.state.statusword();
        if self.mode == mode::HOMING {
            match self.homing {
                Homing::Done => word |= status::TARGET_REACHED | status::FOLLOWING,
                Homing::Failed => word |= status::HOMING_ERROR,
                Homing::Idle | Homing::Seek | Homing::BackOff => {}
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

//! One motor's node: sense, estimate, supervise, follow, limit. It knows nothing of the robot but
//! its own axle.
//!
//! `interface`: what goes in and comes out. `setup`: from the settings to an axle. `supervision`:
//! from readings to faults. `authority`: who may command the axle. `latch`: its latched faults.
//! `envelope`: the limits in force. `set_points`: from a set-point to a current. `offset`: the
//! torque feed-forward. `homing`: how the position becomes known. `output`: what the node tells,
//! and its last limiter. Here is the tick around them.

mod authority;
mod envelope;
mod homing;
mod interface;
mod latch;
mod offset;
mod output;
mod set_points;
mod setup;
mod supervision;

pub use interface::{ActiveLimit, BridgeDemand, Inputs, Outputs};
pub use set_points::SetPoint;

use super::supervisor::{Bounds, Supervisor};
use crate::bus::cia402::{DriveCommand, State};
use crate::bus::scale::Scale;
use crate::constants::CONTROL_PERIOD;
use crate::faults::{Fault, Faults};
use crate::motor::observer::Observer;
use crate::motor::profile::Motion;
use authority::Authority;
use envelope::{Envelope, Envelopes};
use homing::Homing;
use latch::Latch;
use offset::Offset;

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
    asked: DriveCommand,
    command: SetPoint,
    motion: Motion,
    offset: Offset,
    interpolation_ticks: u32,
    homing: Homing,
    homed: bool,
    /// Where the positive and the negative limit switch closed, while they are closed.
    stops: [Option<i64>; 2],
    active_limit: ActiveLimit,
    /// Current commanded in the tick before, A.
    demand: f32,
}

impl Axle {
    /// One control period: sense, estimate, supervise, control, last limiter.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.tick_following(inputs, None)
    }

    /// As [`Axle::tick`], with the set-point of mode [`crate::bus::cia402::mode::TAUT`], or the
    /// fault that keeps it from being known.
    pub(super) fn tick_following(
        &mut self,
        inputs: &Inputs,
        taut: Option<Result<Motion, Fault>>,
    ) -> Outputs {
        self.sense(inputs);
        self.supervise(inputs, taut);
        self.take_commands(inputs);
        let demand = self.control(inputs, taut);
        self.outputs(inputs, demand)
    }

    /// Scale of its positions and velocities on the bus.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// True once the position is known.
    pub fn homed(&self) -> bool {
        self.homed
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
        if inputs.guard_received {
            self.authority.guard_received(inputs.now_us);
        }
        if inputs.set_point.is_some() {
            self.authority.command_received(inputs.now_us);
        }
    }
}

//! The node of one motor. In each tick it senses, estimates, supervises, follows its set-point, and
//! limits the current. It knows only its own axle, not the robot.
//!
//! * `interface`: inputs and outputs of the tick
//! * `setup`: creates an axle from the settings
//! * `fault_detection`: raises faults, with the `watches` of the readings
//! * `authority`: decides who may command the axle
//! * `latch`: keeps and reports the latched faults
//! * `envelope`: the limits in force
//! * `set_points`: computes a current from a set-point
//! * `offset`: torque feed-forward
//! * `options`: the parameters that a client writes
//! * `handshake`: set-points of profile position mode
//! * `torque`: torque mode
//! * `stopping`: halt, quick stop, and ramps before the bridge goes off
//! * `brake`: releases and engages the holding brake
//! * `commutation`: aligns the rotor before operation is enabled
//! * `shaft`: position at power-up by an absolute sensor
//! * `sign_probe`: limits the first current until the shaft has turned the way of its torque
//! * `encoder`: position and velocity of the shaft
//! * `end_stops`: keeps the set-point inside of switches and travel
//! * `windows`: following error and target reached
//! * `homing`: finds the home switch; `homing_method` says which switch and which edge
//! * `output`: published payloads, and the current limiter
//! * `snapshot`: readings at the first fault
//!
//! This file has the tick, which calls them.

mod authority;
mod brake;
mod commutation;
mod encoder;
mod end_stops;
mod envelope;
mod fault_detection;
mod handshake;
mod homing;
mod homing_method;
mod interface;
mod latch;
mod offset;
mod options;
mod output;
mod set_points;
mod setup;
mod shaft;
mod sign_probe;
mod snapshot;
mod stopping;
mod torque;
mod watches;
mod windows;

pub use commutation::AlignmentState;
pub use interface::{ActiveLimit, BridgeDemand, Inputs, Outputs};
pub use set_points::SetPoint;
pub use snapshot::{NO_SENSOR, Snapshot};

use crate::bus::cia402::{DriveCommand, State, mode};
use crate::bus::scale::Scale;
use crate::faults::{Fault, Faults};
use crate::math::Turns;
use crate::motor::angle_watch::AngleWatch;
use crate::motor::back_emf::BackEmf;
use crate::motor::limits::Limiter;
use crate::motor::profile::Motion;
use authority::Authority;
use brake::Brake;
use commutation::Commutation;
use encoder::Encoder;
use end_stops::EndStops;
use envelope::{Envelope, Envelopes};
use handshake::Handshake;
use homing::Homing;
use latch::Latch;
use offset::Offset;
use options::Options;
use set_points::NewestCommand;
use shaft::Shaft;
use sign_probe::SignProbe;
use stopping::{Exit, Stopping};
use torque::TorqueMode;
use watches::{Bounds, Watches};
use windows::Windows;

/// Set-point that the belt requires of a screw, or the fault because of which it is unknown.
pub(super) type Belt = Result<Motion, Fault>;

/// State of one axle.
#[derive(Clone, Debug)]
pub struct Axle {
    scale: Scale,
    bounds: Bounds,
    envelopes: Envelopes,
    /// The limits and loops in force.
    envelope: Envelope,
    /// Bus units of torque per A.
    torque_per_ampere: f32,
    travel: Option<(Turns, Turns)>,
    sync_ticks: u32,
    syncs_per_second: f32,

    encoder: Encoder,
    watches: Watches,
    back_emf: BackEmf,
    angle_watch: Option<AngleWatch>,
    limiter: Limiter,
    snapshot: Option<Snapshot>,
    authority: Authority,
    latch: Latch,
    /// Faults whose condition is met in this tick.
    present: Faults,
    /// Faults that the bus has found since the previous tick.
    reported: Faults,

    state: State,
    mode: i8,
    controlword: u16,
    newest: NewestCommand,
    command: SetPoint,
    motion: Motion,
    offset: Offset,
    interpolation_ticks: u32,
    options: Options,
    handshake: Handshake,
    torque: TorqueMode,
    stopping: Stopping,
    exit: Option<Exit>,
    brake: Brake,
    commutation: Commutation,
    sign_probe: SignProbe,
    windows: Windows,
    homing: Homing,
    shaft: Option<Shaft>,
    homed: bool,
    end_stops: EndStops,
    active_limit: ActiveLimit,
    lacks_slack: bool,
    /// Current that was commanded in the previous tick, A.
    demand: f32,
}

impl Axle {
    /// Runs one control period: sense, estimate, supervise, control, limit.
    pub fn tick(&mut self, inputs: &Inputs) -> Outputs {
        self.run::<true>(inputs, None)
    }

    /// Runs a tick of the screw: [`Axle::tick`] with the set-point of the modes that follow the
    /// joint ([`crate::bus::cia402::mode::follows_joint`]), or with the fault because of which this
    /// set-point is unknown. `lacks_slack` is whether the belt has not the commanded slack.
    pub(super) fn tick_following(
        &mut self,
        inputs: &Inputs,
        belt: Belt,
        lacks_slack: bool,
    ) -> Outputs {
        self.lacks_slack = lacks_slack;
        self.run::<false>(inputs, Some(belt))
    }

    /// `WATCHES` is whether the role may have an [`AngleWatch`]. The program of a role that has
    /// none does not contain its code.
    fn run<const WATCHES: bool>(&mut self, inputs: &Inputs, belt: Option<Belt>) -> Outputs {
        self.sense(inputs);
        self.raise_faults::<WATCHES>(inputs, belt);
        self.take_commands(inputs);
        let demand = self.control(inputs, belt);
        self.outputs::<WATCHES>(inputs, demand)
    }

    /// Returns the scale of its positions and velocities on the bus.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// Returns whether the axle is homed.
    pub fn homed(&self) -> bool {
        self.homed
    }

    /// Takes faults that the node's bus has found. The next tick raises them.
    pub fn report(&mut self, found: Faults) {
        self.reported = self.reported.or(found);
    }

    /// Returns whether the axle is in operation, in a mode that follows the joint.
    pub(super) fn follows_joint(&self) -> bool {
        self.state == State::OperationEnabled && mode::follows_joint(self.mode)
    }

    /// Returns whether an axle in operation may move: no halt, exit or brake keeps it from that.
    pub(super) fn is_free(&self) -> bool {
        self.exit.is_none() && !self.stopping.halted && self.brake.is_released()
    }

    /// Returns the commanded slack of the belt, 2^-24 m, in [`mode::RELEASED`]; `None` in every
    /// other mode.
    pub(super) fn commanded_slack(&self) -> Option<i32> {
        (self.mode == mode::RELEASED).then_some(self.command.target)
    }

    /// Returns the load that a motor current, A, shows beyond the torque feed-forward: bus units of
    /// torque, of a screw N.
    pub(super) fn unexpected_load(&self, current: f32) -> f32 {
        let expected = self.envelope.cascade.amperes(self.offset.current());
        (current - expected) * self.torque_per_ampere
    }

    /// Returns whether the current loop is on.
    fn powered(&self) -> bool {
        matches!(self.state, State::OperationEnabled | State::QuickStopActive)
    }

    /// Returns the measured position of the output shaft.
    pub fn position(&self) -> Turns {
        self.encoder.position()
    }

    /// Returns the estimated velocity of the output shaft, rad/s.
    pub fn velocity(&self) -> f32 {
        self.encoder.velocity()
    }

    fn sense(&mut self, inputs: &Inputs) {
        let needed = self.homing.needed || self.shaft.is_some();
        self.homed &= !inputs.encoder_broken || !needed;
        self.encoder.update(inputs.encoder);
        if inputs.guard_received {
            if !self.authority.guarded(inputs.now_us) {
                self.forget_client();
            }
            self.authority.guard_received(inputs.now_us);
        }
        if inputs.set_point.is_some() {
            self.authority.command_received(inputs.now_us);
        }
    }
}

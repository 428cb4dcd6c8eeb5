//! Messages between the simulator and one node that runs without a board: one each way per step.
//!
//! On the wire each message is its length as little-endian `u16`, then postcard bytes. The node's clock is the time in
//! the message; between two messages the simulated board runs the PWM periods of one step, so that current loop and
//! rotor live in the node while the rest of the physics lives in the simulator.

use crate::can::Frame;
use crate::sensors::{BodySensors, Switches};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of these messages; both sides compare it before anything else.
pub const VERSION: u16 = 3;
/// Length of a lockstep step in microseconds.
pub const STEP_US: u64 = 1_000;
/// Most frames that one step can deliver to, or take from, a node. A 1 Mbit/s bus carries at most 21 per step.
pub const MAX_FRAMES: usize = 32;
/// Most bytes that a serial line delivers in one step: 115200 baud are 11.5.
pub const MAX_SERIAL: usize = 16;
/// Most log bytes that one step can carry; what does not fit waits for the next.
pub const MAX_LOG: usize = 512;
/// Most settings that [`Start`] can carry.
pub const MAX_SETTINGS: usize = 64;
/// Longest encoded message in bytes, without the length prefix.
pub const MAX_MESSAGE: usize = 1_400;

/// From the simulator to the node.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // one of these exists at a time, and boxes need an allocator
pub enum ToNode {
    /// Message 0: what a real node reads from its flash, and what its motor is like. Answered by [`FromNode::Ready`].
    Start(Start),
    /// One step. Answered by [`FromNode::Stepped`].
    Step(Step),
}

/// What a node has before its first step.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Start {
    /// The simulator's [`VERSION`].
    pub version: u16,
    /// Seed of the simulated sensors' noise.
    pub seed: u64,
    /// Settings as key and value (`tautrack::settings`).
    pub settings: Vec<(u16, i32), MAX_SETTINGS>,
    /// The motor behind the bridge; `None` for a node without one.
    pub motor: Option<MotorModel>,
}

/// A geared brushed DC motor with its bridge and sensors: truth, not what the firmware believes of it.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct MotorModel {
    /// Winding resistance, ohm.
    pub resistance: f32,
    /// Winding inductance, henry.
    pub inductance: f32,
    /// Torque constant, N m/A, equal to the back-EMF constant in V s/rad.
    pub torque_constant: f32,
    /// Inertia at the rotor, kg m^2.
    pub rotor_inertia: f32,
    /// Turns of the rotor for one of the output shaft.
    pub gear_ratio: f32,
    /// Coulomb friction at the output shaft, N m.
    pub friction_torque: f32,
    /// What a spring-applied brake adds to it while the bridge drives no current, N m; 0 without a brake.
    pub brake_torque: f32,
    /// Encoder counts per turn of the rotor.
    pub encoder_counts: u32,
    /// One standard deviation of the current sensor's noise, A.
    pub current_noise: f32,
    /// One step of the current sensor's converter, A.
    pub current_quantum: f32,
}

/// What the world tells a node in one step.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Step {
    /// Virtual time at the end of this step, microseconds since power-up.
    pub time_us: u64,
    /// Sensor values of this step.
    pub sensors: Sensors,
    /// Frames that the bus delivered, in the order in which they won arbitration.
    pub frames: Vec<Frame, MAX_FRAMES>,
    /// Bytes that came in on the board's serial line, in order: sentences of a GNSS receiver.
    pub serial: Vec<u8, MAX_SERIAL>,
}

/// What a board's sensors say, beside those that sit on the motor.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Sensors {
    /// Torque with which the load resists a positive turn of the output shaft, N m. Acts on the rotor; no sensor sees it.
    pub shaft_torque: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// End and home switches of the axle.
    pub switches: Switches,
    /// The encoder keeps its last count whatever the rotor does: a fault of the experiment.
    pub encoder_frozen: bool,
    /// Sensors on the robot's body; `None` on a node that has none.
    pub body: Option<BodySensors>,
}

/// From the node to the simulator.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // as above
pub enum FromNode {
    /// Answer to [`ToNode::Start`].
    Ready(Ready),
    /// Answer to [`ToNode::Step`].
    Stepped(Stepped),
}

/// Who the node is, or why it refuses to be.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Ready {
    /// The node's [`VERSION`].
    pub version: u16,
    /// Role of the program: `axle`, `screw` or `guard`.
    pub role: heapless::String<16>,
    /// Board of the program: `mps2` or `native`.
    pub board: heapless::String<16>,
    /// Why the settings cannot be used: key, value, bounds; empty when they can.
    pub refusal: heapless::String<160>,
}

/// What a node did in one step.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Stepped {
    /// Motion of the output shaft at the end of the step.
    pub shaft: Shaft,
    /// Frames to send, oldest first.
    pub frames: Vec<Frame, MAX_FRAMES>,
    /// Log bytes: defmt's encoding on an ELF target, plain text on the host.
    pub log: Vec<u8, MAX_LOG>,
}

/// The output shaft behind the gear, which the load follows through a stiff coupling.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Shaft {
    /// Position since power-up, 2^-32 turn.
    pub position: i64,
    /// Velocity, rad/s; always finite.
    pub velocity: f32,
}

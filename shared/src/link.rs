//! Messages between the simulator and one node that runs without a board. Each step exchanges one
//! message in each direction.
//!
//! On the wire, each message is its length ([`PREFIX`]) and postcard bytes. The node's clock is the
//! time in the message. Between two messages the simulated board runs the PWM periods of one step.
//! So the current loop and the rotor run in the node, and the rest of the physics runs in the
//! simulator. [`chips`] are the sensor chips of the guard's board. [`parts`] are the same messages,
//! as the node decodes and encodes them.

pub mod chips;
pub mod parts;

use crate::can::Frame;
pub use crate::motor::model::{MotorModel, Shaft, ThreePhaseModel, WindingModel};
use crate::sensors::Switches;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Version of these messages. Both sides compare it before anything else.
pub const VERSION: u16 = 14;
/// Length of a lockstep step in microseconds.
pub const STEP_US: u64 = 1_000;
/// Maximum number of frames that one step can deliver to a node, or take from it. A bus with 1
/// Mbit/s carries at most 21 per step.
pub const MAX_FRAMES: usize = 32;
/// Maximum number of bytes that a serial line delivers in one step; 115200 baud give 11.5.
pub const MAX_SERIAL: usize = 16;
/// Maximum number of log bytes that one step can carry. Further bytes wait for the next step.
pub const MAX_LOG: usize = 512;
/// Maximum number of settings in [`Start`].
pub const MAX_SETTINGS: usize = 64;
/// Maximum length of a role's name in bytes.
pub const MAX_ROLE: usize = 16;
/// Maximum length of [`Start::flash`] in bytes.
pub const MAX_PATH: usize = 200;
/// Maximum length of an encoded message in bytes, without the prefix.
pub const MAX_MESSAGE: usize = 1_400;

/// Bytes in front of each message: its length as little-endian `u16`.
pub const PREFIX: usize = 2;

/// Message from the simulator to the node.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // one of these exists at a time, and boxes need an allocator
pub enum ToNode {
    /// Message 0: the settings that fill a blank flash, and the parameters of the motor. The answer
    /// is [`FromNode::Ready`].
    Start(Start),
    /// One step. The answer is [`FromNode::Stepped`].
    Step(Step),
}

/// Data that a node gets before its first step.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Start {
    /// The simulator's [`VERSION`].
    pub version: u16,
    /// Seed of the simulated sensors' noise.
    pub seed: u64,
    /// File with the contents of the node's flash, which the node writes; a missing file is blank
    /// flash. Empty: the flash is in memory, and blank.
    pub flash: heapless::String<MAX_PATH>,
    /// Settings as pairs of key and value (`tautrack::settings`). They fill a blank flash; the node
    /// does not use them if its flash is not blank. Without any, a blank node stays blank.
    pub settings: Vec<(u16, i32), MAX_SETTINGS>,
    /// The motor at the node's bridge; `None` for a node without a motor.
    pub motor: Option<MotorModel>,
    /// Role of the node, for a program with several. Empty: the program's own role.
    pub role: heapless::String<MAX_ROLE>,
}

/// What a node receives in one step.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Step {
    /// Virtual time at the end of this step, microseconds since power-up.
    pub time_us: u64,
    /// Sensor values of this step.
    pub sensors: Sensors,
    /// Bytes that the board's serial line received, in order: sentences of a GNSS receiver.
    pub serial: Vec<u8, MAX_SERIAL>,
    /// Frames that the bus delivered, in the order in which they won arbitration.
    pub frames: Vec<Frame, MAX_FRAMES>,
}

/// Inputs of a simulated board, except the sensors on the motor.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Sensors {
    /// Torque with which the load resists a positive turn of the output shaft, N m. It acts on the
    /// rotor; no sensor measures it.
    pub shaft_torque: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Limit switches and home switch of the axle.
    pub switches: Switches,
    /// The encoder keeps its last count whatever the rotor does: an injected fault.
    pub encoder_frozen: bool,
    /// What acts on the sensors on the robot's body; `None` on a node that has none.
    pub body: Option<BodyMeasurands>,
}

/// What acts on the sensors on the robot's body, in body axes: x forward, y left, z up. Their chips
/// are simulated in the node: they measure at their own rates and with their own resolution.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct BodyMeasurands {
    /// Specific force, with the noise of the accelerometer, m/s^2; (0, 0, +9.81) at rest on level
    /// ground.
    pub specific_force: [f32; 3],
    /// Angular rate, with noise and constant error of the gyroscope, rad/s.
    pub angular_rate: [f32; 3],
    /// Magnetic flux density, with the noise of the magnetometer and the field of the robot's own
    /// magnets (hard iron), uT.
    pub magnetic_field: [f32; 3],
    /// Specific force, with the noise of the inclinometer, m/s^2.
    pub tilt_force: [f32; 3],
    /// Injected faults of inertial unit, magnetometer and inclinometer.
    pub faults: [Option<ChipFault>; 3],
}

/// Fault of a sensor chip.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChipFault {
    /// The chip holds the data line of the bus low: no transfer ends, to whichever chip.
    BusStuck,
    /// The chip does not acknowledge its address.
    NoAcknowledge,
    /// The output registers keep their values, though the chip reports new readings.
    Frozen,
    /// The identity register has the value of another chip.
    WrongIdentity,
    /// The chip measures half as often as its registers say.
    HalfRate,
    /// Every output is off by another random number, uniform within a quarter of the measuring
    /// range.
    Noise,
}

/// Message from the node to the simulator.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // as for `ToNode`
pub enum FromNode {
    /// Answer to [`ToNode::Start`].
    Ready(Ready),
    /// Answer to [`ToNode::Step`].
    Stepped(Stepped),
}

/// What the node is, or why it does not start.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Ready {
    /// The node's [`VERSION`].
    pub version: u16,
    /// Role of the node: `axle`, `screw` or `guard`.
    pub role: heapless::String<MAX_ROLE>,
    /// Board of the node: `mps2`, `host`, or that of a flash image.
    pub board: heapless::String<16>,
    /// Why the node does not start, for instance key, value and bounds of a setting. Empty if it
    /// starts.
    pub refusal: heapless::String<160>,
}

/// Results of one step of a node.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct Stepped {
    /// Motion of the output shaft at the end of the step.
    pub shaft: Shaft,
    /// Frames to send, oldest first.
    pub frames: Vec<Frame, MAX_FRAMES>,
    /// Log bytes: defmt's encoding on an ELF target, plain text on the host.
    pub log: Vec<u8, MAX_LOG>,
    /// The node is to restart, as after power-up, with the same flash.
    pub restart: bool,
}

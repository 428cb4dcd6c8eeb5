//! Inputs and outputs of an axle's tick.

use super::{AlignmentState, SetPoint, Snapshot};
use crate::bus::pdo::{DriveMotion, DriveStatus};
use crate::faults::Faults;
use crate::motor::bridge::BridgeStop;
pub use crate::motor::current::BridgeDemand;
use crate::motor::current::Electrical;
pub use crate::motor::limits::ActiveLimit;
use crate::sensors::{Switches, Temperatures};

/// Readings and messages since the previous tick.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Wrapping counter of the rotor's encoder.
    pub encoder: i32,
    /// The board finds the rotor's sensor broken.
    pub encoder_broken: bool,
    /// What has opened the bridge without software.
    pub bridge_stop: Option<BridgeStop>,
    /// Motor current, A, mean over the tick; NaN if no sample was taken.
    pub current: f32,
    /// Further measurements of the bridge.
    pub electrical: Electrical,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Temperatures that the board measures.
    pub temperatures: Temperatures,
    /// Limit switches and home switch.
    pub switches: Switches,
    /// The newest set-point, if one came.
    pub set_point: Option<SetPoint>,
    /// The newest torque feed-forward (object 0x60B2), if one came: 0.01 N m; screw: N.
    pub torque_offset: Option<i16>,
    /// A heartbeat of the guard came.
    pub guard_received: bool,
    /// A client requests bench mode (object 0x2001).
    pub bench_mode: bool,
}

/// Outputs of an axle's tick.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Outputs {
    /// Demand to the bridge; its current never exceeds the current limit.
    pub bridge: BridgeDemand,
    /// Estimated velocity of the output shaft, rad/s.
    pub velocity: f32,
    /// Payload of TPDO 1.
    pub motion: DriveMotion,
    /// Payload of TPDO 2.
    pub status: DriveStatus,
    /// Mode in force (object 0x6061).
    pub mode: i8,
    /// Limit that acts now (object 0x2000).
    pub active_limit: ActiveLimit,
    /// Code of an emergency frame to send now; 0 is "all clear".
    pub emergency: Option<u16>,
    /// Bench mode is on (object 0x2001).
    pub bench_mode: bool,
    /// Distance between the places at which the two approaches of homing found the switch, 2^-32
    /// turn (object 0x2002).
    pub homing_difference: i32,
    /// The latched faults.
    pub faults: Faults,
    /// Output to the brake. A brake whose output is false engages.
    pub brake_released: bool,
    /// Readings at the first fault, in the tick in which it is raised (object 0x2040).
    pub snapshot: Option<Snapshot>,
    /// Heat of winding and bridge, in thousandths of what their continuous currents leave in them
    /// (objects 0x2041 and 0x2042).
    pub heat: [u16; 2],
    /// State of the rotor's alignment (object 0x2064).
    pub alignment: AlignmentState,
    /// Supply voltage, mV; 0 if it is negative or NaN (object 0x6079).
    pub supply_voltage: u32,
    /// Estimated tension of the belts of a screw, 0.1 N (object 0x2101).
    pub belt_tension: i16,
    /// Actuated switches: bit 0 negative limit, bit 1 positive limit, bit 2 home (object 0x60fd).
    pub digital_inputs: u32,
}

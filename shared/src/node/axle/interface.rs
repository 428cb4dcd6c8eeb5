//! What goes into the tick of an axle and what comes out of it.

use super::SetPoint;
use crate::bus::pdo::{DriveMotion, DriveStatus};
use crate::faults::Faults;
use crate::sensors::Switches;

/// What the node sensed and received since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Inputs {
    /// Time since power-up, us.
    pub now_us: u64,
    /// Wrapping counter of the rotor's encoder.
    pub encoder: i32,
    /// Motor current, A, mean over the tick; NaN if no sample was taken.
    pub current: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// End and home switches.
    pub switches: Switches,
    /// The newest set-point, if one came.
    pub set_point: Option<SetPoint>,
    /// The newest torque offset (object 0x60B2), if one came: 0.01 N m, screw: N.
    pub torque_offset: Option<i16>,
    /// The guard's heartbeat came.
    pub guard_received: bool,
    /// A client asks for bench mode (object 0x2001).
    pub bench_mode: bool,
}

/// What the bridge shall do until the next tick.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum BridgeDemand {
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
    pub bridge: BridgeDemand,
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
    /// The axle is not homed yet.
    NotHomed = 4,
}

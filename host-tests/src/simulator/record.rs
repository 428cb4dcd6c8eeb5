//! Record of a run: samples of the plant's ground truth and of the values published on the bus.

use crate::world::truth::{BodyPose, Strip, Truth};
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt;
use tautrack::can::Frame;
use tautrack::link::Shaft;

/// Number of samples per second of virtual time.
pub const SAMPLE_HZ: u32 = 100;

/// Sample of a run at one moment.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Sample {
    /// Virtual time, s.
    pub time_s: f64,
    /// Ground truth of the plant; no node sees it.
    pub truth: Truth,
    /// Values that any participant can decode from the bus.
    pub received: Received,
    /// Motion and load of each drive's output shaft, in the order of the nodes; absent while its
    /// node has no power.
    pub drives: Vec<Option<DriveState>>,
    /// Poses of the robot's bodies, in the order of [`crate::world::Plant::bodies`].
    pub bodies: Vec<BodyPose>,
    /// Belts of the robot as they lie.
    pub belts: Vec<Strip>,
}

/// Output shaft of a drive in the simulator's ground truth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DriveState {
    /// Angle since power-up, rad.
    pub position_rad: f64,
    /// Speed, rad/s.
    pub speed_radps: f64,
    /// Torque that the load takes from the shaft, N m.
    pub torque_nm: f64,
}

impl DriveState {
    /// Converts a shaft's motion, as its node reports it, and the torque on it, N m.
    pub fn new(shaft: &Shaft, torque_nm: f64) -> Self {
        Self {
            position_rad: shaft.position as f64 / 4_294_967_296.0 * TAU,
            speed_radps: f64::from(shaft.velocity),
            torque_nm,
        }
    }
}

/// Frame that the bus delivered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusFrame {
    /// Virtual time, us.
    pub time_us: u64,
    /// Number of the participant that sent it: nodes first, then the operator, then a client.
    pub sender: usize,
    /// The frame itself.
    pub frame: Frame,
}

/// Severity of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// The robot works as intended.
    Info,
    /// The robot continues, but something is wrong.
    Warning,
    /// A fault stops a drive or the robot.
    Error,
}

/// Event that was reported or injected during a run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Event {
    /// Severity.
    pub level: Level,
    /// The runner injected this fault; it was not reported on the bus.
    pub injected: bool,
    /// Description, one sentence.
    pub text: String,
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Values published on the bus, decoded from its frames.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Received {
    /// Forward speed that the operator commands, m/s.
    pub asked_speed: f64,
    /// Forward speed that the guard passes on, m/s.
    pub passed_speed: f64,
    /// Chassis angle that the operator commands, rad; 0 for a robot without a chassis joint.
    #[serde(skip)]
    pub asked_theta: f64,
    /// Chassis angle that the guard passes on, rad; 0 for a robot without a chassis joint.
    #[serde(skip)]
    pub passed_theta: f64,
    /// Posture that the operator commands and posture that the guard passes on, by names with the
    /// unit ([`crate::robots::Section::posture`]); empty for a robot without posture.
    pub posture: BTreeMap<&'static str, f64>,
    /// Distance travelled according to the belts' encoders, m.
    pub odometry: f64,
    /// Pitch according to the guard's attitude filter, rad.
    pub pitch: f64,
    /// Roll according to the guard's attitude filter, rad.
    pub roll: f64,
    /// Heading according to the guard, rad.
    pub heading: f64,
    /// Position according to the guard, m in the world's axes, whose origin is the guard's origin;
    /// absent until the guard accepts a GNSS fix.
    pub position: Option<[f64; 3]>,
    /// Validity of that position and of the heading: 0 invalid, 1 stale, 2 reckoned, 3 measured.
    pub validity: [u8; 4],
    /// Age of the fix on which the position is based, s; 25.5 means older, or no fix.
    pub fix_age: f64,
    /// The guard's margins to the back, front, left and right edge, m; absent while it has none.
    pub margins: Option<[f64; 4]>,
    /// State of the guard: `homing`, `ready`, `armed`, `held` and so on.
    pub guard_state: String,
    /// What the guard does with the command, and why: `passed`, `scaled: backward margin` and so
    /// on.
    pub verdict: String,
    /// Phase of the autonomous clearance; empty while the operator clears obstacles.
    pub clearance: &'static str,
    /// Cause of its newest transition.
    pub clearance_cause: &'static str,
    /// Number of obstacles that it has cleared.
    pub cleared: u8,
    /// Measured currents of the drives, in the order of the nodes, A.
    pub currents: Vec<f64>,
    /// Tension of the belts that the screw estimates, N; 0 for a robot without a screw.
    pub belt_tension: f64,
    /// Load of the bus: the fraction of the last 100 ms during which it was busy, 0 to 1.
    pub bus_load: f64,
    /// Faults and losses reported since the previous sample, one sentence each.
    pub events: Vec<Event>,
}

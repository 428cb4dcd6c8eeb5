//! Readings that a board takes for a node: the switches of an axle, temperatures, and the sensors
//! on the robot's body.

use serde::{Deserialize, Serialize};

/// Switches of one axle; `true` means actuated.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Switches {
    /// Home switch.
    pub home: bool,
    /// Limit switch at the positive end of travel.
    pub positive_limit: bool,
    /// Limit switch at the negative end of travel.
    pub negative_limit: bool,
}

/// Temperatures that a board measures, degree Celsius; `None` where it has no sensor.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Temperatures {
    /// The transistors of the bridge, or the board next to them.
    pub bridge: Option<f32>,
    /// The winding of the motor.
    pub motor: Option<f32>,
}

/// Sensor of the guard, in the order of the objects 0x2100 to 0x2102.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sensor {
    /// Inclinometer.
    Inclinometer = 0,
    /// Accelerometer of the inertial unit.
    Accelerometer = 1,
    /// Gyroscope of the inertial unit.
    Gyroscope = 2,
    /// Magnetometer of the compass.
    Magnetometer = 3,
    /// GNSS receiver.
    GnssReceiver = 4,
}

impl Sensor {
    /// All sensors, in order.
    pub const ALL: [Self; 5] = [
        Self::Inclinometer,
        Self::Accelerometer,
        Self::Gyroscope,
        Self::Magnetometer,
        Self::GnssReceiver,
    ];

    /// Name in logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inclinometer => "inclinometer",
            Self::Accelerometer => "accelerometer",
            Self::Gyroscope => "gyroscope",
            Self::Magnetometer => "magnetometer",
            Self::GnssReceiver => "GNSS receiver",
        }
    }
}

/// Sensors on the body that have measured since the previous readings. A sensor says so by its
/// data-ready flag; the readings of the others are the last ones.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[allow(clippy::struct_excessive_bools)] // independent sensors, not states
pub struct Fresh {
    /// Inclinometer.
    pub inclinometer: bool,
    /// Accelerometer.
    pub accelerometer: bool,
    /// Gyroscope.
    pub gyroscope: bool,
    /// Magnetometer.
    pub magnetometer: bool,
}

impl Fresh {
    /// Every sensor has measured.
    pub const ALL: Self = Self {
        inclinometer: true,
        accelerometer: true,
        gyroscope: true,
        magnetometer: true,
    };
    /// No sensor has measured.
    pub const NONE: Self = Self {
        inclinometer: false,
        accelerometer: false,
        gyroscope: false,
        magnetometer: false,
    };
}

/// Every sensor has measured: readings that say nothing else are new.
impl Default for Fresh {
    fn default() -> Self {
        Self::ALL
    }
}

/// Readings of inclinometer, inertial unit and magnetometer on body 1. Axes: x forward, y left, z
/// up.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct BodySensors {
    /// Inclinometer: pitch (nose up positive) and roll (left side up positive), rad: the direction
    /// of the specific force, so every reading is wrong by the acceleration.
    pub inclination: [f32; 2],
    /// Specific force in body axes, m/s^2; (0, 0, +9.81) at rest on level ground.
    pub specific_force: [f32; 3],
    /// Angular rate in body axes, rad/s.
    pub angular_rate: [f32; 3],
    /// Magnetic flux density in body axes, uT. It includes the field of the robot's own magnets
    /// (hard iron).
    pub magnetic_field: [f32; 3],
    /// Which of these readings are new.
    pub fresh: Fresh,
}

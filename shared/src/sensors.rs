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

/// Readings of inclinometer, inertial unit and magnetometer on body 1. Axes: x forward, y left, z
/// up.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct BodySensors {
    /// Inclinometer: pitch (nose up positive) and roll (left side up positive), rad. It is slow,
    /// and wrong during accelerations.
    pub inclination: [f32; 2],
    /// Specific force in body axes, m/s^2; (0, 0, +9.81) at rest on level ground.
    pub specific_force: [f32; 3],
    /// Angular rate in body axes, rad/s.
    pub angular_rate: [f32; 3],
    /// Magnetic flux density in body axes, uT, with ten new values a second. It includes the field
    /// of the robot's own magnets (hard iron).
    pub magnetic_field: [f32; 3],
}

//! What a board reads for a node: the switches of an axle and the sensors on the body.

use serde::{Deserialize, Serialize};

/// Switches of one axle; `true` is actuated.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
pub struct Switches {
    /// home switch.
    pub home: bool,
    /// End of travel in the positive direction.
    pub positive_limit: bool,
    /// End of travel in the negative direction.
    pub negative_limit: bool,
}

/// Inclinometer, inertial unit and magnetometer on body 1. Axes: x forward, y left, z up.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
pub struct BodySensors {
    /// Inclinometer: pitch (nose up positive) and roll (left side up positive), rad; slow, and it lies under acceleration.
    pub inclination: [f32; 2],
    /// Specific force in body axes, m/s^2; (0, 0, +9.81) at rest on level ground.
    pub specific_force: [f32; 3],
    /// Angular rate in body axes, rad/s.
    pub angular_rate: [f32; 3],
    /// Magnetic flux density in body axes, uT, hard iron included; a new value ten times a second.
    pub magnetic_field: [f32; 3],
}

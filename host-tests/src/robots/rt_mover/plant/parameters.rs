//! Constant model of the simulated RT-Mover. Lengths and masses are those of the library; the
//! values that only the physics needs are assumed here.

use crate::world::load::Load;
use crate::world::sensing::BodySensorParameters;
use tautrack::robots::rt_mover::parameters::{LENGTHS, Lengths, MASSES, Masses};

/// Parameters of the simulated robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RtMoverParameters {
    /// Lengths.
    pub lengths: Lengths,
    /// Masses, and the place of the seat.
    pub masses: Masses,
    /// Half the width of a wheel, m. It is small, because the kinematics assume thin wheels.
    pub wheel_half_width: f64,
    /// Coefficient of friction between wheel and ground.
    pub friction: f64,
    /// Stiffness, N m/rad, and damping, N m s/rad, of the gears of the steering, roll and pitch
    /// shafts.
    pub shaft_gear: [f64; 2],
    /// Damping of a wheel's gear, N m s/rad. It has no stiffness, because a wheel turns without
    /// limit.
    pub wheel_gear: f64,
    /// Friction of a dead wheel's gear, N m. The other gears lock themselves.
    pub dead_wheel_friction: f64,
    /// Heading at the start, rad; the middle of the body is above the origin.
    pub initial_heading: f64,
    /// Load on the seat; its place is relative to the pitch shaft, which is the middle of the body.
    pub payload: Option<Load>,
    /// Supply voltage, V.
    pub supply_voltage: f64,
    /// Quality of the sensors on the seat.
    pub body_sensors: BodySensorParameters,
}

impl RtMoverParameters {
    /// The robot with the library's lengths and masses, with the friction of rubber tyres.
    pub fn nominal() -> Self {
        Self {
            lengths: LENGTHS,
            masses: MASSES,
            wheel_half_width: 0.004,
            friction: 1.0,
            shaft_gear: [2.0e4, 100.0],
            wheel_gear: 2.0e3,
            dead_wheel_friction: 2.0,
            initial_heading: 0.0,
            payload: None,
            supply_voltage: 24.0,
            body_sensors: BodySensorParameters::NOMINAL,
        }
    }
}

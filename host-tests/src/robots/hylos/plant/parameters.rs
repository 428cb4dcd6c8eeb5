//! Constant model of the simulated Hylos: the robot's measures, which the library defines and
//! documents as assumed, and the values that only the plant needs.

use crate::world::sensing::BodySensorParameters;
use tautrack::robots::hylos::parameters::{MEASURES, Measures};

/// Parameters of the plant. All of them are assumed, except the mass.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HylosParameters {
    /// Measures of the robot. The legs have no mass; their mass is added to the wheels.
    pub measures: Measures,
    /// Radii of gyration of the platform about its axes, m.
    pub platform_gyration: [f64; 3],
    /// Mass of a wheel without its carrier, kg.
    pub tyre_mass: f64,
    /// Radius of the tyre's rounded shoulders, m.
    pub tyre_shoulder: f64,
    /// Coefficient of friction between tyres and ground.
    pub friction: f64,
    /// Stiffness and damping of a leg at its wheel, N/m and N s/m.
    pub leg_gear: [f64; 2],
    /// Stiffness and damping of the steering's gear, N m/rad and N m s/rad.
    pub steering_gear: [f64; 2],
    /// Damping of the wheel's gear, N m s/rad. It is so high that the wheel follows its shaft.
    pub wheel_gear: f64,
    /// Coulomb friction of a dead steering and of a dead wheel, N m. A dead leg locks itself,
    /// because screws move its joints.
    pub dead_friction: [f64; 2],
    /// Angles of hip and knee of every leg at power-up, rad.
    pub initial_leg: [f64; 2],
    /// Place at power-up (x and y), m, and heading, rad.
    pub start: [f64; 3],
    /// Supply voltage, V.
    pub supply_voltage: f64,
    /// Parameters of the sensors on the platform.
    pub body_sensors: BodySensorParameters,
}

impl HylosParameters {
    /// The model of Hylos that the published results use, at this place (m) and heading (rad).
    pub fn nominal(start: [f64; 3]) -> Self {
        Self {
            measures: MEASURES,
            platform_gyration: [0.12, 0.18, 0.20],
            tyre_mass: 0.7,
            tyre_shoulder: 0.02,
            friction: 1.2,
            leg_gear: [3.0e4, 600.0],
            steering_gear: [400.0, 8.0],
            wheel_gear: 100.0,
            dead_friction: [2.0, 1.0],
            initial_leg: [0.4678, 1.1456],
            start,
            supply_voltage: 24.0,
            body_sensors: BodySensorParameters {
                accelerometer_place: [0.0, 0.0, 0.05],
                ..BodySensorParameters::NOMINAL
            },
        }
    }

    /// Position of a wheel's centre relative to its hip, forward and down, m, at these angles of
    /// hip and knee (rad).
    pub fn reach(&self, [hip, knee]: [f64; 2]) -> [f64; 2] {
        let [thigh, shank] = self.measures.leg;
        [
            thigh * libm::cos(hip) + shank * libm::cos(hip + knee),
            thigh * libm::sin(hip) + shank * libm::sin(hip + knee),
        ]
    }

    /// Angles of hip and knee (rad) for a position of a wheel's centre: the inverse of
    /// [`Self::reach`] for knees that bend downward.
    pub fn joints(&self, [forward, down]: [f64; 2]) -> [f64; 2] {
        let [thigh, shank] = self.measures.leg;
        let square = forward * forward + down * down;
        let cosine = (square - thigh * thigh - shank * shank) / (2.0 * thigh * shank);
        let knee = libm::acos(cosine.clamp(-1.0, 1.0));
        let inner = libm::atan2(shank * libm::sin(knee), thigh + shank * libm::cos(knee));
        [libm::atan2(down, forward) - inner, knee]
    }
}

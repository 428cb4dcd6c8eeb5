//! The constant model of the simulated Hylos: its measures, which the library names and calls assumed, and what only a plant needs.

use crate::world::sensing::BodySensorParameters;
use tautrack::robots::hylos::parameters::{MEASURES, Measures};

/// Constant model of the plant. All of it is assumed, but for the mass.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct HylosParameters {
    /// Measures of the robot. The wheels carry the mass of their massless legs.
    pub measures: Measures,
    /// Gyration radii of the platform about its axes, m.
    pub platform_gyration: [f64; 3],
    /// Mass of a wheel without its carrier, kg.
    pub tyre_mass: f64,
    /// Radius of the tyre's rounded shoulders, m.
    pub tyre_shoulder: f64,
    /// Friction of tyres on the ground.
    pub friction: f64,
    /// Stiffness and damping of a leg at its wheel, N/m and N s/m.
    pub leg_gear: [f64; 2],
    /// Stiffness and damping of the steering's gear, N m/rad and N m s/rad.
    pub steering_gear: [f64; 2],
    /// Damping of the wheel's gear, N m s/rad: so stiff that the wheel does what its shaft does.
    pub wheel_gear: f64,
    /// Coulomb friction of a dead steering and of a dead wheel, N m. A dead leg locks itself: its joints are moved by screws.
    pub dead_friction: [f64; 2],
    /// Hip and knee of every leg at power-up, rad.
    pub initial_leg: [f64; 2],
    /// Place at power-up, m, and heading, rad.
    pub start: [f64; 3],
    /// Supply voltage, V.
    pub supply_voltage: f64,
    /// Sensors on the platform.
    pub body_sensors: BodySensorParameters,
}

impl HylosParameters {
    /// The stand-in for Hylos that results are shown with, at this place (m) and heading (rad).
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

    /// Centre of a wheel before its hip and below it, m, at these angles of hip and knee.
    pub fn reach(&self, [hip, knee]: [f64; 2]) -> [f64; 2] {
        let [thigh, shank] = self.measures.leg;
        [
            thigh * libm::cos(hip) + shank * libm::cos(hip + knee),
            thigh * libm::sin(hip) + shank * libm::sin(hip + knee),
        ]
    }

    /// Hip and knee that put a wheel's centre there: the inverse of [`Self::reach`] for knees that bend downward.
    pub fn joints(&self, [forward, down]: [f64; 2]) -> [f64; 2] {
        let [thigh, shank] = self.measures.leg;
        let square = forward * forward + down * down;
        let cosine = (square - thigh * thigh - shank * shank) / (2.0 * thigh * shank);
        let knee = libm::acos(cosine.clamp(-1.0, 1.0));
        let inner = libm::atan2(shank * libm::sin(knee), thigh + shank * libm::cos(knee));
        [libm::atan2(down, forward) - inner, knee]
    }
}

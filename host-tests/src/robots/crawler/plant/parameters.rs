//! Constant model of the crawler: the values that Kurc and Szybicki give, and assumed ones.

use crate::world::gnss::ReceiverParameters;
use crate::world::load::Load;
use crate::world::sensing::BodySensorParameters;

/// Parameters of the simulated crawler.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct CrawlerParameters {
    /// Radius of the sprockets with their belt, m (the paper's r).
    pub sprocket_radius: f64,
    /// Turns of a motor per turn of its sprocket (the paper's 500:7).
    pub gear_ratio: f64,
    /// Distance between the centre lines of the tracks, m (the paper's H).
    pub track_spacing: f64,
    /// Length of a belt's run on the ground, m (the paper's L).
    pub contact_length: f64,
    /// Width of a track, m; assumed.
    pub track_width: f64,
    /// Mass without payload, kg; assumed.
    pub mass: f64,
    /// Centre of gravity from the middle between the belts' ground runs: forward, left, up, m;
    /// assumed.
    pub cog: [f64; 3],
    /// Length, width and height of the box that has the body's inertia, m; assumed.
    pub extent: [f64; 3],
    /// The ground's shear behaviour.
    pub soil: Soil,
    /// Stiffness, N/m, and damping, N s/m, of the ground under both ground runs together; assumed.
    pub bearing: [f64; 2],
    /// Damping of the ground's shear over both ground runs together, N s/m; no effect on a track
    /// that runs steadily. Assumed.
    pub shear_damping: f64,
    /// Inertia of a track's rotor at its sprocket, kg m^2. The belt must move it if the node is
    /// dead.
    pub track_inertia: f64,
    /// Friction of a dead track's gear at the sprocket, N m.
    pub dead_track_friction: f64,
    /// Load that is put on the body during the run; its place is relative to the middle between the
    /// belts' ground runs.
    pub payload: Option<Load>,
    /// Heading at the start, rad, and distance to the left of the x axis, m.
    pub initial_heading_and_y: [f64; 2],
    /// Supply voltage, V. It is constant, because the plant does not know the currents.
    pub supply_voltage: f64,
    /// Quality of the sensors on the body.
    pub body_sensors: BodySensorParameters,
    /// Quality of the GNSS receiver.
    pub receiver: ReceiverParameters,
}

/// Soil with the shear behaviour that Bekker and Kacigin describe (the paper's eq. 5 and 6).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Soil {
    /// Cohesion, Pa.
    pub cohesion: f64,
    /// Angle of internal friction, rad.
    pub friction_angle: f64,
    /// Parameter `K1` of eq. 6, 1/m.
    pub k1: f64,
    /// Parameter `K2` of eq. 6, at least 1.
    pub k2: f64,
}

impl Soil {
    /// Loose soil on which the robot slips by 0.11 on the paper's slope of 20 degrees; assumed.
    pub fn nominal() -> Self {
        Self {
            cohesion: 1_000.0,
            friction_angle: 25.0_f64.to_radians(),
            k1: 40.2,
            k2: 1.0,
        }
    }

    /// Firm ground: stiff, and strong enough that the robot tips over before it slides.
    pub fn firm() -> Self {
        Self {
            cohesion: 10_000.0,
            friction_angle: 35.0_f64.to_radians(),
            k1: 200.0,
            k2: 1.0,
        }
    }

    /// Returns the soil with its cohesion and friction coefficient multiplied by `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            cohesion: self.cohesion * factor,
            friction_angle: libm::atan(factor * libm::tan(self.friction_angle)),
            ..*self
        }
    }

    /// Deformation at which the shear stress is largest, m.
    pub fn deformation_of_peak(&self) -> f64 {
        let root = libm::sqrt(self.k2 * self.k2 - 1.0);
        let u = if root > 1e-4 {
            libm::log(self.k2 + root) / root
        } else {
            1.0
        };
        u / self.k1
    }

    /// Shear stress, Pa, under `pressure` (Pa) at a deformation (m, not negative): eq. 6 as
    /// printed, and its limit at `K2 = 1`.
    pub fn shear_stress(&self, pressure: f64, deformation: f64) -> f64 {
        let strength = self.cohesion + pressure * libm::tan(self.friction_angle);
        let u = self.k1 * deformation;
        let root = libm::sqrt(self.k2 * self.k2 - 1.0);
        // Closer to `K2 = 1`, rounding makes the quotient less accurate than its limit.
        if !(root > 1e-4) {
            return strength * u * libm::exp(1.0 - u);
        }
        let maximum = 2.0 * root * libm::pow(self.k2 + root, -self.k2 / root);
        let numerator = libm::exp((root - self.k2) * u) - libm::exp(-(root + self.k2) * u);
        strength * numerator / maximum
    }
}

impl CrawlerParameters {
    /// The model of the paper's robot that the published results use.
    pub fn nominal() -> Self {
        Self {
            sprocket_radius: 0.027_94,
            gear_ratio: 500.0 / 7.0,
            track_spacing: 0.145,
            contact_length: 0.127,
            track_width: 0.04,
            mass: 5.0,
            cog: [0.0, 0.0, 0.045],
            extent: [0.20, 0.19, 0.08],
            soil: Soil::nominal(),
            bearing: [2.0e6, 2.0e3],
            shear_damping: 100.0,
            track_inertia: 0.05,
            dead_track_friction: 0.4,
            payload: None,
            initial_heading_and_y: [0.0; 2],
            supply_voltage: 24.0,
            body_sensors: BodySensorParameters {
                accelerometer_place: [0.0, 0.0, 0.05],
                ..BodySensorParameters::NOMINAL
            },
            receiver: ReceiverParameters {
                antenna: [0.0, 0.0, 0.10],
                speed: 0.02,
                ..ReceiverParameters::NOMINAL
            },
        }
    }
}

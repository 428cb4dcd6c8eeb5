//! Defines masses, lengths and ranges of Hylos. Besseron et al. give 25 kg, sixteen motors and the
//! limit of the margin. Everything else is assumed, in this file only.

use crate::constants::GRAVITY_F64;
use crate::math::Scalar;
use crate::math::vector::Vector;
use core::f64::consts::FRAC_PI_2;

/// Dimensions and masses of the robot in SI units.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Measures {
    /// Distances of the hips from the middle of the platform, forward and to the side, m. Assumed.
    pub hip: [f64; 2],
    /// Distance of a wheel outside its hip, m. Assumed.
    pub wheel_offset: f64,
    /// Lengths of thigh and shank, m. Assumed.
    pub leg: [f64; 2],
    /// Radius of the wheels, m. Assumed.
    pub wheel_radius: f64,
    /// Mass of the platform, kg. Assumed: the paper's 25 kg without the wheels.
    pub platform_mass: f64,
    /// Centre of mass of the platform, m from the middle of its hips. Assumed.
    pub platform_com: [f64; 3],
    /// Mass of a wheel with its leg, kg, taken to be in the wheel's centre. Assumed.
    pub wheel_mass: f64,
    /// Gravity, m/s^2.
    pub gravity: f64,
}

/// Values of the simulated robot.
pub const MEASURES: Measures = Measures {
    hip: [0.20, 0.15],
    wheel_offset: 0.10,
    leg: [0.20, 0.20],
    wheel_radius: 0.075,
    platform_mass: 17.0,
    platform_com: [0.0, 0.0, 0.05],
    wheel_mass: 2.0,
    gravity: GRAVITY_F64,
};

/// Range of the hips, rad: from the thigh a little above the platform's plane to almost straight
/// down. Assumed.
pub const HIP_RANGE: [f64; 2] = [-0.3, 1.4];
/// Range of the knees, rad. Assumed. It excludes the straight and the folded leg, which can push in
/// one direction only.
pub const KNEE_RANGE: [f64; 2] = [0.35, 2.4];
/// Range of the steering, rad. Assumed: a wheel can stand across the robot, to turn it on the spot.
pub const STEERING_RANGE: [f64; 2] = [-FRAC_PI_2, FRAC_PI_2];
/// Distance of the wheels' centres in front of (or behind) their hips in the nominal stance, m.
/// Assumed.
pub const STANCE_REACH: f64 = 0.17;
/// Distance of the wheels' centres below their hips in the nominal stance, m. Assumed.
pub const STANCE_HEIGHT: f64 = 0.29;
/// Tip-over angle `nu*` below which the posture is corrected, rad (Besseron et al., section V).
pub const MARGIN_LIMIT: f64 = 0.35;
/// Gain `k_stab` of the potential, rad^2/s. Assumed: at half the limit the legs move at about
/// 0.3 rad/s.
pub const POTENTIAL_GAIN: f64 = 0.004;
/// Tip-over angle below which the potential continues as a straight line, rad. Assumed. The printed
/// potential is infinite at zero.
pub const MARGIN_FLOOR: f64 = 0.02;

/// Why values do not describe a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ParametersError {
    /// A length, mass or gravity is not above zero, or not finite.
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// Value that was given.
        got: f64,
    },
    /// The centre of mass is not finite.
    NotFinite {
        /// Value that was given, m.
        platform_com: [f64; 3],
    },
}

/// Constants of the model, checked once at creation, so that no other code has to check them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters<S> {
    pub(super) hip_x: S,
    /// Distance of the wheels from the middle of the robot to the side.
    pub(super) half_track: S,
    pub(super) leg: [S; 2],
    pub(super) wheel_radius: S,
    pub(super) mass: S,
    pub(super) gravity: S,
    /// Part of the centre of gravity that comes from the platform: its first moment over the total
    /// mass.
    pub(super) platform_part: Vector<S>,
    /// Mass of a wheel over the total mass.
    pub(super) wheel_share: S,
}

impl<S: Scalar> Parameters<S> {
    /// The simulated robot: [`MEASURES`].
    pub fn nominal() -> Self {
        Self::prepare(&MEASURES)
    }

    /// Creates a robot of this kind with other measures. For start-up.
    ///
    /// # Errors
    /// The first value that no robot can have.
    pub fn new(measures: &Measures) -> Result<Self, ParametersError> {
        let m = measures;
        for (name, got) in [
            ("hip x", m.hip[0]),
            ("hip y", m.hip[1]),
            ("wheel offset", m.wheel_offset),
            ("thigh", m.leg[0]),
            ("shank", m.leg[1]),
            ("wheel radius", m.wheel_radius),
            ("platform mass", m.platform_mass),
            ("wheel mass", m.wheel_mass),
            ("gravity", m.gravity),
        ] {
            if !(got > 0.0 && got.is_finite()) {
                return Err(ParametersError::NotPositive { name, got });
            }
        }
        let platform_com = m.platform_com;
        if !platform_com.iter().all(|value| value.is_finite()) {
            return Err(ParametersError::NotFinite { platform_com });
        }
        Ok(Self::prepare(m))
    }

    /// Mass of the whole robot, kg.
    pub fn mass(&self) -> S {
        self.mass
    }

    /// Distance of a wheel from the middle of the robot when the wheel is below its hip, m.
    pub fn reach(&self) -> S {
        (self.hip_x * self.hip_x + self.half_track * self.half_track).sqrt()
    }

    /// Radius of the wheels, m.
    pub fn wheel_radius(&self) -> S {
        self.wheel_radius
    }

    fn prepare(m: &Measures) -> Self {
        let mass = m.platform_mass + 4.0 * m.wheel_mass;
        Self {
            hip_x: S::from_f64(m.hip[0]),
            half_track: S::from_f64(m.hip[1] + m.wheel_offset),
            leg: m.leg.map(S::from_f64),
            wheel_radius: S::from_f64(m.wheel_radius),
            mass: S::from_f64(mass),
            gravity: S::from_f64(m.gravity),
            platform_part: m
                .platform_com
                .map(|value| S::from_f64(value * m.platform_mass / mass)),
            wheel_share: S::from_f64(m.wheel_mass / mass),
        }
    }
}

//! Defines lengths and masses of RT-Mover. Nakajima's paper on the step-up gait gives none of them,
//! so each one has its source here.

use crate::math::Scalar;

/// Distance `LB` between the two steering shafts, m. From the smallest turning radius of 0.52 m at
/// 30 degrees that Nakajima publishes elsewhere.
pub const BODY_LENGTH: f64 = 0.60;
/// Distance `LA` from a wheel's middle to its steering shaft, m. From the published overall size,
/// 0.80 m by 0.63 m.
pub const HALF_ARM: f64 = 0.30;
/// Distance `Lr` from an arm's roll axis down to the axle of the wheels, m. Assumed.
pub const ARM_DROP: f64 = 0.05;
/// Radius `R` of a wheel, m. From the same overall size.
pub const WHEEL_RADIUS: f64 = 0.10;
/// Limit of both steering shafts, rad: the paper's 30 degrees.
pub const STEERING_LIMIT: f64 = core::f64::consts::FRAC_PI_6;
/// Masses of the parts, which add up to the published 28 kg, and position of the seat relative to
/// the pitch shaft, m. All assumed.
pub const MASSES: Masses = Masses {
    body: 8.0,
    seat: 8.0,
    seat_height: 0.10,
    seat_forward: 0.04,
    arm: 2.0,
    wheel: 2.0,
};

/// Masses and their positions: the body's mass is at its middle, the seat's above the pitch shaft,
/// an arm's at its roll shaft, a wheel's at its hub.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Masses {
    /// Body without arms and wheels, kg.
    pub body: f64,
    /// Seat with its load, kg.
    pub seat: f64,
    /// Height of the seat's centre of mass above the pitch shaft, m.
    pub seat_height: f64,
    /// Distance of the seat's centre of mass in front of the pitch shaft, m. When the rear wheels
    /// step up, the front stands higher, which moves the centre of gravity back relative to its
    /// supports. This distance compensates that.
    pub seat_forward: f64,
    /// One arm without its wheels, kg.
    pub arm: f64,
    /// One wheel with its motor, kg.
    pub wheel: f64,
}

impl Masses {
    /// Mass of the whole robot, kg.
    pub fn total(&self) -> f64 {
        self.body + self.seat + 2.0 * self.arm + 4.0 * self.wheel
    }
}

/// Lengths, m, and the steering limit, rad.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Lengths {
    /// `LB`: [`BODY_LENGTH`].
    pub body: f64,
    /// `LA`: [`HALF_ARM`].
    pub half_arm: f64,
    /// `Lr`: [`ARM_DROP`].
    pub arm_drop: f64,
    /// `R`: [`WHEEL_RADIUS`].
    pub wheel_radius: f64,
    /// [`STEERING_LIMIT`].
    pub steering_limit: f64,
}

/// Lengths with the values above.
pub const LENGTHS: Lengths = Lengths {
    body: BODY_LENGTH,
    half_arm: HALF_ARM,
    arm_drop: ARM_DROP,
    wheel_radius: WHEEL_RADIUS,
    steering_limit: STEERING_LIMIT,
};

/// Why values do not describe a robot.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum ParametersError {
    /// A length or mass is not above zero (arm drop, seat: is negative), or not finite.
    OutOfRange {
        /// Name of the value.
        name: &'static str,
        /// Value that was given.
        got: f64,
    },
    /// The steering limit is not between zero and 80 degrees. Below 80 degrees the centre of a turn
    /// lies outside the arms' reach.
    SteeringLimit {
        /// Value that was given, rad.
        got: f64,
    },
}

/// Constants of the model, checked once at creation, so that no other code has to check them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Parameters<S> {
    /// `LB`, m.
    pub body_length: S,
    /// `LA`, m.
    pub half_arm: S,
    /// `Lr`, m.
    pub arm_drop: S,
    /// `R`, m.
    pub wheel_radius: S,
    /// Limit of the steering shafts, rad.
    pub steering_limit: S,
    /// Mass of one axle's two wheels over the total mass: the part of their motion that the centre
    /// of gravity follows.
    pub(super) wheel_share: S,
    /// Part of the centre of gravity without what hangs below the roll shafts: in front of and
    /// above the body's middle, m.
    pub(super) cog: [S; 2],
}

impl<S: Scalar> Parameters<S> {
    /// Robot with the values of this file.
    pub fn nominal() -> Self {
        Self::prepare(&LENGTHS, &MASSES)
    }

    /// Creates a robot of this kind with other values.
    ///
    /// # Errors
    /// The first value that no robot can have.
    pub fn new(lengths: &Lengths, masses: &Masses) -> Result<Self, ParametersError> {
        for (name, got, least_is_allowed) in [
            ("body length", lengths.body, false),
            ("half arm", lengths.half_arm, false),
            ("arm drop", lengths.arm_drop, true),
            ("wheel radius", lengths.wheel_radius, false),
            ("body mass", masses.body, false),
            ("seat mass", masses.seat, false),
            ("seat height", masses.seat_height, true),
            ("seat forward", masses.seat_forward, true),
            ("arm mass", masses.arm, false),
            ("wheel mass", masses.wheel, false),
        ] {
            if !(got.is_finite() && (got > 0.0 || (least_is_allowed && got == 0.0))) {
                return Err(ParametersError::OutOfRange { name, got });
            }
        }
        let got = lengths.steering_limit;
        if !(got > 0.0 && got < 80.0_f64.to_radians()) {
            return Err(ParametersError::SteeringLimit { got });
        }
        Ok(Self::prepare(lengths, masses))
    }

    fn prepare(lengths: &Lengths, masses: &Masses) -> Self {
        let per_mass = 1.0 / masses.total();
        Self {
            body_length: S::from_f64(lengths.body),
            half_arm: S::from_f64(lengths.half_arm),
            arm_drop: S::from_f64(lengths.arm_drop),
            wheel_radius: S::from_f64(lengths.wheel_radius),
            steering_limit: S::from_f64(lengths.steering_limit),
            wheel_share: S::from_f64(2.0 * masses.wheel * per_mass),
            cog: [masses.seat_forward, masses.seat_height]
                .map(|place| S::from_f64(masses.seat * place * per_mass)),
        }
    }
}

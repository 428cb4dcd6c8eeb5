//! Lengths and masses. Nakajima's paper on the step-up gait gives none of them: every one is named here, with where it is from.

use crate::math::Scalar;

/// Distance `LB` of the two steering shafts, m. From the smallest turning radius of 0.52 m at 30 degrees that Nakajima publishes elsewhere.
pub const BODY_LENGTH: f64 = 0.60;
/// Distance `LA` of a wheel's middle from its steering shaft, m. From the published overall size, 0.80 m by 0.63 m.
pub const HALF_ARM: f64 = 0.30;
/// Distance `Lr` from an arm's roll axis down to the wheels' axle, m. Assumed.
pub const ARM_DROP: f64 = 0.05;
/// Radius `R` of a wheel, m. From the same overall size.
pub const WHEEL_RADIUS: f64 = 0.10;
/// Limit of either steering shaft, rad: the paper's 30 degrees.
pub const STEERING_LIMIT: f64 = core::f64::consts::FRAC_PI_6;
/// Share of each part in the published 28 kg, kg, and where the seat is from the pitch shaft, m. All assumed.
pub const MASSES: Masses = Masses {
    body: 8.0,
    seat: 8.0,
    seat_height: 0.10,
    seat_forward: 0.04,
    arm: 2.0,
    wheel: 2.0,
};

/// Where the mass is: body at its middle, seat over the pitch shaft, an arm at its roll shaft, a wheel at its hub.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Masses {
    /// Body without arms and wheels, kg.
    pub body: f64,
    /// Seat with its load, kg.
    pub seat: f64,
    /// Height of the seat's centre of mass over the pitch shaft, m.
    pub seat_height: f64,
    /// Distance of the same in front of the pitch shaft, m. The rear wheels step up with the front higher than they are, which moves the centre of
    /// gravity back over its supports; this gives it back.
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

/// The values above.
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
        /// Which one.
        name: &'static str,
        /// What was given.
        got: f64,
    },
    /// The steering limit is not above zero and below 80 degrees, where a turn's centre still lies outside the arms' reach.
    SteeringLimit {
        /// What was given, rad.
        got: f64,
    },
}

/// The constant model: checked once, so that nothing that follows checks again.
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
    /// Share of one axle's two wheels in the whole mass: what the centre of gravity follows them by.
    pub(super) wheel_share: S,
    /// Centre of gravity without what hangs below the roll shafts: in front of and over the body's middle, m.
    pub(super) cog: [S; 2],
}

impl<S: Scalar> Parameters<S> {
    /// The robot of this file.
    pub fn nominal() -> Self {
        Self::prepare(&LENGTHS, &MASSES)
    }

    /// A robot of this kind with other values.
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

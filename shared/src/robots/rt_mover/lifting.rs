//! Implements the paper's laws of lifting, landing and swinging a wheel (Nakajima, eq. 3 to 12),
//! with signs and corrections.
//!
//! All quantities are seen from above. `leg` is the arm of the lifted wheel, `sup` the other one.
//! `phi = theta_leg + theta_B` is the direction of the leg arm relative to the axes of travel; the
//! robot travels along y. The other wheel of the leg arm stays where it is.

use crate::math::Scalar;

/// Smallest cosine and length by which anything is divided.
const LEAST: f64 = 1e-3;

fn sign<S: Scalar>(support_left: bool) -> S {
    if support_left { S::ONE } else { -S::ONE }
}

/// Direction of an arm to first order, rad (eq. 7). The exact one is
/// [`super::wheel::Arm::heading`]; in the robot's range, the first order deviates by 0.06 to
/// 0.4 degrees.
pub fn leg_angle<S: Scalar>(pitch: S, steering: S, roll: S) -> S {
    let (sine, cosine) = pitch.sin_cos();
    steering * cosine + roll * sine
}

/// Angles of an arm with the pitch of the body, rad, or their rates, rad/s.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArmAngles<S> {
    /// Pitch of the body.
    pub pitch: S,
    /// Steering shaft; ignored in rates.
    pub steering: S,
    /// Roll shaft.
    pub roll: S,
}

/// Rate of the steering shaft at which the arm's direction seen from above changes at `leg_rate`,
/// rad/s (eq. 8). Zero for an upright body.
pub fn steering_rate<S: Scalar>(leg_rate: S, angles: &ArmAngles<S>, rates: &ArmAngles<S>) -> S {
    let (sine, cosine) = angles.pitch.sin_cos();
    if !(cosine > S::from_f64(LEAST)) {
        return S::ZERO;
    }
    let turned = angles.steering * sine - angles.roll * cosine;
    (leg_rate - rates.roll * sine + rates.pitch * turned) / cosine
}

/// Motion of the leg arm's middle `P_P`.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LegMotion<S> {
    /// Velocity of `P_P` along the axes of travel, m/s.
    pub velocity: [S; 2],
    /// Rate of `phi`, rad/s.
    pub turning: S,
}

/// Motion in lifting and landing: the wheel keeps its y while the arm's half width changes from
/// `before` to `after` (m) within `period`, s (eq. 3 to 6).
///
/// Eq. 6 is printed as a sum of the two angles, but it is their difference. If the arm becomes
/// shorter than the distance by which the wheel is ahead, the wheel cannot keep its y, and it comes
/// as near as it can. Without a period, or with an arm that is turned by a quarter turn or more,
/// there is no motion.
pub fn lift_step<S: Scalar>(
    before: S,
    after: S,
    phi: S,
    period: S,
    support_left: bool,
) -> LegMotion<S> {
    let two = S::from_f64(2.0);
    let (sine, cosine) = phi.sin_cos();
    let stopped = LegMotion {
        velocity: [S::ZERO; 2],
        turning: S::ZERO,
    };
    // Position of the lifted wheel with the supporting wheel at the origin, mirrored so that the
    // lifted wheel is to the right.
    let (x, y) = (two * before * cosine, two * before * sine);
    if !(period > S::ZERO && x > S::from_f64(LEAST)) {
        return stopped;
    }
    let square = S::from_f64(4.0) * after * after - y * y;
    let (next, way) = if square > S::ZERO {
        let next = square.sqrt();
        // The difference of the squares follows from that of the half widths, so that the effect of
        // a small step is not lost in rounding.
        let squares = S::from_f64(4.0) * (after - before) * (after + before);
        (next, squares / (next + x))
    } else {
        (S::ZERO, -x)
    };
    LegMotion {
        velocity: [sign::<S>(support_left) * way / (two * period), S::ZERO],
        turning: (-(y * way)).atan2(x * next + y * y) / period,
    }
}

/// Motion in swinging: `P_P` circles the supporting wheel at `turning`, rad/s, counter-clockwise
/// (eq. 12, which is printed for that direction only).
pub fn swing<S: Scalar>(half_width: S, phi: S, turning: S, support_left: bool) -> LegMotion<S> {
    let (sine, cosine) = phi.sin_cos();
    let speed = sign::<S>(support_left) * half_width * turning;
    LegMotion {
        velocity: [-(speed * sine), speed * cosine],
        turning,
    }
}

/// Projected body from the supporting axle's middle `P_Q` to `P_P`, in body axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ProjectedBody<S> {
    /// Position of `P_P` relative to `P_Q` along the body, `B`, m; negative if the leg arm is the
    /// rear one.
    pub length: S,
    /// Rate of `length`, m/s.
    pub length_rate: S,
    /// Position of `P_P` relative to `P_Q` to the right, m.
    pub offset: S,
    /// Rate of `offset`, m/s.
    pub offset_rate: S,
}

/// Supporting axle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SupportAxle<S> {
    /// Direction of the axle relative to the body, seen from above, `theta_sup`, rad.
    pub heading: S,
    /// Rate of `heading`, rad/s.
    pub heading_rate: S,
    /// Half width `A_r`, m.
    pub half_width: S,
}

/// Motion of the supporting axle's wheels and of the body.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AxleMotion<S> {
    /// Speeds of the left and the right wheel of the axle, m/s.
    pub wheels: [S; 2],
    /// Rate of rotation of the body, `theta_B`, rad/s.
    pub turning: S,
}

/// Speeds of the supporting axle's wheels that give `P_P` the velocity `velocity`, m/s in body axes
/// (eq. 9 to 11).
///
/// The printed equations have three errors:
///
/// * They use magnitudes, which lose the direction.
/// * They add the rate of `B` to the wheels' speeds. It must be subtracted from the motion that the
///   wheels produce.
/// * They omit the sideways motion of `P_P` on the body when the arm rolls, about
///   `(Lr + R) sin(roll)`. This is the largest error of the paper's law.
///
/// Here `V_P - (offset_rate, B_rate)` is the motion that the rigid body must have, with the
/// supporting axle's middle rolling along its heading. Nothing moves if the body has no length or
/// the axle lies along it.
pub fn support_axle<S: Scalar>(
    velocity: [S; 2],
    body: &ProjectedBody<S>,
    axle: &SupportAxle<S>,
) -> AxleMotion<S> {
    let (sine, cosine) = axle.heading.sin_cos();
    let least = S::from_f64(LEAST);
    let tiny = |value: S| !(value > least || value < -least);
    let stopped = AxleMotion {
        wheels: [S::ZERO; 2],
        turning: S::ZERO,
    };
    if tiny(body.length) {
        return stopped;
    }
    let slope = body.offset / body.length;
    let along = cosine - slope * sine;
    if tiny(along) {
        return stopped;
    }
    let sideways = velocity[0] - body.offset_rate;
    let middle = (velocity[1] - body.length_rate + slope * sideways) / along;
    let turning = -(sideways + middle * sine) / body.length;
    AxleMotion {
        wheels: wheel_speeds(middle, turning, axle),
        turning,
    }
}

/// Eq. 9 to 11 with the rate of `B` as printed and without the sideways motion of `P_P`, for
/// comparison.
pub fn support_axle_as_printed<S: Scalar>(
    velocity: [S; 2],
    body: &ProjectedBody<S>,
    axle: &SupportAxle<S>,
) -> AxleMotion<S> {
    let rigid = ProjectedBody {
        length_rate: S::ZERO,
        offset: S::ZERO,
        offset_rate: S::ZERO,
        ..*body
    };
    let least = S::from_f64(LEAST);
    let moved = support_axle(velocity, &rigid, axle);
    if !(body.length > least || body.length < -least) {
        return moved;
    }
    let half = S::from_f64(0.5);
    // The sign holds for a leg arm in front; behind, the body lengthens in the other direction.
    let growth = if body.length < S::ZERO {
        -body.length_rate
    } else {
        body.length_rate
    };
    let middle = half * (moved.wheels[0] + moved.wheels[1]) + growth;
    let (sine, _) = axle.heading.sin_cos();
    let turning = -(velocity[0] + middle * sine) / body.length;
    AxleMotion {
        wheels: wheel_speeds(middle, turning, axle),
        turning,
    }
}

fn wheel_speeds<S: Scalar>(middle: S, turning: S, axle: &SupportAxle<S>) -> [S; 2] {
    let around = axle.half_width * (turning + axle.heading_rate);
    [middle - around, middle + around]
}

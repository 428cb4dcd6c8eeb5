//! The paper's laws of lifting, landing and swinging a wheel (Nakajima, eq. 3 to 12), signed and corrected.
//!
//! All are seen from above. `leg` is the arm of the lifted wheel, `sup` the other one; `phi = theta_leg + theta_B` is the leg arm's direction against the
//! axes in which the robot travels along y. The other wheel of the leg arm stays where it is.

use crate::math::Scalar;

/// Smallest cosine and length that anything is divided by.
const LEAST: f64 = 1e-3;

fn sign<S: Scalar>(support_left: bool) -> S {
    if support_left { S::ONE } else { -S::ONE }
}

/// Direction of an arm to first order, rad (eq. 7). Exact is [`super::wheel::Arm::heading`]; in the robot's range this is 0.06 to 0.4 degrees off.
pub fn leg_angle<S: Scalar>(pitch: S, steering: S, roll: S) -> S {
    let (sine, cosine) = pitch.sin_cos();
    steering * cosine + roll * sine
}

/// An arm's angles, rad, or rates, rad/s, with those of the body's pitch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ArmAngles<S> {
    /// Pitch of the body.
    pub pitch: S,
    /// Steering shaft; of rates, ignored.
    pub steering: S,
    /// Roll shaft.
    pub roll: S,
}

/// Rate of the steering shaft at which the arm's direction from above changes at `leg_rate`, rad/s (eq. 8). Zero for an upright body.
pub fn steering_rate<S: Scalar>(leg_rate: S, angles: &ArmAngles<S>, rates: &ArmAngles<S>) -> S {
    let (sine, cosine) = angles.pitch.sin_cos();
    if !(cosine > S::from_f64(LEAST)) {
        return S::ZERO;
    }
    let turned = angles.steering * sine - angles.roll * cosine;
    (leg_rate - rates.roll * sine + rates.pitch * turned) / cosine
}

/// What the leg arm's middle `P_P` does.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct LegMotion<S> {
    /// Velocity of `P_P` along the axes of travel, m/s.
    pub velocity: [S; 2],
    /// Rate of `phi`, rad/s.
    pub turning: S,
}

/// Lifting and landing: the wheel keeps its y while the arm's half width goes from `before` to `after` within `period`, m and s (eq. 3 to 6).
///
/// Eq. 6 is printed as a sum of the two angles; it is their difference. If the arm grows shorter than the wheel is ahead, the wheel cannot keep its y: it
/// goes as near as it can. No period, or an arm a quarter turn and more from across: no motion.
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
    // Both ends with the supporting wheel at the origin, mirrored so that the lifted wheel is to its right.
    let (x, y) = (two * before * cosine, two * before * sine);
    if !(period > S::ZERO && x > S::from_f64(LEAST)) {
        return stopped;
    }
    let square = S::from_f64(4.0) * after * after - y * y;
    let (next, way) = if square > S::ZERO {
        let next = square.sqrt();
        // The difference of the squares is that of the half widths': what small steps change does not drown in rounding.
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

/// Swinging: `P_P` goes round the supporting wheel at `turning`, rad/s, counter-clockwise (eq. 12, which is printed for that direction only).
pub fn swing<S: Scalar>(half_width: S, phi: S, turning: S, support_left: bool) -> LegMotion<S> {
    let (sine, cosine) = phi.sin_cos();
    let speed = sign::<S>(support_left) * half_width * turning;
    LegMotion {
        velocity: [-(speed * sine), speed * cosine],
        turning,
    }
}

/// The projected body between the supporting axle's middle `P_Q` and `P_P`, in body axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct ProjectedBody<S> {
    /// `P_P` from `P_Q` along the body, `B`, m; negative if the leg arm is the rear one.
    pub length: S,
    /// Its rate, m/s.
    pub length_rate: S,
    /// `P_P` from `P_Q` to the right, m.
    pub offset: S,
    /// Its rate, m/s.
    pub offset_rate: S,
}

/// The supporting axle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SupportAxle<S> {
    /// Its direction from above against the body, `theta_sup`, rad.
    pub heading: S,
    /// Rate of that, rad/s.
    pub heading_rate: S,
    /// Half width `A_r`, m.
    pub half_width: S,
}

/// What the supporting axle's wheels do.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AxleMotion<S> {
    /// Speeds of its left and right wheel, m/s.
    pub wheels: [S; 2],
    /// Rate of the body's turning, `theta_B`, rad/s.
    pub turning: S,
}

/// Speeds with which the supporting axle's wheels give `P_P` the velocity `velocity`, m/s in body axes (eq. 9 to 11).
///
/// Printed are magnitudes, which lose the direction; a rate of `B` that is added to the wheels' speeds instead of being taken from what they have to do; and nothing
/// of how `P_P` moves sideways on the body when the arm rolls, by about `(Lr + R) sin(roll)`: the largest error of the paper's law. Here
/// `V_P - (offset_rate, B_rate)` is what the rigid body has to do, with the supporting axle's middle rolling along its heading.
///
/// Nothing moves where the body has no length or the axle lies along it.
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

/// Eq. 9 to 11 with the rate of `B` as printed and no sideways motion of `P_P`: for comparison.
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
    // The sign for a leg arm in front; behind, the body lengthens the other way.
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

//! Computes the motion of the robot with all four wheels on the ground (Nakajima, section 4.3).

use super::wheel::Wheel;
use crate::math::Scalar;

/// Motion that results from the steering angles.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelMode<S> {
    /// Speed of each wheel forward along its own heading, m/s.
    pub wheels: [S; 4],
    /// Yaw rate, counter-clockwise, rad/s.
    pub turning: S,
    /// Centre of the turn relative to the body's middle, m; `None` if the axles are parallel.
    pub centre: Option<[S; 2]>,
}

/// Part of the projection frame that [`wheel_mode`] needs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frame<S> {
    /// Directions of front and rear arm seen from above, `theta_leg` and `theta_sup`, rad; below a
    /// quarter turn.
    pub headings: [S; 2],
    /// Half widths of front and rear arm, `A`, m.
    pub half_widths: [S; 2],
    /// Length `B`, m.
    pub length: S,
}

/// Wheel speeds without slip at the body's speed `speed`, m/s (eq. 13 and what follows it).
///
/// The fractions of eq. 13 are `(B / d, (B / 2) (t_sup + t_leg) / d)` with `t` the tangents and
/// `d = t_sup - t_leg`. The paper excludes `|theta_leg| = |theta_sup|` as the straight course. But
/// opposite angles are the tightest turn, and only equal ones, sign included, are straight. The
/// paper leaves the signs open: `omega = -sgn(x_t) V / R_t`, and a wheel goes at
/// `omega (P_x - x_t) / cos theta`, an inner one backward if the centre is within its arm.
///
/// Here `d` is multiplied out: with `m = (t_sup + t_leg) / 2`, `omega = -V d / (B sqrt(1 + m^2))`.
/// So nothing is divided by `d`, and the straight course needs no case of its own.
///
/// With an arm along the body, or a body without length, the robot cannot be driven, and everything
/// is zero.
pub fn wheel_mode<S: Scalar>(frame: &Frame<S>, speed: S) -> WheelMode<S> {
    let [leg, sup] = frame.headings.map(Scalar::sin_cos);
    let least = S::from_f64(1e-3);
    let stopped = WheelMode {
        wheels: [S::ZERO; 4],
        turning: S::ZERO,
        centre: None,
    };
    if !(leg.1 > least && sup.1 > least && frame.length > least) {
        return stopped;
    }
    let [leg_tangent, sup_tangent] = [leg.0 / leg.1, sup.0 / sup.1];
    let difference = sup_tangent - leg_tangent;
    let half = S::from_f64(0.5);
    let mean = half * (sup_tangent + leg_tangent);
    let straight = speed / (S::ONE + mean * mean).sqrt();
    let turning = -(straight * difference) / frame.length;
    let wheel = |wheel: Wheel, cosine: S| {
        let half_width = frame.half_widths[wheel.axle() as usize];
        (straight + turning * wheel.side::<S>() * half_width * cosine) / cosine
    };
    WheelMode {
        wheels: [
            wheel(Wheel::FrontLeft, leg.1),
            wheel(Wheel::FrontRight, leg.1),
            wheel(Wheel::RearLeft, sup.1),
            wheel(Wheel::RearRight, sup.1),
        ],
        turning,
        centre: (difference != S::ZERO).then(|| {
            let x = frame.length / difference;
            [x, x * mean]
        }),
    }
}

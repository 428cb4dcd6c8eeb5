//! Computes the decoupled control of posture and trajectory (Besseron et al., eq. 13 to 22).

use super::least_squares::LeastSquares;
use super::posture::Posture;
use super::{LEGS, Legs};
use crate::math::Scalar;
use crate::math::vector::{Vector, add, dot, scale, sub};
use core::f64::consts::{FRAC_PI_2, PI};

/// Speed of a contact point below which it gives its wheel no direction, m/s.
const LEAST_SPEED: f64 = 1e-9;

/// Velocity of the platform along the path: `x_t` of eq. 13.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Trajectory<S> {
    /// Along the world's x and y axes, m/s: horizontal, whatever the slope.
    pub velocity: [S; 2],
    /// Yaw rate, rad/s.
    pub yaw_rate: S,
}

/// Whether eq. 17 contains the effect of the path itself on height, roll and pitch.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Form {
    /// With `nL_t x_t`: valid on any slope.
    Full,
    /// As printed, without it: valid on ground that is nearly level.
    Printed,
}

/// Goals of the motors, and the motion of the platform that results.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MotorGoals<S> {
    /// Height, m/s, roll and pitch, rad/s: `x_p` of eq. 20.
    pub posture: Vector<S>,
    /// Wheel speeds, rad/s (eq. 21).
    pub wheels: [S; LEGS],
    /// Steering angles at which the wheels roll (eq. 19), rad, in `(-pi/2, pi/2]`; `None` for a
    /// wheel that stands still.
    pub steering: [Option<S>; LEGS],
}

impl<S: Scalar> Posture<'_, S> {
    /// Height, roll and pitch rate (eq. 20), wheel speeds (eq. 21) and steering angles (from
    /// eq. 19) for a path and the rates of the legs.
    ///
    /// Singularities (contacts in one line, a platform on end) are damped, so all outputs stay
    /// finite.
    pub fn motion(&self, trajectory: &Trajectory<S>, legs: &Legs<S>, form: Form) -> MotorGoals<S> {
        self.follow(&self.follower(), trajectory, legs, form)
    }

    pub(super) fn follow(
        &self,
        follower: &LeastSquares<S>,
        trajectory: &Trajectory<S>,
        legs: &Legs<S>,
        form: Form,
    ) -> MotorGoals<S> {
        let path = self.path_twist(trajectory);
        let rising = self.normal_speeds(
            match form {
                Form::Full => path,
                Form::Printed => [[S::ZERO; 3]; 2],
            },
            legs,
        );
        let posture = follower.solve(rising).map(|value| -value);
        let twist = self.with_posture(path, posture);
        let mut motion = MotorGoals {
            posture,
            wheels: [S::ZERO; LEGS],
            steering: [None; LEGS],
        };
        let per_radius = S::ONE / self.parameters.wheel_radius;
        for (leg, wheel) in self.wheels.iter().enumerate() {
            let velocity = wheel.velocity(twist, legs[leg]);
            motion.wheels[leg] = per_radius * dot(wheel.tangent, velocity);
            // The velocity in the plane of the ground remains. A wheel may roll either way along
            // it.
            let [x, y, _] = sub(velocity, scale(dot(wheel.normal, velocity), wheel.normal));
            let least = S::from_f64(LEAST_SPEED);
            if x * x + y * y > least * least {
                motion.steering[leg] = Some(within_half_turn(y.atan2(x)));
            }
        }
        motion
    }

    /// Speeds of the contact points along the normals, m/s.
    pub(super) fn normal_speeds(&self, twist: [Vector<S>; 2], legs: &Legs<S>) -> [S; LEGS] {
        core::array::from_fn(|leg| {
            let wheel = &self.wheels[leg];
            dot(wheel.normal, wheel.velocity(twist, legs[leg]))
        })
    }

    /// Velocity and angular velocity of the platform on its path, in its own axes: `L_t x_t`
    /// without the wheels.
    pub(super) fn path_twist(&self, trajectory: &Trajectory<S>) -> [Vector<S>; 2] {
        let [x, y] = trajectory.velocity;
        [
            self.attitude.into_platform([x, y, S::ZERO]),
            scale(trajectory.yaw_rate, self.attitude.up()),
        ]
    }

    /// Adds the rates of height, roll and pitch to `twist`.
    pub(super) fn with_posture(
        &self,
        [velocity, turning]: [Vector<S>; 2],
        [height, roll, pitch]: Vector<S>,
    ) -> [Vector<S>; 2] {
        [
            add(velocity, scale(height, self.attitude.up())),
            add(
                turning,
                self.attitude.angular_velocity([roll, pitch, S::ZERO]),
            ),
        ]
    }
}

/// Returns an angle from -pi to pi, or the one half a turn away from it, whichever is in
/// `(-pi/2, pi/2]`.
fn within_half_turn<S: Scalar>(angle: S) -> S {
    let (quarter, half) = (S::from_f64(FRAC_PI_2), S::from_f64(PI));
    if angle > quarter {
        angle - half
    } else if angle <= -quarter {
        angle + half
    } else {
        angle
    }
}

/// Steering rate towards an angle (eq. 22), rad/s. The error is the desired angle minus the
/// measured one.
pub fn steering_rate<S: Scalar>(gain: S, wanted: S, measured: S) -> S {
    gain * (wanted - measured)
}

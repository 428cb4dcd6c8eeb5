//! Computes from the shaft angles where the wheels are and touch the ground, and how fast these
//! places move.

use super::parameters::Parameters;
use crate::math::Scalar;
use crate::math::vector::{CoordinateFrame, Vector, add, cross, dot, scale, sub};

/// Wheel; its number is its index in arrays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Wheel {
    /// Front left.
    FrontLeft = 0,
    /// Front right.
    FrontRight = 1,
    /// Rear left.
    RearLeft = 2,
    /// Rear right.
    RearRight = 3,
}

/// All wheels, in order.
pub const WHEELS: [Wheel; 4] = [
    Wheel::FrontLeft,
    Wheel::FrontRight,
    Wheel::RearLeft,
    Wheel::RearRight,
];

/// Arm with its two wheels; its number is its index in arrays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axle {
    /// Front arm.
    Front = 0,
    /// Rear arm.
    Rear = 1,
}

impl Axle {
    /// Left and right wheel.
    pub fn wheels(self) -> [Wheel; 2] {
        match self {
            Self::Front => [Wheel::FrontLeft, Wheel::FrontRight],
            Self::Rear => [Wheel::RearLeft, Wheel::RearRight],
        }
    }

    /// The other arm.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Front => Self::Rear,
            Self::Rear => Self::Front,
        }
    }

    fn sign<S: Scalar>(self) -> S {
        match self {
            Self::Front => S::ONE,
            Self::Rear => -S::ONE,
        }
    }
}

impl Wheel {
    /// Arm that carries the wheel.
    pub fn axle(self) -> Axle {
        match self {
            Self::FrontLeft | Self::FrontRight => Axle::Front,
            Self::RearLeft | Self::RearRight => Axle::Rear,
        }
    }

    /// Whether the wheel is on the left of the body.
    pub fn is_left(self) -> bool {
        matches!(self, Self::FrontLeft | Self::RearLeft)
    }

    /// The other wheel of the same arm.
    #[must_use]
    pub fn partner(self) -> Self {
        let [left, right] = self.axle().wheels();
        if self.is_left() { right } else { left }
    }

    /// Direction of the wheel along x: -1 on the left, 1 on the right.
    pub fn side<S: Scalar>(self) -> S {
        if self.is_left() { -S::ONE } else { S::ONE }
    }
}

/// Angles that determine the robot's shape, rad, or their rates, rad/s. Arrays are indexed by
/// [`Axle`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Shape<S> {
    /// Pitch of the body from level, front up.
    pub pitch: S,
    /// Steering shafts.
    pub steering: [S; 2],
    /// Roll shafts.
    pub roll: [S; 2],
}

impl<S: Scalar> Shape<S> {
    /// All angles zero.
    pub const ZERO: Self = Self {
        pitch: S::ZERO,
        steering: [S::ZERO; 2],
        roll: [S::ZERO; 2],
    };
}

impl Shape<f32> {
    /// Whether both steering shafts are closer than `tolerance` (rad) to `targets`; false for NaN.
    pub fn is_steered(&self, targets: [f32; 2], tolerance: f32) -> bool {
        let mut shafts = targets.into_iter().zip(self.steering);
        shafts.all(|(target, angle)| (target - angle).abs() < tolerance)
    }
}

/// Rotates a vector about x by an angle that is given as sine and cosine.
fn pitched<S: Scalar>([sine, cosine]: [S; 2], v: Vector<S>) -> Vector<S> {
    [
        v[0],
        cosine * v[1] - sine * v[2],
        sine * v[1] + cosine * v[2],
    ]
}

/// Arm: x of `frame` runs along it to the right, z up and across it. The origin of `frame` is the
/// point where the steering and roll shafts meet.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arm<S> {
    /// Axes of the arm, and the point about which steering and roll turn, in body-centred level
    /// axes.
    pub frame: CoordinateFrame<S>,
    /// Direction of the steering shaft, upward.
    steering_axis: Vector<S>,
}

impl<S: Scalar> Arm<S> {
    /// Computes the arm by the first five factors of Nakajima's eq. 2, for either arm.
    pub fn new(parameters: &Parameters<S>, shape: &Shape<S>, axle: Axle) -> Self {
        let (sine, cosine) = shape.pitch.sin_cos();
        let pitch = [sine, cosine];
        let (steer_sine, steer_cosine) = shape.steering[axle as usize].sin_cos();
        let (roll_sine, roll_cosine) = shape.roll[axle as usize].sin_cos();
        let half = axle.sign::<S>() * S::from_f64(0.5) * parameters.body_length;
        Self {
            frame: CoordinateFrame {
                axes: [
                    [
                        steer_cosine * roll_cosine,
                        steer_sine * roll_cosine,
                        -roll_sine,
                    ],
                    [-steer_sine, steer_cosine, S::ZERO],
                    [
                        steer_cosine * roll_sine,
                        steer_sine * roll_sine,
                        roll_cosine,
                    ],
                ]
                .map(|axis| pitched(pitch, axis)),
                origin: pitched(pitch, [S::ZERO, half, S::ZERO]),
            },
            steering_axis: pitched(pitch, [S::ZERO, S::ZERO, S::ONE]),
        }
    }

    /// Direction of the arm to the right, seen from above, rad: the exact `theta_leg` or
    /// `theta_sup`.
    pub fn heading(&self) -> S {
        let [x, y, _] = self.frame.axes[0];
        y.atan2(x)
    }

    /// Half width `A`: half the distance between the arm's contacts, seen from above, m.
    pub fn half_width(&self, parameters: &Parameters<S>) -> S {
        let [x, y, _] = self.frame.axes[0];
        parameters.half_arm * (x * x + y * y).sqrt()
    }

    /// Centre of a wheel, m.
    pub fn hub(&self, parameters: &Parameters<S>, wheel: Wheel) -> Vector<S> {
        let along = wheel.side::<S>() * parameters.half_arm;
        self.frame.place([along, S::ZERO, -parameters.arm_drop])
    }

    /// Frame at the rim point that is below the hub when the wheel's angle is zero: eq. 2 as a
    /// whole.
    pub fn rim(&self, parameters: &Parameters<S>, wheel: Wheel, angle: S) -> CoordinateFrame<S> {
        let (sine, cosine) = angle.sin_cos();
        let [x, y, z] = self.frame.axes;
        let up = sub(scale(cosine, z), scale(sine, y));
        CoordinateFrame {
            axes: [x, add(scale(cosine, y), scale(sine, z)), up],
            origin: sub(
                self.hub(parameters, wheel),
                scale(parameters.wheel_radius, up),
            ),
        }
    }

    /// Unit vectors across the arm: from the contact to the hub, and forward along the ground. An
    /// arm that stands upright has neither; then the arm's own axes.
    fn rolling_axes(&self) -> [Vector<S>; 2] {
        let [along, across, up] = self.frame.axes;
        let square = along[0] * along[0] + along[1] * along[1];
        if !(square > S::from_f64(1e-6)) {
            return [up, across];
        }
        let per = S::ONE / square.sqrt();
        let to_hub = sub([S::ZERO, S::ZERO, S::ONE], scale(along[2], along));
        [
            scale(per, to_hub),
            scale(per, [-along[1], along[0], S::ZERO]),
        ]
    }

    /// Lowest point of a wheel, where it touches level ground, m: the hub, less
    /// `R (z - (z.e) e) / |z - (z.e) e|` with `e` along the arm.
    ///
    /// The last point of eq. 2 is not used, because it is the lowest for one wheel angle only. The
    /// wheel is taken to be thin.
    pub fn contact(&self, parameters: &Parameters<S>, wheel: Wheel) -> Vector<S> {
        let [to_hub, _] = self.rolling_axes();
        sub(
            self.hub(parameters, wheel),
            scale(parameters.wheel_radius, to_hub),
        )
    }

    /// Motion of a wheel when the angles change at `rates`, with the body's middle at rest.
    pub fn motion(
        &self,
        parameters: &Parameters<S>,
        rates: &Shape<S>,
        axle: Axle,
        wheel: Wheel,
    ) -> WheelMotion<S> {
        let [along, across, _] = self.frame.axes;
        let [to_hub, forward] = self.rolling_axes();
        let hub = self.hub(parameters, wheel);
        let pitch = [rates.pitch, S::ZERO, S::ZERO];
        let arm = add(
            scale(rates.steering[axle as usize], self.steering_axis),
            scale(rates.roll[axle as usize], across),
        );
        let turning = add(pitch, arm);
        let hub_velocity = add(cross(pitch, hub), cross(arm, sub(hub, self.frame.origin)));
        // The unit vector from contact to hub stays across the arm and in the arm's vertical plane.
        // So it turns as the arm does, but without the arm's own twist, which rolls the wheel
        // instead.
        let along_rate = cross(turning, along);
        let tilt = along[2];
        let square = S::ONE - tilt * tilt;
        let per = if square > S::from_f64(1e-6) {
            S::ONE / square
        } else {
            S::ZERO
        };
        let root = if square > S::ZERO {
            square.sqrt()
        } else {
            S::ZERO
        };
        let to_hub_rate = add(
            scale(
                -(root * per),
                add(scale(along_rate[2], along), scale(tilt, along_rate)),
            ),
            scale(tilt * along_rate[2] * per, to_hub),
        );
        let radius = parameters.wheel_radius;
        let rim = sub(hub_velocity, scale(radius, cross(turning, to_hub)));
        WheelMotion {
            contact: sub(hub_velocity, scale(radius, to_hub_rate)),
            rolling: dot(rim, forward),
        }
    }
}

/// Motion of a wheel relative to the body's middle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelMotion<S> {
    /// Velocity of the place that is the lowest point, m/s.
    pub contact: Vector<S>,
    /// Forward speed of the rim at the contact while the wheel's motor is at rest, m/s. The motor
    /// has to roll at this speed for the rim to stand still. It differs from the contact's velocity
    /// by what the arm's own twist rolls.
    pub rolling: S,
}

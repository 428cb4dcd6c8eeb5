//! From shaft angles to wheels and the places where they touch the ground, and how fast these move.

use super::parameters::Parameters;
use crate::math::Scalar;
use crate::math::vector::{CoordinateFrame, Vector, add, cross, dot, scale, sub};

/// A wheel; its number is its place in arrays.
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

/// All wheels in order.
pub const WHEELS: [Wheel; 4] = [
    Wheel::FrontLeft,
    Wheel::FrontRight,
    Wheel::RearLeft,
    Wheel::RearRight,
];

/// An arm with its two wheels; its number is its place in arrays.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Axle {
    /// In front.
    Front = 0,
    /// Behind.
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

    /// The other one.
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
    /// The arm that it is on.
    pub fn axle(self) -> Axle {
        match self {
            Self::FrontLeft | Self::FrontRight => Axle::Front,
            Self::RearLeft | Self::RearRight => Axle::Rear,
        }
    }

    /// Left of the body.
    pub fn is_left(self) -> bool {
        matches!(self, Self::FrontLeft | Self::RearLeft)
    }

    /// The other wheel of its arm.
    #[must_use]
    pub fn partner(self) -> Self {
        let [left, right] = self.axle().wheels();
        if self.is_left() { right } else { left }
    }

    /// -1 on the left, 1 on the right: its direction along x.
    pub fn side<S: Scalar>(self) -> S {
        if self.is_left() { -S::ONE } else { S::ONE }
    }
}

/// Angles that shape the robot, or their rates: rad or rad/s; arrays by [`Axle`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Shape<S> {
    /// Pitch of the body against the level, front up.
    pub pitch: S,
    /// Steering shafts.
    pub steering: [S; 2],
    /// Roll shafts.
    pub roll: [S; 2],
}

impl<S: Scalar> Shape<S> {
    /// Nothing of all.
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

/// About x by an angle given as sine and cosine.
fn pitched<S: Scalar>([sine, cosine]: [S; 2], v: Vector<S>) -> Vector<S> {
    [
        v[0],
        cosine * v[1] - sine * v[2],
        sine * v[1] + cosine * v[2],
    ]
}

/// An arm: its steering and roll shafts meet at `pivot`; x of `frame` runs along it to the right, z up and across.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Arm<S> {
    /// Axes of the arm and the place that steering and roll turn about, in body-centred level axes.
    pub frame: CoordinateFrame<S>,
    /// Direction of the steering shaft, up.
    steering_axis: Vector<S>,
}

impl<S: Scalar> Arm<S> {
    /// The first five factors of Nakajima's eq. 2, for either arm.
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

    /// Direction of the arm from above, to the right: exactly `theta_leg` or `theta_sup`, rad.
    pub fn heading(&self) -> S {
        let [x, y, _] = self.frame.axes[0];
        y.atan2(x)
    }

    /// `A`: half the distance of the arm's contacts from above, m.
    pub fn half_width(&self, parameters: &Parameters<S>) -> S {
        let [x, y, _] = self.frame.axes[0];
        parameters.half_arm * (x * x + y * y).sqrt()
    }

    /// A wheel's middle, m.
    pub fn hub(&self, parameters: &Parameters<S>, wheel: Wheel) -> Vector<S> {
        let along = wheel.side::<S>() * parameters.half_arm;
        self.frame.place([along, S::ZERO, -parameters.arm_drop])
    }

    /// Eq. 2 as a whole: the frame at the rim point that is below the hub when the wheel's angle is zero.
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

    /// Direction from the contact to the hub, and forward along the ground; both unit, across the arm. An arm that stands upright has
    /// none: then the arm's own.
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

    /// Lowest point of a wheel: where it touches level ground. Not the last point of eq. 2, which is lowest for one wheel angle only:
    /// the hub, less `R (z - (z.e) e) / |z - (z.e) e|` with `e` along the arm. The wheel is thin.
    pub fn contact(&self, parameters: &Parameters<S>, wheel: Wheel) -> Vector<S> {
        let [to_hub, _] = self.rolling_axes();
        sub(
            self.hub(parameters, wheel),
            scale(parameters.wheel_radius, to_hub),
        )
    }

    /// How a wheel moves when the angles change at `rates`, the body's middle at rest.
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
        // The unit vector from contact to hub stays across the arm and in its vertical plane: it turns as the arm does, without the
        // arm's own twist, which rolls the wheel instead.
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

/// How a wheel moves against the body's middle.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct WheelMotion<S> {
    /// Velocity of the lowest point as a place, m/s.
    pub contact: Vector<S>,
    /// Speed forward of the rim where it touches, the wheel's motor at rest, m/s: what the motor has to roll for the rim to stand still. It differs
    /// from the contact's by what the arm's own twist rolls.
    pub rolling: S,
}

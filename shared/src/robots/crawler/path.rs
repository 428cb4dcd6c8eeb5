//! Where the robot is by its odometry, and the path that it keeps to: straight, an arc, or a stop.

use super::kinematics::BodyVelocity;
use crate::math::{Scalar, clamp, limit};

/// Place, m, and heading, rad, from where the robot was switched on.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pose {
    /// Forward at the start.
    pub x: f32,
    /// Left at the start.
    pub y: f32,
    /// Counter-clockwise from above.
    pub heading: f32,
}

impl Pose {
    /// The pose after `distance` in a direction `drift` beside the heading (rad, counter-clockwise), while the heading turns by `turn`.
    #[must_use]
    pub fn moved(&self, distance: f32, drift: f32, turn: f32) -> Self {
        let (sine, cosine) = Scalar::sin_cos(self.heading + drift + 0.5 * turn);
        Self {
            x: self.x + distance * cosine,
            y: self.y + distance * sine,
            heading: wrapped(self.heading + turn),
        }
    }
}

/// An angle of less than 8000 rad as one from -pi to pi.
pub(super) fn wrapped(angle: f32) -> f32 {
    let (sine, cosine) = Scalar::sin_cos(angle);
    Scalar::atan2(sine, cosine)
}

/// Yaw rate per error of the direction of travel, 1/s.
const HEADING_GAIN: f32 = 1.5;
/// Yaw rate per distance from the path and per speed along it, rad/m^2: with the other gain, damped well up to 0.4 m/s.
const DISTANCE_GAIN: f32 = 8.0;
/// Distance from the path that counts, m: from farther away the robot comes back at an angle that does not grow.
const FARTHEST: f32 = 0.1;
/// How fast a lasting correction is taken as the ground's resistance to turning, 1/s.
const INTEGRAL_GAIN: f32 = 0.3;
/// Most yaw rate that keeping to the path may add, rad/s, in all and by what it has learnt of the ground.
const MOST_CORRECTION: f32 = 0.6;
/// See above.
const MOST_LEARNT: f32 = 0.3;

/// Keeps the robot on the path that its operator's speeds describe.
///
/// The path is geometry: it goes on with the distance that the robot makes, not with time. So a speed that is taken back does not
/// bend it.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct PathFollower {
    /// The point of the path beside the robot; `None` at a stop, after which a path begins where the robot is.
    beside: Option<Pose>,
    /// Yaw rate that the ground takes away, rad/s.
    learnt: f32,
}

impl PathFollower {
    /// The motion that keeps to the path of `asked` from `pose`, after `period` seconds, while the robot drifts in a direction `drift` beside
    /// its heading.
    pub fn follow(
        &mut self,
        asked: BodyVelocity<f32>,
        pose: &Pose,
        drift: f32,
        period: f32,
    ) -> BodyVelocity<f32> {
        if asked.forward == 0.0 && asked.yaw_rate == 0.0 {
            *self = Self::default();
            return asked;
        }
        let beside = self.beside.get_or_insert(*pose);
        let (sine, cosine) = Scalar::sin_cos(beside.heading);
        let (dx, dy) = (pose.x - beside.x, pose.y - beside.y);
        let progress = dx * cosine + dy * sine;
        let turn = if asked.forward == 0.0 {
            asked.yaw_rate * period
        } else {
            progress * (asked.yaw_rate / asked.forward)
        };
        *beside = beside.moved(progress, 0.0, turn);

        let (sine, cosine) = Scalar::sin_cos(beside.heading);
        let left = (pose.y - beside.y) * cosine - (pose.x - beside.x) * sine;
        let error = wrapped(pose.heading + drift - beside.heading);
        let back = DISTANCE_GAIN * asked.forward * clamp(left, -FARTHEST, FARTHEST);
        let correction = -(HEADING_GAIN * error + back);
        self.learnt = limit(
            self.learnt + INTEGRAL_GAIN * period * correction,
            MOST_LEARNT,
        );
        BodyVelocity {
            forward: asked.forward,
            yaw_rate: asked.yaw_rate + limit(correction + self.learnt, MOST_CORRECTION),
        }
    }
}

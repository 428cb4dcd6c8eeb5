//! Keeps the robot on the commanded path (a straight line, an arc, or a stop) by odometry.

use super::kinematics::BodyVelocity;
use crate::math::{Scalar, clamp, limit};

/// Position, m, and heading, rad, relative to where the robot was switched on.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Pose {
    /// Position along the direction that was forward at the start.
    pub x: f32,
    /// Position along the direction that was left at the start.
    pub y: f32,
    /// Heading, counter-clockwise seen from above.
    pub heading: f32,
}

impl Pose {
    /// Pose after a motion of `distance` at an angle of `drift` (rad, counter-clockwise) to the
    /// heading, while the heading turns by `turn`.
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

/// Wraps an angle of less than 8000 rad to -pi to pi.
pub(super) fn wrapped(angle: f32) -> f32 {
    let (sine, cosine) = Scalar::sin_cos(angle);
    Scalar::atan2(sine, cosine)
}

/// Yaw rate per error of the direction of travel, 1/s.
const HEADING_GAIN: f32 = 1.5;
/// Yaw rate per distance from the path and per speed along it, rad/m^2. With the other gain, the
/// control is damped well up to 0.4 m/s.
const DISTANCE_GAIN: f32 = 8.0;
/// Largest distance from the path that counts, m. From farther away the robot comes back at an
/// angle that does not grow.
const FARTHEST: f32 = 0.1;
/// Rate at which a lasting correction is attributed to the ground's resistance to turning, 1/s.
const INTEGRAL_GAIN: f32 = 0.3;
/// Largest yaw rate that path following may add in all, rad/s.
const MOST_CORRECTION: f32 = 0.6;
/// Largest yaw rate that it may add for the learnt resistance of the ground, rad/s.
const MOST_LEARNT: f32 = 0.3;

/// Keeps the robot on the path that the operator's speeds describe.
///
/// The path is geometric: it advances with the distance that the robot travels, not with time. So a
/// reduced speed does not bend it.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct PathFollower {
    /// Point of the path beside the robot; `None` at a stop, after which a path begins where the
    /// robot is.
    beside: Option<Pose>,
    /// Yaw rate that the ground's resistance takes away, rad/s.
    learnt: f32,
}

impl PathFollower {
    /// Motion that keeps to the path of `asked` from `pose`, `period` s after the previous call,
    /// while the robot drifts at an angle of `drift` (rad) to its heading.
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

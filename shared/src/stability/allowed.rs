//! How much of a command the guard allows, and where a posture's motion leads. [`Allowed::ramp`]
//! scales the operator's speed.

use super::limits::MotionLimits;
use super::support::Stance;
use crate::math::{limit, min};
use crate::motor::profile::{self, Motion};

/// Motion that is commanded, by the operator or by the guard itself, for a robot with postures `P`;
/// `Command<()>` are the speeds alone.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Command<P> {
    /// Forward speed over ground, m/s.
    pub forward: f32,
    /// Yaw rate, counter-clockwise from above, rad/s.
    pub yaw_rate: f32,
    /// Commanded posture.
    pub posture: P,
}

impl<P> Command<P> {
    /// Returns the speeds alone.
    pub fn speeds(&self) -> Command<()> {
        Command::new(self.forward, self.yaw_rate)
    }
}

impl Command<()> {
    /// A command of these speeds, m/s and rad/s.
    pub const fn new(forward: f32, yaw_rate: f32) -> Self {
        Self {
            forward,
            yaw_rate,
            posture: (),
        }
    }

    /// Returns these speeds with a posture.
    pub fn with_posture<P>(self, posture: P) -> Command<P> {
        Command {
            forward: self.forward,
            yaw_rate: self.yaw_rate,
            posture,
        }
    }
}

/// Reason for a stop, which decides how hard the robot brakes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Stop {
    /// The operator stops or is absent, or the sensors are not trusted: the robot brakes within its
    /// own acceleration limit.
    Gentle,
    /// The guard has tripped: the robot brakes as hard as the guard's limits allow.
    Hard,
}

/// The part of a command that the filter allows.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Allowed {
    /// Scale of the commanded speeds, 0 to 1.
    pub speed_scale: f32,
    /// If set, the robot must stand still: wheels, legs, arms and levelling brake to rest.
    pub stop: Option<Stop>,
    /// Whether the robot brakes as hard as the guard's limits allow: more is commanded, or driven
    /// at present, than the filter allows.
    pub brakes: bool,
    /// Whether the posture may move.
    pub posture: bool,
    /// Limits of both motions.
    pub limits: MotionLimits,
}

impl Allowed {
    /// Moves the speed of `motion` toward `asked` (m/s) times the speed scale.
    ///
    /// The acceleration stays within the robot's `own` limits and the guard's limits; the guard's
    /// own stops use only the latter.
    pub fn ramp(&self, motion: &mut Motion, asked: f32, own: profile::Limits, period: f32) {
        let target = limit(asked, own.velocity) * self.speed_scale;
        let handed_down = if target > motion.velocity {
            self.limits.forward
        } else {
            self.limits.backward
        };
        let slows = target.abs() < motion.velocity.abs();
        let acceleration = if slows && (self.stop == Some(Stop::Hard) || self.brakes) {
            handed_down
        } else {
            min(handed_down, own.acceleration)
        };
        let limits = profile::Limits {
            acceleration,
            ..own
        };
        motion.toward_velocity(target, limits, period);
    }

    /// Yaw rate, rad/s, that keeps a robot at `speed` (m/s) on the commanded curve while it still
    /// speeds up. On the spot, it is the commanded yaw rate times the speed scale. Its magnitude is
    /// never above the commanded one.
    pub fn yaw_rate_on_the_curve<P>(&self, command: &Command<P>, speed: f32) -> f32 {
        if command.forward == 0.0 {
            command.yaw_rate * self.speed_scale
        } else {
            limit(
                command.yaw_rate * (speed / command.forward),
                command.yaw_rate.abs(),
            )
        }
    }
}

/// Predicted result of a posture's motion.
#[derive(Clone, Copy, Debug)]
pub struct Ahead {
    /// Stance that the robot will have. A motion that lifts the body also pitches it up.
    pub stance: Stance,
    /// Whether the motion folds down a front that the robot stands on. This lifts the body.
    pub lifts: bool,
}

impl From<Stance> for Ahead {
    fn from(stance: Stance) -> Self {
        Self {
            stance,
            lifts: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed after 0.1 s from 0.4 m/s, with limits of 1.5 m/s^2 from the guard and 0.4 m/s^2 of the
    /// robot.
    fn slowed(asked: f32, speed_scale: f32, stop: Option<Stop>) -> f32 {
        let allowed = Allowed {
            speed_scale,
            stop,
            brakes: speed_scale < 1.0,
            posture: true,
            limits: MotionLimits {
                forward: 1.5,
                backward: 1.5,
                ..MotionLimits::default()
            },
        };
        let own = profile::Limits {
            velocity: 0.5,
            acceleration: 0.4,
        };
        let mut motion = Motion {
            velocity: 0.4,
            ..Motion::default()
        };
        for _ in 0..25 {
            allowed.ramp(&mut motion, asked, own, 4e-3);
        }
        motion.velocity
    }

    #[test]
    fn the_guard_stops_as_hard_as_the_limits_bear_and_the_operator_gently() {
        for (asked, speed_scale, stop, rate) in [
            (0.4, 0.0, None, -1.5),
            (0.0, 1.0, Some(Stop::Hard), -1.5),
            (0.0, 1.0, Some(Stop::Gentle), -0.4),
            (0.0, 1.0, None, -0.4),
            (0.5, 1.0, None, 0.4),
            // Although it is scaled down, it still speeds up with its own acceleration.
            (0.5, 0.9, None, 0.4),
        ] {
            let expected = 0.4 + 0.1 * rate;
            let found = slowed(asked, speed_scale, stop);
            assert!(
                (found - expected).abs() < 2e-3,
                "{asked} {speed_scale} {stop:?}: {found}"
            );
        }
    }
}

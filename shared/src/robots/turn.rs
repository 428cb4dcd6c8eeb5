//! Limits the yaw of a robot that turns by different speeds of its two sides.
//!
//! Each side stays within the speed limit of the robot, and the yaw rate changes with a limited
//! acceleration. [`crate::stability::limits`] limits the yaw by the margins, separately from this.

use super::body::{Allowed, Command, Stop};
use crate::math::limit;
use crate::settings::{Setting, Settings};

/// Yaw rate of a robot with wheels or belts on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Turn {
    /// Distance of a side from the middle, m.
    half_width: f32,
    /// Speed limit of a side, m/s.
    speed: f32,
    /// Largest change of the speed of a side by yaw, m/s^2: on command, and in a stop by the guard.
    acceleration: f32,
    braking: f32,
    /// Present yaw rate, rad/s.
    rate: f32,
}

impl Turn {
    /// Turn of a robot with sides `half_width` m (above zero) from its middle.
    ///
    /// Speed limit and accelerations are those of the robot over ground.
    pub fn new(half_width: f32, settings: &Settings) -> Self {
        let acceleration = settings.si(Setting::DriveAcceleration);
        let braking = settings.si(Setting::GuardDeceleration);
        Self {
            half_width,
            speed: settings.si(Setting::SpeedLimit),
            acceleration,
            braking: if braking > acceleration {
                braking
            } else {
                acceleration
            },
            rate: 0.0,
        }
    }

    /// Present yaw rate, rad/s.
    pub fn rate(&self) -> f32 {
        self.rate
    }

    /// Sets the yaw rate to zero at once.
    pub fn rest(&mut self) {
        self.rate = 0.0;
    }

    /// Scales speed and yaw rate of a command down together, so that `|v| + |w| b / 2` is within
    /// the speed limit and the curve stays the same. A command that is not finite becomes a stop.
    #[must_use]
    pub fn within<P>(&self, asked: Command<P>) -> Command<P> {
        let fastest = asked.forward.abs() + asked.yaw_rate.abs() * self.half_width;
        if fastest <= self.speed {
            return asked;
        }
        let scale = self.speed / fastest;
        // The scale is zero for an infinite sum. The comparison is false for NaN.
        let scaled = |value: f32| if scale > 0.0 { value * scale } else { 0.0 };
        Command {
            forward: scaled(asked.forward),
            yaw_rate: scaled(asked.yaw_rate),
            ..asked
        }
    }

    /// Moves the yaw rate toward `target` (rad/s) while the robot drives at `speed` (m/s, within
    /// the speed limit), and returns it.
    ///
    /// The guard's own stops and limits brake the yaw as hard as the setting
    /// `guard_deceleration` allows.
    pub fn advance(&mut self, target: f32, speed: f32, allowed: &Allowed, period: f32) -> f32 {
        let left = self.speed - speed.abs();
        let largest = if left > 0.0 {
            left / self.half_width
        } else {
            0.0
        };
        let target = limit(target, largest);
        let bearable = allowed.limits.yaw_rate(self.rate, speed);
        let guarded = allowed.stop == Some(Stop::Hard) || allowed.brakes || bearable != self.rate;
        let slows = target.abs() < self.rate.abs();
        let acceleration = if guarded && slows {
            self.braking
        } else {
            self.acceleration
        };
        let step = acceleration / self.half_width * period;
        let change = target - self.rate;
        let next = if change.abs() <= step {
            target
        } else {
            self.rate + limit(change, step)
        };
        // The speed has priority over the yaw.
        self.rate = limit(next, largest);
        self.rate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::limits::MotionLimits;

    const PERIOD: f32 = 4e-3;

    fn allowed(speed_scale: f32, stop: Option<Stop>) -> Allowed {
        Allowed {
            speed_scale,
            stop,
            brakes: speed_scale < 1.0,
            posture: true,
            limits: MotionLimits {
                forward: 1.5,
                backward: 1.5,
                left: 0.4,
                right: 0.4,
                posture: 1.0,
            },
        }
    }

    fn asked(forward: f32, yaw_rate: f32) -> Command<()> {
        Command {
            forward,
            yaw_rate,
            posture: (),
        }
    }

    #[test]
    fn a_command_beyond_the_belts_is_scaled_on_its_curve() {
        let turn = Turn::new(0.16, &Settings::default());
        let slow = asked(0.2, -0.5);
        assert_eq!(turn.within(slow), slow);
        let fast = turn.within(asked(-1.0, 32.767));
        assert!((fast.forward.abs() + 0.16 * fast.yaw_rate - 0.45).abs() < 1e-6);
        assert!((fast.yaw_rate / fast.forward + 32.767).abs() < 1e-4);
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(turn.within(asked(bad, 0.1)).forward, 0.0);
            assert_eq!(turn.within(asked(0.1, bad)).yaw_rate, 0.0);
        }
    }

    #[test]
    fn the_yaw_rate_rises_with_an_acceleration_and_the_guard_brakes_it_harder() {
        let mut turn = Turn::new(0.16, &Settings::default());
        for step in 1..=100 {
            let rate = turn.advance(32.767, 0.0, &allowed(1.0, None), PERIOD);
            // 0.4 m/s^2 at 0.16 m are 2.5 rad/s^2.
            assert!(rate <= 2.5 * PERIOD * step as f32 + 1e-5, "{step}: {rate}");
        }
        assert!((turn.rate() - 1.0).abs() < 1e-3);
        turn.advance(0.0, 0.0, &allowed(1.0, None), PERIOD);
        assert!((turn.rate() - 0.99).abs() < 1e-3);
        turn.advance(0.0, 0.0, &allowed(1.0, Some(Stop::Hard)), PERIOD);
        // 1.5 m/s^2 at 0.16 m.
        assert!((turn.rate() - 0.9525).abs() < 1e-3, "{}", turn.rate());
    }

    #[test]
    fn the_yaw_gives_way_to_the_speed_and_nan_turns_nothing() {
        let mut turn = Turn::new(0.16, &Settings::default());
        for _ in 0..2_000 {
            turn.advance(5.0, 0.0, &allowed(1.0, None), PERIOD);
        }
        assert!((turn.rate() - 0.45 / 0.16).abs() < 1e-5);
        assert_eq!(turn.advance(5.0, 0.45, &allowed(1.0, None), PERIOD), 0.0);
        for _ in 0..2 {
            assert_eq!(
                turn.advance(f32::NAN, 0.0, &allowed(1.0, None), PERIOD),
                0.0
            );
            assert_eq!(
                turn.advance(1.0, f32::NAN, &allowed(1.0, None), PERIOD),
                0.0
            );
        }
    }
}

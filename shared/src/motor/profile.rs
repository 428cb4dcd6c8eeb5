//! Trapezoidal profile: the fastest motion to a target within a velocity limit and an acceleration
//! limit.

use crate::math::{Turns, limit, sqrt, to_i32};

/// Limits of a motion, both positive.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Largest velocity, rad/s.
    pub velocity: f32,
    /// Largest acceleration, rad/s^2.
    pub acceleration: f32,
}

impl Limits {
    /// No limits.
    pub const NONE: Self = Self {
        velocity: f32::INFINITY,
        acceleration: f32::INFINITY,
    };
}

/// A moving set-point: position, velocity in rad/s, acceleration in rad/s^2.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Position.
    pub position: Turns,
    /// Velocity.
    pub velocity: f32,
    /// Acceleration.
    pub acceleration: f32,
}

impl Motion {
    /// Creates a set-point at rest at `position`.
    pub fn at(position: Turns) -> Self {
        Self {
            position,
            velocity: 0.0,
            acceleration: 0.0,
        }
    }

    /// Moves the set-point by one step of `period` seconds, so that it comes to rest at `target`.
    /// Every step leaves enough distance to brake. So the set-point does not pass the target unless
    /// it was already too fast.
    pub fn toward_position(&mut self, target: Turns, limits: Limits, period: f32) {
        let distance = (target - self.position).radians();
        let sign = if distance < 0.0 { -1.0 } else { 1.0 };
        let (way, speed) = (distance * sign, self.velocity * sign);
        let step = limits.acceleration * period;
        // v' is the next speed with which the travel of this step and a ramp to rest exactly cover
        // the distance: (v + v') T / 2 + v'^2 / (2 a) = distance.
        let rest = way - 0.5 * speed * period;
        let rest = if rest > 0.0 { rest } else { 0.0 };
        let braking = sqrt(0.25 * step * step + 2.0 * limits.acceleration * rest) - 0.5 * step;
        let near = way <= step * period && self.velocity.abs() <= step;
        if near {
            self.acceleration = 0.0;
            self.velocity = 0.0;
            self.position = target;
        } else {
            // The other function limits the velocity.
            self.toward_velocity(sign * braking, limits, period);
        }
    }

    /// Moves the set-point by one step of `period` seconds, towards the velocity `target`.
    pub fn toward_velocity(&mut self, target: f32, limits: Limits, period: f32) {
        let step = limits.acceleration * period;
        let target = limit(target, limits.velocity);
        let change = target - self.velocity;
        let next = if change > step {
            self.velocity + step
        } else if change < -step {
            self.velocity - step
        } else {
            target
        };
        self.acceleration = (next - self.velocity) / period;
        let mean = 0.5 * (self.velocity + next);
        self.velocity = next;
        self.advance(mean * period);
    }

    /// Moves the position by `way`, rad, at most half a turn. The travel of one period is far
    /// smaller.
    #[inline]
    pub fn advance(&mut self, way: f32) {
        let units = to_i32(way * Turns::PER_RADIAN);
        self.position += Turns::from_bits(units.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        velocity: 0.5,
        acceleration: 4.0,
    };

    #[test]
    fn reaches_the_target_in_the_time_of_the_trapezoid_within_its_limits() {
        let target = Turns::from_radians(0.8);
        let mut set_point = Motion::default();
        let mut steps = 0;
        while set_point.position != target {
            set_point.toward_position(target, LIMITS, 1e-3);
            assert!(
                set_point.velocity.abs() <= 0.5 && set_point.acceleration.abs() <= 4.02,
                "{set_point:?}"
            );
            assert!(
                set_point.position <= target,
                "{steps}: {:?}",
                set_point.position - target
            );
            steps += 1;
            assert!(steps < 3_000);
        }
        // Expected time: distance / velocity + velocity / acceleration.
        assert!((i32::abs(steps - 1_725)) <= 5, "{steps}");
    }

    #[test]
    fn turns_round_when_the_target_moves_behind() {
        let mut set_point = Motion::default();
        for _ in 0..500 {
            set_point.toward_position(Turns::from_radians(1.0), LIMITS, 1e-3);
        }
        for _ in 0..4_000 {
            set_point.toward_position(Turns::from_radians(-0.3), LIMITS, 1e-3);
        }
        assert_eq!(set_point.position, Turns::from_radians(-0.3));
        assert_eq!(set_point.velocity, 0.0);
    }
}

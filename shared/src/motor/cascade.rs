//! Position loop over velocity loop: from a set-point and the measured motion to a motor current.

use super::{profile::SetPoint, to_radians};
use crate::math::limit;

/// Gains at the output shaft.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// Position loop, 1/s.
    pub position: f32,
    /// Velocity loop, A s/rad.
    pub velocity: f32,
    /// Integral time of the velocity loop, s, above zero.
    pub integral_time: f32,
    /// Current for acceleration, A s^2/rad.
    pub acceleration: f32,
    /// Largest velocity that the position loop may ask for, rad/s.
    pub velocity_limit: f32,
}

/// The loops and their one state, the integral of the velocity loop.
#[derive(Clone, Debug)]
pub struct Cascade {
    gains: Gains,
    integral: f32,
}

/// A current with the limits that cut it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Demand {
    /// Motor current, A, within the limit that was given.
    pub current: f32,
    /// The velocity or the current limit is at work.
    pub limited: bool,
}

impl Cascade {
    /// Loops at rest.
    pub fn new(gains: Gains) -> Self {
        Self {
            gains,
            integral: 0.0,
        }
    }

    /// Forgets the integral: before the bridge is switched on.
    pub fn reset(&mut self) {
        self.integral = 0.0;
    }

    /// Both loops: holds `set_point` against the measured `position` and `velocity`, with its velocity and acceleration fed
    /// forward. `current_limit` is in A; the result never exceeds it, whatever the inputs.
    pub fn position(
        &mut self,
        set_point: &SetPoint,
        position: i64,
        velocity: f32,
        current_limit: f32,
        period: f32,
    ) -> Demand {
        let error = to_radians(set_point.position.wrapping_sub(position));
        let wanted = set_point.velocity + self.gains.position * error;
        let allowed = limit(wanted, self.gains.velocity_limit);
        let mut demand = self.velocity(
            allowed,
            set_point.acceleration,
            velocity,
            current_limit,
            period,
        );
        demand.limited |= allowed != wanted;
        demand
    }

    /// Velocity loop alone, with anti-windup: the integral never asks for more than the limit leaves to the rest.
    pub fn velocity(
        &mut self,
        wanted: f32,
        acceleration: f32,
        velocity: f32,
        current_limit: f32,
        period: f32,
    ) -> Demand {
        let error = wanted - velocity;
        let proportional = self.gains.velocity * error;
        let integral = self.integral + proportional * (period / self.gains.integral_time);
        let asked = proportional + self.gains.acceleration * acceleration + integral;
        let current = limit(asked, current_limit);
        let limited = current != asked;
        // While the limit cuts, the integral may only move back from it.
        if !limited || (asked > current) != (error > 0.0) {
            self.integral = limit(integral, current_limit);
        }
        Demand { current, limited }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAINS: Gains = Gains {
        position: 20.0,
        velocity: 3.0,
        integral_time: 0.05,
        acceleration: 0.02,
        velocity_limit: 6.0,
    };

    /// Rotor of inertia 0.05 kg m^2 with 2.4 N m/A, against a constant load torque.
    fn settle(load: f32, target: i64) -> (i64, f32, f32) {
        let (mut cascade, mut position, mut velocity, mut peak) =
            (Cascade::new(GAINS), 0_i64, 0.0_f32, 0.0_f32);
        for _ in 0..3_000 {
            let demand = cascade.position(&SetPoint::at(target), position, velocity, 10.0, 1e-3);
            velocity += (2.4 * demand.current - load) / 0.05 * 1e-3;
            position += super::super::from_radians(velocity * 1e-3);
            peak = if to_radians(position) > peak {
                to_radians(position)
            } else {
                peak
            };
        }
        (position, velocity, peak)
    }

    #[test]
    fn holds_a_position_against_a_constant_load() {
        let (position, velocity, _) = settle(5.0, 0);
        assert!(
            to_radians(position).abs() < 1e-4 && velocity.abs() < 1e-3,
            "{position} {velocity}"
        );
    }

    #[test]
    fn a_long_step_does_not_wind_up() {
        let target = super::super::from_radians(10.0);
        let (position, _, peak) = settle(0.0, target);
        assert!(to_radians(position - target).abs() < 1e-3);
        assert!(peak < 10.0 * 1.02, "overshoot to {peak}");
    }

    #[test]
    fn nothing_exceeds_the_current_limit() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -0.0] {
            let mut cascade = Cascade::new(GAINS);
            for _ in 0..3 {
                let demand = cascade.velocity(bad, bad, 1.0, 10.0, 1e-3);
                assert!(demand.current.abs() <= 10.0);
            }
            let after = cascade.velocity(1.0, 0.0, 1.0, 10.0, 1e-3);
            assert!(after.current.abs() <= 10.0);
        }
    }
}

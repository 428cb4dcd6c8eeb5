//! Averages the measured specific force and low-pass filters it in level axes.

use super::attitude::LevelAxes;
use crate::constants::GRAVITY;
use crate::math::vector::{Vector, scale};
use crate::math::{max, min};

/// Time constant of the low-pass, s: longer than the impact of a track on the nose (front edge) of
/// a step, shorter than the fall of a robot 0.3 m high (`sqrt(h / g)` = 0.17 s).
const FORCE_TIME: f32 = 0.1;

/// Low-pass filter of the specific force in level axes.
///
/// Averages the readings in body axes from one evaluation to the next, and transforms the mean to
/// level axes before the low-pass. So a fast swing does not spread gravity over two axes.
#[derive(Clone, Debug)]
pub struct SpecificForce {
    sum: Vector<f32>,
    count: f32,
    level: Vector<f32>,
    /// Time since the evaluation with the newest reading, s.
    elapsed: f32,
}

impl Default for SpecificForce {
    fn default() -> Self {
        Self {
            sum: [0.0; 3],
            count: 0.0,
            level: [0.0, 0.0, GRAVITY],
            elapsed: 0.0,
        }
    }
}

impl SpecificForce {
    /// Adds one reading in body axes, m/s^2, that was found plausible.
    #[inline]
    pub fn receive(&mut self, force: Vector<f32>) {
        for (sum, value) in self.sum.iter_mut().zip(force) {
            *sum += value;
        }
        self.count += 1.0;
    }

    /// Returns the force in level axes, m/s^2, `period` s after the previous evaluation. Without a
    /// new reading it does not change. The next reading counts for the time since the one before,
    /// up to the time constant.
    #[inline]
    pub fn advance(&mut self, axes: &LevelAxes, period: f32) -> Vector<f32> {
        self.elapsed = min(self.elapsed + period, max(FORCE_TIME, period));
        if self.count > 0.0 {
            let period = core::mem::take(&mut self.elapsed);
            let mean = axes.of(scale(1.0 / self.count, self.sum));
            let share = period / (FORCE_TIME + period);
            for (level, value) in self.level.iter_mut().zip(mean) {
                *level += (value - *level) * share;
            }
        }
        (self.sum, self.count) = ([0.0; 3], 0.0);
        self.level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_impact_moves_the_force_little_and_a_braking_robot_s_wholly() {
        let axes = {
            let mut attitude = super::super::attitude::Attitude::default();
            attitude.update(&crate::sensors::BodySensors::default(), 1e-3);
            attitude.level_axes()
        };
        let mut force = SpecificForce::default();
        // An impact of 30 m/s^2 for 4 ms.
        force.receive([-30.0, 0.0, GRAVITY]);
        assert!(force.advance(&axes, 4e-3)[0] > -1.2);
        for _ in 0..200 {
            force.receive([-0.4, 0.0, GRAVITY]);
            force.advance(&axes, 4e-3);
        }
        let settled = force.advance(&axes, 4e-3);
        assert!((settled[0] + 0.4).abs() < 1e-3, "{settled:?}");
    }

    /// After 120 ms, a step has reached two thirds at any rate of the readings.
    #[test]
    fn the_time_constant_does_not_depend_on_the_rate_of_the_readings() {
        for every in [1, 5, 10] {
            let axes = super::super::attitude::Attitude::default().level_axes();
            let mut force = SpecificForce::default();
            let mut level = [0.0; 3];
            for evaluation in 1..=30_u32 {
                if evaluation.is_multiple_of(every) {
                    force.receive([1.0, 0.0, GRAVITY]);
                }
                level = force.advance(&axes, 4e-3);
            }
            assert!((level[0] - 0.667).abs() < 0.05, "{every}: {level:?}");
        }
    }
}

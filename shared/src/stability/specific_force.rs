//! The measured specific force, averaged and low-passed in level axes.

use super::attitude::LevelAxes;
use crate::constants::GRAVITY;
use crate::math::vector::{Vector, scale};

/// Time with which the measured force follows, s: longer than the impact of a track on a nose,
/// shorter than the fall of a robot 0.3 m high (`sqrt(h / g)` = 0.17 s).
const FORCE_TIME: f32 = 0.1;

/// Specific force in level axes, low-passed.
///
/// Readings are averaged in body axes from one evaluation to the next and turned into level axes
/// before the low-pass, so that a fast swing does not smear gravity over two axes.
#[derive(Clone, Debug)]
pub struct SpecificForce {
    sum: Vector<f32>,
    count: f32,
    level: Vector<f32>,
}

impl Default for SpecificForce {
    fn default() -> Self {
        Self {
            sum: [0.0; 3],
            count: 0.0,
            level: [0.0, 0.0, GRAVITY],
        }
    }
}

impl SpecificForce {
    /// Takes one reading in body axes, m/s^2, that was found to be plausible.
    #[inline]
    pub fn receive(&mut self, force: Vector<f32>) {
        for (sum, value) in self.sum.iter_mut().zip(force) {
            *sum += value;
        }
        self.count += 1.0;
    }

    /// The force in level axes, `period` s after the evaluation before. Without a reading since
    /// then it stays as it was.
    #[inline]
    pub fn advance(&mut self, axes: &LevelAxes, period: f32) -> Vector<f32> {
        if self.count > 0.0 {
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
        // 30 m/s^2 for 4 ms.
        force.receive([-30.0, 0.0, GRAVITY]);
        assert!(force.advance(&axes, 4e-3)[0] > -1.2);
        for _ in 0..200 {
            force.receive([-0.4, 0.0, GRAVITY]);
            force.advance(&axes, 4e-3);
        }
        let settled = force.advance(&axes, 4e-3);
        assert!((settled[0] + 0.4).abs() < 1e-3, "{settled:?}");
    }
}

//! Means of the readings of a robot at rest.

use super::interface::Reason;
use super::{Failure, length};
use crate::constants::GRAVITY;
use crate::math::{max, min};
use crate::sensors::BodySensors;

/// Largest range of each axis of a gyroscope at rest, rad/s.
const STILL: f32 = 0.1;
/// Largest deviation of the accelerometer from 1 g, m/s^2.
const GRAVITY_ERROR: f32 = 0.05 * GRAVITY;

/// Means of the readings at rest, in the axes of the board.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rest {
    /// Time since the start, s.
    pub time: f32,
    force: Mean<3>,
    rate: Mean<3>,
    pub field: Mean<3>,
    inclination: Mean<2>,
    /// Smallest and largest angular rate.
    rates: Option<[[f32; 3]; 2]>,
}

/// Means of force, angular rate and inclination, m/s^2, rad/s and rad.
pub(super) struct Means {
    pub force: [f32; 3],
    pub rate: [f32; 3],
    pub inclination: [f32; 2],
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Mean<const N: usize> {
    sum: [f32; N],
    count: f32,
}

impl<const N: usize> Default for Mean<N> {
    fn default() -> Self {
        Self {
            sum: [0.0; N],
            count: 0.0,
        }
    }
}

impl<const N: usize> Mean<N> {
    fn add(&mut self, values: [f32; N], fresh: bool) {
        if fresh {
            self.count += 1.0;
            // A running mean: a sum of thousands of readings would lose digits.
            for (mean, value) in self.sum.iter_mut().zip(values) {
                *mean += (value - *mean) / self.count;
            }
        }
    }

    pub fn get(&self) -> Option<[f32; N]> {
        (self.count > 0.0).then_some(self.sum)
    }
}

impl Rest {
    pub fn add(&mut self, sensors: &BodySensors, period: f32) {
        self.time += period;
        let fresh = sensors.fresh;
        self.force.add(sensors.specific_force, fresh.accelerometer);
        self.rate.add(sensors.angular_rate, fresh.gyroscope);
        self.field.add(sensors.magnetic_field, fresh.magnetometer);
        self.inclination
            .add(sensors.inclination, fresh.inclinometer);
        if fresh.gyroscope {
            let rate = sensors.angular_rate;
            let [low, high] = self.rates.get_or_insert([rate; 2]);
            for axis in 0..3 {
                low[axis] = min(low[axis], rate[axis]);
                high[axis] = max(high[axis], rate[axis]);
            }
        }
    }

    /// Means of force, angular rate and inclination, if the robot was at rest.
    pub fn means(&self) -> Result<Means, Failure> {
        let [low, high] = self.rates.unwrap_or([[f32::INFINITY; 3], [0.0; 3]]);
        let range = (0..3).fold(0.0, |most, axis| max(most, (high[axis] - low[axis]).abs()));
        if !(range <= STILL) {
            return Err((Reason::Moved, range));
        }
        let (Some(force), Some(rate), Some(inclination)) =
            (self.force.get(), self.rate.get(), self.inclination.get())
        else {
            return Err((Reason::Moved, 0.0));
        };
        let strength = length(force);
        if !((strength - GRAVITY).abs() <= GRAVITY_ERROR) {
            return Err((Reason::NotGravity, strength));
        }
        Ok(Means {
            force,
            rate,
            inclination,
        })
    }
}

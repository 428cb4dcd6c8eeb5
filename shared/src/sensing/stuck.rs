//! Tells a frozen reading from the reading of a coarse sensor at rest.
//!
//! A reading that repeats is no fault by itself: an inclinometer with a resolution of 0.1 degree
//! repeats its reading while the robot stands. Two things show a fault:
//!
//! * An axis of accelerometer or gyroscope repeats for a number of readings. The noise of such a
//!   sensor exceeds its resolution, so its last digit changes all the time.
//! * Any axis repeats while the other sensors show that the robot has turned.

use super::trust::{Reason, Trust};
use crate::constants::GRAVITY;
use crate::estimate::attitude::Attitude;
use crate::sensors::{BodySensors, Fresh};

/// Rotation from which an inclinometer must read another value, and contradiction of the
/// inclinometer from which a gyroscope must, rad: 3 degrees.
const ROTATION: f32 = 0.052;
/// Change of a component of gravity from which an accelerometer must read another value, m/s^2.
const GRAVITY_CHANGE: f32 = ROTATION * GRAVITY;
/// Duration of such a contradiction from which the sensor is in doubt, and from which it is not
/// trusted, s.
const DOUBTED_AFTER: f32 = 0.25;
const LOST_AFTER: f32 = 0.5;

/// Axes of inclinometer, accelerometer and gyroscope, in this order.
const AXES: usize = 8;
/// First axis of the accelerometer, and of the gyroscope.
const ACCELEROMETER: usize = 2;
const GYROSCOPE: usize = 5;

/// Monitor of repeated readings.
#[derive(Clone, Debug)]
pub struct Stuck {
    /// Number of equal readings after which an axis of the inertial unit is in doubt; 0: never.
    limit: u32,
    bits: [u32; AXES],
    equal: [u32; AXES],
    /// Pitch, roll and gravity in body axes by the attitude filter when the axis changed last.
    reference: [f32; GYROSCOPE],
    changed: [bool; GYROSCOPE],
    /// Duration of the contradiction of inclinometer, accelerometer and gyroscope, s.
    contradicted: [f32; 3],
}

impl Stuck {
    /// Monitor for which an axis of the inertial unit is in doubt after `limit` equal readings; 0:
    /// never.
    pub fn new(limit: u32) -> Self {
        Self {
            limit,
            bits: [0; AXES],
            equal: [0; AXES],
            reference: [0.0; GYROSCOPE],
            changed: [true; GYROSCOPE],
            contradicted: [0.0; 3],
        }
    }

    /// Takes the readings that are `fresh`.
    pub fn receive(&mut self, sensors: &BodySensors, fresh: Fresh) {
        if fresh.inclinometer {
            self.count(0, &sensors.inclination);
        }
        if fresh.accelerometer {
            self.count(ACCELEROMETER, &sensors.specific_force);
        }
        if fresh.gyroscope {
            self.count(GYROSCOPE, &sensors.angular_rate);
        }
    }

    fn count(&mut self, first: usize, values: &[f32]) {
        for (axis, value) in (first..).zip(values) {
            let bits = value.to_bits();
            if bits == self.bits[axis] {
                self.equal[axis] = self.equal[axis].saturating_add(1);
            } else {
                (self.bits[axis], self.equal[axis]) = (bits, 0);
                if let Some(changed) = self.changed.get_mut(axis) {
                    *changed = true;
                }
            }
        }
    }

    /// Compares repeated readings with the `attitude`, `period` s after the previous comparison.
    pub fn compare(&mut self, attitude: &Attitude, period: f32) {
        let axes = attitude.level_axes();
        let [forward, left, up] = axes.up().map(|component| component * GRAVITY);
        let (pitch, roll) = (attitude.pitch().radians(), attitude.roll().radians());
        let mut moved = [false; GYROSCOPE];
        let expected = [pitch, roll, forward, left, up];
        for (axis, expected) in expected.into_iter().enumerate() {
            if self.changed[axis] {
                (self.reference[axis], self.changed[axis]) = (expected, false);
            }
            let bound = if axis < ACCELEROMETER {
                ROTATION
            } else {
                GRAVITY_CHANGE
            };
            moved[axis] = (expected - self.reference[axis]).abs() > bound;
        }
        // Pitch is a rotation about y, roll about x.
        let [pitch, roll] = attitude.contradiction();
        let still = |axis: usize| self.equal[GYROSCOPE + axis] > 0;
        let gyroscope = (still(0) && roll.abs() > ROTATION) || (still(1) && pitch.abs() > ROTATION);
        let contradictions = [
            moved[0] || moved[1],
            moved[2] || moved[3] || moved[4],
            gyroscope,
        ];
        for (time, contradicted) in self.contradicted.iter_mut().zip(contradictions) {
            let change = if contradicted { period } else { -period };
            *time = crate::math::clamp(*time + change, 0.0, 2.0 * LOST_AFTER);
        }
    }

    /// How far the inclinometer (0), the accelerometer (1) or the gyroscope (2) is trusted.
    pub fn trust(&self, sensor: usize) -> Trust {
        let time = self.contradicted.get(sensor).copied().unwrap_or(f32::NAN);
        let (first, end) = match sensor {
            1 => (ACCELEROMETER, GYROSCOPE),
            2 => (GYROSCOPE, AXES),
            _ => (0, 0),
        };
        let counts = self.equal.get(first..end).unwrap_or(&[]);
        let longest = counts.iter().fold(0, |most, count| *count.max(&most));
        let counted = match self.limit {
            0 => Trust::Full,
            limit if longest >= limit.saturating_mul(2) => Trust::None(Reason::Stuck),
            limit if longest >= limit => Trust::Degraded(Reason::Stuck),
            _ => Trust::Full,
        };
        // The comparisons are false for NaN.
        let compared = if time < DOUBTED_AFTER {
            Trust::Full
        } else if time < LOST_AFTER {
            Trust::Degraded(Reason::Stuck)
        } else {
            Trust::None(Reason::Stuck)
        };
        counted.or(compared)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: f32 = 50.0;

    /// Sensors with 50 Hz on a body that pitches up by `degrees` within a second, then stands. Each
    /// is rounded to its resolution: 0.1 degree, 0.04 m/s^2, 0.2 degrees/s. `change` may freeze
    /// some. Returns the worst trust in each sensor, and when the first doubt came after the start
    /// of the motion, s.
    fn pitched(degrees: f32, change: impl Fn(&mut BodySensors, f32)) -> ([Trust; 3], f32) {
        let (mut stuck, mut attitude) = (Stuck::new(0), Attitude::default());
        let (mut worst, mut first) = ([Trust::Full; 3], f32::INFINITY);
        let round = |value: f32, quantum: f32| (value / quantum).round() * quantum;
        for step in 0..6_000_u32 {
            let time = step as f32 * 1e-3 - 2.0;
            let rate = if (0.0..1.0).contains(&time) {
                degrees.to_radians()
            } else {
                0.0
            };
            let pitch = degrees.to_radians() * time.clamp(0.0, 1.0);
            let mut sensors = BodySensors {
                inclination: [round(pitch, 0.001_745), 0.0],
                specific_force: [
                    round(GRAVITY * pitch.sin(), 0.04),
                    0.0,
                    round(GRAVITY * pitch.cos(), 0.04),
                ],
                angular_rate: [0.0, -round(rate, 0.003_49), 0.0],
                ..BodySensors::default()
            };
            let new = step % (1_000.0 / RATE) as u32 == 0;
            sensors.fresh = if new { Fresh::ALL } else { Fresh::NONE };
            change(&mut sensors, time);
            stuck.receive(&sensors, sensors.fresh);
            attitude.update(&sensors, 1e-3);
            if step % 4 == 0 {
                stuck.compare(&attitude, 4e-3);
            }
            for (sensor, worst) in worst.iter_mut().enumerate() {
                *worst = worst.or(stuck.trust(sensor));
                if *worst != Trust::Full && time < first {
                    first = time;
                }
            }
        }
        (worst, first)
    }

    #[test]
    fn coarse_sensors_at_rest_and_in_motion_are_not_stuck() {
        for degrees in [0.0, 2.0, 10.0, 40.0] {
            assert_eq!(pitched(degrees, |_, _| ()).0, [Trust::Full; 3], "{degrees}");
        }
    }

    #[test]
    fn a_frozen_reading_is_named_within_a_second_of_the_motion_that_it_misses() {
        let lost = Trust::None(Reason::Stuck);
        let (worst, first) = pitched(20.0, |sensors, _| sensors.inclination[0] = 0.0);
        assert!(worst[0] == lost && first < 1.0, "{worst:?} {first}");
        let (worst, first) = pitched(20.0, |sensors, _| {
            sensors.specific_force = [0.0, 0.0, GRAVITY];
        });
        assert!(worst[1] == lost && first < 1.0, "{worst:?} {first}");
        let (worst, first) = pitched(20.0, |sensors, _| sensors.angular_rate = [0.0; 3]);
        assert!(worst[2] == lost && first < 1.0, "{worst:?} {first}");
    }

    #[test]
    fn one_stuck_axis_of_a_noisy_unit_is_enough_though_the_robot_rests() {
        let counted = |limit: u32, readings: u32| {
            let mut stuck = Stuck::new(limit);
            for step in 0..readings {
                let noise = 1e-3 * (step % 3) as f32;
                let sensors = BodySensors {
                    specific_force: [noise, 0.2, GRAVITY + noise],
                    angular_rate: [noise; 3],
                    ..BodySensors::default()
                };
                stuck.receive(&sensors, Fresh::ALL);
            }
            [0, 1, 2].map(|sensor| stuck.trust(sensor))
        };
        let accelerometer = |trust| [Trust::Full, trust, Trust::Full];
        assert_eq!(counted(200, 150), [Trust::Full; 3]);
        assert_eq!(
            counted(200, 250),
            accelerometer(Trust::Degraded(Reason::Stuck))
        );
        assert_eq!(counted(200, 450), accelerometer(Trust::None(Reason::Stuck)));
        assert_eq!(counted(0, 1_000), [Trust::Full; 3]);
    }
}

//! Current control of a brushed motor between two half bridges, in fixed point.

use super::axis::{Axis, Gains};
use super::dead_time::sign;
use super::operating_point::OperatingPoint;
use crate::math::cubic::mul_high_add;

/// Current controller of the winding.
#[derive(Clone, Debug)]
pub(super) struct Brushed {
    gains: Gains,
    axis: Axis,
    /// Compare counts that the dead time takes from a half bridge, times 2^10.
    dead_time: i32,
}

impl Brushed {
    /// Creates a controller with an integral of zero. The dead time takes `dead_counts` compare
    /// counts from each half bridge.
    pub fn new(gains: Gains, dead_counts: i32) -> Self {
        Self {
            gains,
            axis: Axis::default(),
            dead_time: dead_counts << 10,
        }
    }

    /// Clears the integral.
    #[inline]
    pub fn reset(&mut self) {
        self.axis.reset();
    }

    /// Computes the compare values of half bridges a and b, and the voltage between them (2^24 is
    /// full scale), from the measured and the demanded current; 2^30 is full scale. Half bridge c
    /// gives half the supply voltage.
    #[inline]
    pub fn step(&mut self, current: i32, demand: i32, point: &OperatingPoint) -> ([u16; 3], i32) {
        let error = (demand >> 1) - (current >> 1);
        let voltage = self.axis.step(self.gains, error, 0, point.circle.bound);
        let half = point.half;
        let counts = |voltage, current| {
            let ideal = mul_high_add(half, voltage, point.counts_per_volt >> 5);
            let compensated = mul_high_add(ideal, sign(current), self.dead_time);
            compensated.max(0).min(point.highest) as u16
        };
        let compare = [
            counts(voltage, current),
            counts(-voltage, -current),
            half as u16,
        ];
        (compare, voltage)
    }
}

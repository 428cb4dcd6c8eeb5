//! Field-oriented current control (FOC) of a three-phase motor in fixed point: computes the compare
//! values of three half bridges from two phase currents. It uses integers only, so that an
//! interrupt that calls it saves no floating-point registers on the stack.
//!
//! Each axis has a PI controller. Feed-forward voltages cancel the coupling of the axes and the
//! back-EMF. The voltage vector stays within the circle that three half bridges can give in every
//! direction; the axis d has priority, because it keeps the flux.

use super::axis::{Axis, Gains};
use super::dead_time::sign;
use super::operating_point::OperatingPoint;
use crate::math::cubic::{mul_high, mul_high_add, quantize};
use crate::math::sin_cos_q30;
use crate::motor::rotor::ElectricalAngle;
use core::num::NonZeroU32;

/// `2 / sqrt 3`, Q30.
const TWO_BY_ROOT_3: i32 = quantize(1.154_700_538_379_251_5, 30);

/// Currents in the rotor's axes; 2^30 is full scale.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Dq {
    /// Component along the magnets' flux.
    pub d: i32,
    /// Component a quarter turn ahead of the flux, which makes the torque.
    pub q: i32,
}

/// Results of one PWM period.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Step {
    /// Compare values of the half bridges.
    pub compare: [u16; 3],
    /// Measured current.
    pub current: Dq,
    /// Voltage for the next period; 2^24 is full scale.
    pub voltage: Dq,
}

/// Current controllers of both axes.
#[derive(Clone, Debug)]
pub struct Foc {
    gains: [Gains; 2],
    d: Axis,
    q: Axis,
    /// Compare counts that the dead time takes from a half bridge, times 2^10.
    dead_time: i32,
}

impl Foc {
    /// Creates controllers of the axes d and q with integrals of zero. The dead time takes
    /// `dead_counts` compare counts from each half bridge.
    pub(super) fn new(gains: [Gains; 2], dead_counts: i32) -> Self {
        Self {
            gains,
            d: Axis::default(),
            q: Axis::default(),
            dead_time: dead_counts << 10,
        }
    }

    /// Clears the integrals.
    #[inline]
    pub fn reset(&mut self) {
        self.d.reset();
        self.q.reset();
    }

    /// Computes the compare values, the measured current and the voltage from the currents of
    /// phases a and b (2^30 is full scale; the three add up to zero), the rotor's angle at their
    /// sample and the demanded current.
    ///
    /// It is defined for every input: larger currents count as full scale, and no compare value
    /// leaves the period. Worst error against double precision: 2 counts of 4250
    /// (`shared/tests/motor/current.rs`). Cost on Cortex-M4: see docs/cost.md.
    #[inline(always)]
    #[allow(clippy::inline_always)] // a second caller must not add a call to the interrupt
    pub fn step(
        &mut self,
        angle: ElectricalAngle,
        currents: [i32; 2],
        demand: Dq,
        point: &OperatingPoint,
    ) -> Step {
        let (sin, cos) = sin_cos_q30(angle.0);
        let [a, b] = currents.map(full_scale);

        let [d, q] = park([a, b], (sin, cos));

        // Axis d, then axis q within what d leaves of the circle.
        let limit = point.voltage_limit;
        let error = ((full_scale(demand.d) >> 4) - d) << 3;
        let coupled = -mul_high(q << 3, point.coupling[1]);
        let voltage_d = self.d.step(self.gains[0], error, coupled, limit);
        let error = ((full_scale(demand.q) >> 4) - q) << 3;
        let coupled = mul_high_add(point.back_emf, d << 3, point.coupling[0]);
        let left = leg_of_circle(limit, voltage_d);
        let voltage_q = self.q.step(self.gains[1], error, coupled, left);

        // Inverse Park transform at the angle at which the voltage acts: 2^22 is the full-scale
        // voltage.
        let [lead_cos, lead_sin] = point.lead;
        let ahead_cos = mul_high_add(mul_high(cos, lead_cos), sin, -lead_sin) << 2;
        let ahead_sin = mul_high_add(mul_high(sin, lead_cos), cos, lead_sin) << 2;
        let stator = unpark([voltage_d, voltage_q], (ahead_sin, ahead_cos));
        let compare = self.modulate(stator, [a, b], point);
        let [d, q] = [d, q].map(|current| current.clamp(-(1 << 26), (1 << 26) - 1) << 4);
        Step {
            compare,
            current: Dq { d, q },
            voltage: Dq {
                d: voltage_d,
                q: voltage_q,
            },
        }
    }

    /// Computes the compare values that give a voltage (2^24 is full scale) in the axes whose angle
    /// has this sine and cosine, without control and without dead-time compensation.
    pub fn open_loop(
        &self,
        voltage: [i32; 2],
        axes: (i32, i32),
        point: &OperatingPoint,
    ) -> [u16; 3] {
        self.modulate(unpark(voltage, axes), [0; 2], point)
    }

    /// Space-vector modulation with dead-time compensation. It shifts all phases equally until the
    /// highest and the lowest phase are equally far from half the supply voltage.
    #[inline]
    fn modulate(
        &self,
        [alpha, beta]: [i32; 2],
        [current_a, current_b]: [i32; 2],
        point: &OperatingPoint,
    ) -> [u16; 3] {
        // sqrt 3 / 2 is a quarter of 3 times 2 / sqrt 3, and the high word is a quarter of Q30.
        let across = mul_high(3 * beta, TWO_BY_ROOT_3);
        let (a, b, c) = (alpha, across - (alpha >> 1), -across - (alpha >> 1));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let low = if c < low { c } else { low };
        let high = if c > high { c } else { high };
        let middle = (low + high) >> 1;
        let counts = |phase: i32, current: i32| {
            let ideal = mul_high_add(point.half, (phase - middle) << 2, point.counts_per_volt);
            mul_high_add(ideal, sign(current), self.dead_time) as u16
        };
        let current_c = -(current_a >> 1) - (current_b >> 1);
        [
            counts(a, current_a),
            counts(b, current_b),
            counts(c, current_c << 1),
        ]
    }
}

/// Clarke and Park transforms of the phases a and b, into the axes whose angle has this sine and
/// cosine. 2^30 becomes 2^26; the result is at most twice as long.
#[inline]
pub(super) fn park([a, b]: [i32; 2], (sin, cos): (i32, i32)) -> [i32; 2] {
    let (alpha, beta) = (a >> 2, mul_high((a >> 1) + b, TWO_BY_ROOT_3));
    [
        mul_high_add(mul_high(alpha, cos), beta, sin),
        mul_high_add(mul_high(beta, cos), alpha, -sin),
    ]
}

/// Inverse Park transform. 2^24 becomes 2^22.
#[inline]
fn unpark([d, q]: [i32; 2], (sin, cos): (i32, i32)) -> [i32; 2] {
    [
        mul_high_add(mul_high(d, cos), q, -sin),
        mul_high_add(mul_high(d, sin), q, cos),
    ]
}

/// Pieces of the table of [`leg_of_circle`], as a power of two.
const PIECE_BITS: u32 = 5;

/// `sqrt(1 - y)` at 33 equal steps of `y`; 2^15 is one.
static LEG: [u16; (1 << PIECE_BITS) + 1] = {
    let mut table = [0; (1 << PIECE_BITS) + 1];
    let mut index = 0;
    while index < table.len() {
        let square = ((1 << PIECE_BITS) - index as u64) << (30 - PIECE_BITS);
        // The integer root, rounded down, so that no chord lies outside of the circle.
        table[index] = square.isqrt() as u16;
        index += 1;
    }
    table
};

/// Returns the largest leg beside `leg` in a right-angled triangle with the hypotenuse `radius`,
/// rounded down: a vector of the two legs never leaves the circle.
///
/// Domain: `0 <= radius < 2^24` and `-radius <= leg <= radius`. It interpolates the root with
/// chords, which lie inside the circle: the result is at most 4.5 % of the radius too small, and
/// 0.02 % while the leg is shorter than half of the radius.
#[inline]
fn leg_of_circle(radius: i32, leg: i32) -> i32 {
    let Some(unit) = NonZeroU32::new(radius as u32 >> 8) else {
        return 0;
    };
    // Ratio of the legs, 2^15 is one; rounded up, so that the result is not too large.
    let ratio = (leg.unsigned_abs() << 7) / unit + 1;
    let square = (ratio * ratio).min(1 << 30);
    let piece = (square >> (30 - PIECE_BITS)) as usize;
    let fraction = square >> (30 - PIECE_BITS - 15) & 0x7fff;
    let (Some(near), Some(far)) = (LEG.get(piece), LEG.get(piece + 1)) else {
        return 0; // the other leg takes the whole radius
    };
    let (near, far) = (u32::from(*near), u32::from(*far));
    let root = near - ((near - far) * fraction).div_ceil(1 << 15);
    (((radius as u32 >> 9) * root) >> 6) as i32
}

/// Limits `value` to full scale.
#[inline]
fn full_scale(value: i32) -> i32 {
    value.clamp(-(1 << 30), (1 << 30) - 1)
}

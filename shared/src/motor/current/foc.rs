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
use crate::math::cubic::{mul_high, mul_high_add, mul_high_sub, quantize};
use crate::math::{Bound, sin_cos_q30};
use crate::motor::rotor::ElectricalAngle;

/// `2 / sqrt 3`, Q30.
const TWO_BY_ROOT_3: i32 = quantize(1.154_700_538_379_251_5, 30);

/// Currents or voltages in the rotor's axes.
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
    /// Measured current; 2^26 is full scale.
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
    /// sample and the demanded current (2^30 is full scale).
    ///
    /// Domain: the currents of all three phases and the demand are at most full scale. No compare
    /// value leaves the period. Worst error against double precision: 2 counts of 4250
    /// (`shared/tests/motor/current.rs`). Cost on Cortex-M4: see `cargo cost`.
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
        let [d, q] = park(currents, (sin, cos));

        // Axis d, then axis q within what d leaves of the circle.
        let circle = &point.circle;
        let error = ((demand.d >> 4) - d) << 3;
        let coupled = -mul_high(q << 3, point.coupling[1]);
        let voltage_d = self.d.step(self.gains[0], error, coupled, circle.bound);
        let error = ((demand.q >> 4) - q) << 3;
        let coupled = mul_high_add(point.back_emf, d << 3, point.coupling[0]);
        let left = circle.beside(voltage_d);
        let voltage_q = self.q.step(self.gains[1], error, coupled, left);

        // Inverse Park transform at the angle at which the voltage acts.
        let [lead_cos, lead_sin] = point.lead;
        let ahead_cos = mul_high_sub(mul_high(cos, lead_cos), sin, lead_sin);
        let ahead_sin = mul_high_add(mul_high(sin, lead_cos), cos, lead_sin);
        let stator = unpark([voltage_d, voltage_q], (ahead_sin, ahead_cos));
        Step {
            compare: self.modulate(stator, currents, point),
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
        (sin, cos): (i32, i32),
        point: &OperatingPoint,
    ) -> [u16; 3] {
        self.modulate(unpark(voltage, (sin >> 2, cos >> 2)), [0; 2], point)
    }

    /// Space-vector modulation of a voltage (2^20 is full scale) with dead-time compensation. It
    /// shifts all phases equally until the highest and the lowest phase are equally far from half
    /// the supply voltage.
    #[inline]
    fn modulate(
        &self,
        [alpha, beta]: [i32; 2],
        [current_a, current_b]: [i32; 2],
        point: &OperatingPoint,
    ) -> [u16; 3] {
        // sqrt 3 / 2 is a quarter of 3 times 2 / sqrt 3, and the high word is a quarter of Q30.
        let across = mul_high(3 * beta, TWO_BY_ROOT_3);
        // Phases a and b, and c with the opposite sign. Phases b and c are `across` away from the
        // mean of the two, and phase a is 3/2 of `alpha` away from it. Where phase a is between
        // them, it is the middle one of the three.
        let (a, b, minus_c) = (alpha, across - (alpha >> 1), across + (alpha >> 1));
        let middle = Bound::of_size(across).limit(alpha + (alpha >> 1)) - (alpha >> 1);
        // The three add up to zero, so the highest and the lowest add up to minus the middle one.
        let shift = middle >> 1;
        let (half, per_volt) = (point.half, point.counts_per_volt);
        let a = mul_high_add(half, a + shift, per_volt);
        let b = mul_high_add(half, b + shift, per_volt);
        let c = mul_high_sub(half, minus_c - shift, per_volt);
        let (sign_a, sign_b) = (sign(current_a), sign(current_b));
        let sign_c = sign(current_a + current_b); // of the current into c
        [
            mul_high_add(a, sign_a, self.dead_time),
            mul_high_add(b, sign_b, self.dead_time),
            mul_high_sub(c, sign_c, self.dead_time),
        ]
        .map(|compare| compare.max(0).min(point.highest) as u16)
    }
}

/// Clarke and Park transforms of the phases a and b, into the axes whose angle has this sine and
/// cosine. 2^30 becomes 2^26; the result is at most twice as long.
#[inline]
pub(super) fn park([a, b]: [i32; 2], (sin, cos): (i32, i32)) -> [i32; 2] {
    let (alpha, beta) = (a >> 2, mul_high((a >> 1) + b, TWO_BY_ROOT_3));
    [
        mul_high_add(mul_high(alpha, cos), beta, sin),
        mul_high_sub(mul_high(beta, cos), alpha, sin),
    ]
}

/// Inverse Park transform from axes whose sine and cosine have 28 fraction bits. 2^24 becomes 2^20.
#[inline]
fn unpark([d, q]: [i32; 2], (sin, cos): (i32, i32)) -> [i32; 2] {
    [
        mul_high_sub(mul_high(d, cos), q, sin),
        mul_high_add(mul_high(d, sin), q, cos),
    ]
}

//! Field-oriented current control (FOC) of a three-phase motor in fixed point: computes the compare
//! values of three half bridges from two phase currents. It uses integers only, so that an
//! interrupt that calls it saves no floating-point registers on the stack.
//!
//! Currents count in fractions of [`Config::current_full_scale`]. Voltages count in fractions of
//! the voltage limit. This limit is `1 / sqrt 3` of the supply voltage, the largest amplitude that
//! three half bridges can give in every direction. It is 2^24, so that one instruction (SSAT)
//! limits a voltage.

use crate::math::cubic::{mul_high, mul_high_add, quantize};
use crate::math::sin_cos_q30;
use crate::units::Angle;

const ROOT_3: f32 = 1.732_050_8;
/// `2 / sqrt 3`, Q30.
const TWO_BY_ROOT_3: i32 = quantize(1.154_700_538_379_251_5, 30);

/// Electrical angle. It makes one turn per pole pair and must not be confused with the mechanical
/// angle of the rotor.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ElectricalAngle(pub Angle);

/// Vector in the rotor's axes, Q30: 2^30 is full scale, and larger components are limited to it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Dq {
    /// Component along the magnet's flux.
    pub d: i32,
    /// Component a quarter turn ahead of the flux, which makes the torque.
    pub q: i32,
}

/// Parameters of the motor, the bridge and the current measurement. All must be finite and above
/// zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Config {
    /// Resistance of one phase, ohm.
    pub resistance: f32,
    /// Inductance of one phase, henry.
    pub inductance: f32,
    /// Supply voltage for which the gains are computed, V.
    pub supply_voltage: f32,
    /// Current at full scale (2^30), A.
    pub current_full_scale: f32,
    /// Bandwidth of the closed loop, rad/s; at most a quarter of the rate.
    pub bandwidth: f32,
    /// Calls of [`Foc::step`] per second.
    pub rate_hz: f32,
    /// Compare value of a half bridge that is always on; 2 to 2^16.
    pub period: u32,
}

/// Reason why a controller cannot be created.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum FocError {
    /// A value of the configuration is outside of its stated range or not finite.
    OutOfRange,
    /// A gain exceeds its fixed-point format. The loop would be too fast for this winding, supply
    /// voltage and current scale.
    GainTooLarge {
        /// Proportional gain, voltage limits per full-scale current; must be below 16.
        proportional: f32,
        /// Integral gain per period; must be below 0.25.
        integral: f32,
    },
}

/// Current controllers of both axes.
///
/// The integral of an axis does not change while the voltage of that axis is limited. The integral
/// alone never exceeds the limit, so an error of the other sign always ends the limitation.
#[derive(Clone, Debug)]
pub struct Foc {
    /// Proportional gain; 2^27 is one.
    proportional: i32,
    /// Integral gain per period; 2^33 is one.
    integral_gain: i32,
    /// Integrals of the axes d and q; 2^30 is the voltage limit.
    integral: [i32; 2],
    /// Compare value of half the supply voltage.
    half: i32,
}

impl Foc {
    /// Creates a controller whose zero cancels the pole of the winding: `Kp = w L`, `Ki = w R`.
    ///
    /// # Errors
    /// [`FocError`] if a value is out of range, or if a gain is too large.
    pub fn new(config: &Config) -> Result<Self, FocError> {
        let values = [
            config.resistance,
            config.inductance,
            config.supply_voltage,
            config.current_full_scale,
            config.bandwidth,
            config.rate_hz,
        ];
        let good = values.iter().all(|value| *value > 0.0 && value.is_finite());
        if !good
            || config.bandwidth > config.rate_hz / 4.0
            || !(2..=1 << 16).contains(&config.period)
        {
            return Err(FocError::OutOfRange);
        }
        let limit = config.supply_voltage / ROOT_3;
        let per_ampere = config.bandwidth * config.current_full_scale / limit;
        let proportional = per_ampere * config.inductance;
        let integral = per_ampere * config.resistance / config.rate_hz;
        if !(proportional < 16.0 && integral < 0.25) {
            return Err(FocError::GainTooLarge {
                proportional,
                integral,
            });
        }
        Ok(Self {
            proportional: (proportional * (1_u64 << 27) as f32) as i32,
            integral_gain: (integral * (1_u64 << 33) as f32) as i32,
            integral: [0; 2],
            half: (config.period / 2) as i32,
        })
    }

    /// Clears the integrals. Call it after the bridge was off.
    pub fn reset(&mut self) {
        self.integral = [0; 2];
    }

    /// Computes the compare values of the three half bridges, each from 0 to the period, from the
    /// currents of phases a and b, the rotor's electrical angle and the demanded current. Currents
    /// are Q30; the current of phase c is the negative sum of the other two.
    ///
    /// It is defined for every input: all results are in range. Worst error against double
    /// precision: one count of 4250 (`shared/tests/motor/foc.rs`). Cost on Cortex-M4: see
    /// docs/cost.md.
    #[inline]
    pub fn step(&mut self, angle: ElectricalAngle, currents: [i32; 2], demand: Dq) -> [u16; 3] {
        let (sin, cos) = sin_cos_q30(angle.0);
        let [a, b] = currents.map(full_scale);

        // Clarke transform: 2^28 is full scale.
        let (alpha, beta) = (a >> 2, mul_high((a >> 1) + b, TWO_BY_ROOT_3));
        // Park transform: 2^26 is full scale. The result is at most twice that.
        let d = mul_high_add(mul_high(alpha, cos), beta, sin);
        let q = mul_high_add(mul_high(beta, cos), alpha, -sin);

        let d = self.control::<0>(full_scale(demand.d), d);
        let q = self.control::<1>(full_scale(demand.q), q);

        // Inverse Park transform, back to the stator's axes: 2^22 is the voltage limit.
        let alpha = mul_high_add(mul_high(d, cos), q, -sin);
        let beta = mul_high_add(mul_high(d, sin), q, cos);
        self.modulate(alpha, beta)
    }

    /// Computes the voltage of one axis, whose limit is 2^24, from a demand (full scale 2^30) and a
    /// current (full scale 2^26).
    #[inline]
    fn control<const AXIS: usize>(&mut self, demand: i32, current: i32) -> i32 {
        // At most three times full scale. This fits with a full scale of 2^29.
        let error = ((demand >> 4) - current) << 3;
        let before = self.integral[AXIS];
        // Rounded, because a sum of truncated products would drift.
        let integral =
            mul_high_add(before, error, self.integral_gain).clamp(-(1 << 30), (1 << 30) - 1);
        let wanted = mul_high_add(integral >> 6, error, self.proportional);
        let voltage = wanted.clamp(-(1 << 24), (1 << 24) - 1);
        self.integral[AXIS] = if voltage == wanted { integral } else { before };
        voltage
    }

    /// Space-vector modulation: shifts all phases equally until the highest and the lowest phase
    /// are equally far from the middle.
    #[inline]
    fn modulate(&self, alpha: i32, beta: i32) -> [u16; 3] {
        // Phases in fractions of half the supply voltage, with 2^22 as one. This is 2 / sqrt 3
        // times their value in fractions of the voltage limit.
        let a = mul_high(alpha << 2, TWO_BY_ROOT_3);
        let (b, c) = (beta - (a >> 1), -beta - (a >> 1));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let low = if c < low { c } else { low };
        let high = if c > high { c } else { high };
        let middle = (low + high) >> 1;
        [a, b, c].map(|phase| {
            let share = (phase - middle).clamp(-(1 << 22), (1 << 22) - 1);
            mul_high_add(self.half, share, self.half << 10) as u16
        })
    }
}

/// Limits `value` to full scale.
#[inline]
fn full_scale(value: i32) -> i32 {
    value.clamp(-(1 << 30), (1 << 30) - 1)
}

//! Field-oriented current control of a three-phase motor in fixed point: from two phase currents to the compare values of three half
//! bridges. Integers alone, so that an interrupt that calls it stacks no floating-point registers.
//!
//! Currents are shares of [`Config::current_full_scale`]. Voltages are shares of `1 / sqrt 3` of the supply, the largest amplitude that three
//! half bridges can give in every direction: 2^24 is that limit, so that limiting is one instruction (SSAT).

use crate::math::cubic::{mul_high, mul_high_add, quantize};
use crate::math::sin_cos_q30;
use crate::units::Angle;

const ROOT_3: f32 = 1.732_050_8;
/// `2 / sqrt 3`, Q30.
const TWO_BY_ROOT_3: i32 = quantize(1.154_700_538_379_251_5, 30);

/// Electrical angle, which goes round once per pole pair: not to be mixed up with the rotor's mechanical one.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ElectricalAngle(pub Angle);

/// A vector in the rotor's axes, Q30: 2^30 is full scale, more is limited to it.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Dq {
    /// Along the magnet's flux.
    pub d: i32,
    /// A quarter turn ahead: torque.
    pub q: i32,
}

/// What the controller must know of the motor, the bridge and the sensing; all finite and above zero.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Config {
    /// Resistance of one phase, ohm.
    pub resistance: f32,
    /// Inductance of one phase, henry.
    pub inductance: f32,
    /// Supply that the gains are made for, V.
    pub supply_voltage: f32,
    /// Current of 2^30, A.
    pub current_full_scale: f32,
    /// Bandwidth of the closed loop, rad/s; at most a quarter of the rate.
    pub bandwidth: f32,
    /// Calls of [`Foc::step`] per second.
    pub rate_hz: f32,
    /// Compare value of a half bridge that is always on; at most 2^16.
    pub period: u32,
}

/// Why there is no controller.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum FocError {
    /// A value of the configuration is outside of what it says, or no number.
    OutOfRange,
    /// A gain is beyond its fixed-point format: the loop would be too fast for this winding, supply and current scale.
    GainTooLarge {
        /// Proportional gain, shares of the voltage limit per full-scale current; below 16.
        proportional: f32,
        /// Integral gain in one period; below 0.25.
        integral: f32,
    },
}

/// Current controllers of both axes. The integral of an axis stands still while that axis' voltage is limited; as the integral alone never
/// exceeds the limit, an error of the other sign always frees it.
#[derive(Clone, Debug)]
pub struct Foc {
    /// 2^27 is one.
    proportional: i32,
    /// 2^33 is one.
    integral_gain: i32,
    /// 2^30 is the voltage limit; d, q.
    integral: [i32; 2],
    /// Compare value of half the supply.
    half: i32,
}

impl Foc {
    /// Controller whose zero cancels the winding's pole: `Kp = w L`, `Ki = w R`.
    ///
    /// # Errors
    /// [`FocError`].
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

    /// Forgets the past: for a bridge that was off.
    pub fn reset(&mut self) {
        self.integral = [0; 2];
    }

    /// Compare values of the three half bridges, each from 0 to the period, for the currents of phases a and b (Q30, the third is their
    /// negative sum), the rotor's angle, and the demanded current.
    ///
    /// Total: every input gives values in range. Worst error against double precision: one count of 4250
    /// (`shared/tests/motor/foc.rs`). Cost on Cortex-M4: see docs/cost.md.
    #[inline]
    pub fn step(&mut self, angle: ElectricalAngle, currents: [i32; 2], demand: Dq) -> [u16; 3] {
        let (sin, cos) = sin_cos_q30(angle.0);
        let [a, b] = currents.map(full_scale);

        // Clarke: 2^28 is full scale.
        let (alpha, beta) = (a >> 2, mul_high((a >> 1) + b, TWO_BY_ROOT_3));
        // Park: 2^26 is full scale; at most twice that.
        let d = mul_high_add(mul_high(alpha, cos), beta, sin);
        let q = mul_high_add(mul_high(beta, cos), alpha, -sin);

        let d = self.control::<0>(full_scale(demand.d), d);
        let q = self.control::<1>(full_scale(demand.q), q);

        // Back to the stator's axes: 2^22 is the voltage limit.
        let alpha = mul_high_add(mul_high(d, cos), q, -sin);
        let beta = mul_high_add(mul_high(d, sin), q, cos);
        self.modulate(alpha, beta)
    }

    /// Voltage of one axis (2^24 is the limit) for a demand with 2^30 and a current with 2^26 at full scale.
    #[inline]
    fn control<const AXIS: usize>(&mut self, demand: i32, current: i32) -> i32 {
        // At most three times full scale: 2^29 each still fits.
        let error = ((demand >> 4) - current) << 3;
        let before = self.integral[AXIS];
        // Rounded: a sum of truncated products would drift.
        let integral =
            mul_high_add(before, error, self.integral_gain).clamp(-(1 << 30), (1 << 30) - 1);
        let wanted = mul_high_add(integral >> 6, error, self.proportional);
        let voltage = wanted.clamp(-(1 << 24), (1 << 24) - 1);
        self.integral[AXIS] = if voltage == wanted { integral } else { before };
        voltage
    }

    /// Space-vector modulation by shifting all phases alike until the highest and the lowest are as far from the middle.
    #[inline]
    fn modulate(&self, alpha: i32, beta: i32) -> [u16; 3] {
        // Phases in shares of half the supply, 2^22 being one: 2 / sqrt 3 times what they are in shares of the limit.
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

/// `value` within the scale.
#[inline]
fn full_scale(value: i32) -> i32 {
    value.clamp(-(1 << 30), (1 << 30) - 1)
}

//! Current loop of a brushed motor. It runs in the PWM interrupt.

use crate::math::limit;
use core::fmt;

/// Parameters of the winding and the bridge that the loop needs.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Winding {
    /// Resistance of winding and bridge, ohm; above zero.
    pub resistance: f32,
    /// Inductance, henry; above zero.
    pub inductance: f32,
    /// Largest current that the loop demands, A; above zero.
    pub current_limit: f32,
}

/// Reason why a loop cannot be created.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum CurrentLoopError {
    /// A value is not finite, or not above zero.
    NotPositive {
        /// Name of the value.
        name: &'static str,
        /// The value.
        got: f32,
    },
    /// The bandwidth leaves fewer than four PWM periods per radian. The delay of a period and a
    /// half would then cost more than 21 degrees of phase margin.
    BandwidthTooHigh {
        /// The given bandwidth, rad/s.
        got: f32,
        /// The largest bandwidth at this PWM rate, rad/s.
        maximum: f32,
    },
}

impl fmt::Display for CurrentLoopError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotPositive { name, got } => write!(out, "{name} = {got} must be above zero"),
            Self::BandwidthTooHigh { got, maximum } => {
                write!(
                    out,
                    "bandwidth = {got} rad/s, at most {maximum} at this PWM rate"
                )
            }
        }
    }
}

/// Largest duty cycle. In the rest of each period a low-side transistor stays closed long enough to
/// sample the current.
pub const MAX_DUTY: f32 = 0.95;
/// Lowest supply voltage at which the bridge is driven, V. Below it, and if the supply voltage is
/// unknown, the duty cycle is 0.
pub const MIN_BUS_VOLTAGE: f32 = 5.0;

/// Proportional-integral (PI) current loop. Its zero cancels the pole of the winding: `Kp = w L`
/// and `Ki = w R` give a closed loop of first order with the bandwidth `w`.
///
/// While the voltage is limited, back-calculation with the time constant `L / R` (Astrom and
/// Hagglund, "Advanced PID Control", section 3.5) keeps the integral at what the bridge can
/// deliver.
#[derive(Clone, Debug)]
pub struct CurrentLoop {
    proportional: f32,     // V/A
    integral_gain: f32,    // V/A per period
    back_calculation: f32, // fraction of the excess that one period removes
    current_limit: f32,    // A
    integral: f32,         // V
}

impl CurrentLoop {
    /// Creates a loop of `bandwidth` rad/s for `winding`, which is called `rate_hz` times a second.
    ///
    /// # Errors
    /// A value of `winding`, the bandwidth or the rate is not finite and positive, or the bandwidth
    /// is above `rate_hz / 4`.
    pub fn new(winding: &Winding, bandwidth: f32, rate_hz: f32) -> Result<Self, CurrentLoopError> {
        for (name, got) in [
            ("resistance", winding.resistance),
            ("inductance", winding.inductance),
            ("current limit", winding.current_limit),
            ("bandwidth", bandwidth),
            ("rate", rate_hz),
        ] {
            if !(got > 0.0 && got.is_finite()) {
                return Err(CurrentLoopError::NotPositive { name, got });
            }
        }
        let maximum = rate_hz / 4.0;
        if bandwidth > maximum {
            return Err(CurrentLoopError::BandwidthTooHigh {
                got: bandwidth,
                maximum,
            });
        }
        Ok(Self {
            proportional: bandwidth * winding.inductance,
            integral_gain: bandwidth * winding.resistance / rate_hz,
            back_calculation: limit(winding.resistance / (winding.inductance * rate_hz), 1.0),
            current_limit: winding.current_limit,
            integral: 0.0,
        })
    }

    /// Returns whether the windings may stay shorted at this current, A. A shorted motor that turns
    /// drives a current that only its resistance limits. Beyond the current limit the bridge opens
    /// until the next sample. False for NaN.
    #[inline]
    pub fn may_brake(&self, sample: f32) -> bool {
        sample.abs() <= self.current_limit
    }

    /// Computes the duty cycle of the next PWM period, from -[`MAX_DUTY`] to [`MAX_DUTY`], from the
    /// sampled current (A), the demanded current (A) and the supply voltage (V).
    ///
    /// It is defined for every input. An infinite demand is limited. A demand that is NaN, a sample
    /// that is not finite, and a supply voltage that is not finite or below [`MIN_BUS_VOLTAGE`]
    /// give 0 and clear the integral.
    #[inline]
    pub fn step(&mut self, sample: f32, demand: f32, supply_voltage: f32) -> f32 {
        let usable = sample.is_finite()
            && !demand.is_nan()
            && supply_voltage.is_finite()
            && supply_voltage >= MIN_BUS_VOLTAGE;
        if !usable {
            self.reset();
            return 0.0;
        }
        let error = limit(demand, self.current_limit) - sample;
        let available = MAX_DUTY * supply_voltage;
        let wanted = self.proportional * error + self.integral;
        let voltage = limit(wanted, available);
        let integral =
            self.integral + self.integral_gain * error + self.back_calculation * (voltage - wanted);
        // A sample near the largest float can make the products overflow. The integral then starts
        // again from 0; the voltage is limited in any case.
        self.integral = if integral.is_finite() { integral } else { 0.0 };
        limit(voltage / supply_voltage, MAX_DUTY)
    }

    /// Clears the integral. Call it after the bridge was off.
    pub fn reset(&mut self) {
        self.integral = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WINDING: Winding = Winding {
        resistance: 0.4,
        inductance: 4e-4,
        current_limit: 20.0,
    };
    const RATE: f32 = 20_000.0;
    const BANDWIDTH: f32 = 2_000.0;

    /// Solves `L di/dt = u - R i - e` exactly over one period in `f64`, independently of the loop's
    /// arithmetic.
    fn winding_after(current: f64, voltage: f64) -> f64 {
        let (r, l, t) = (
            f64::from(WINDING.resistance),
            f64::from(WINDING.inductance),
            1.0 / f64::from(RATE),
        );
        let settled = voltage / r;
        // exp from its series: `no_std` tests have no libm, and the argument is only -0.05.
        let x = -r * t / l;
        let decay = (1..12)
            .rev()
            .fold(1.0, |sum, n| 1.0 + sum * x / f64::from(n));
        settled + (current - settled) * decay
    }

    fn run(
        demand: f32,
        back_emf: f64,
        supply_voltage: f32,
        periods: usize,
    ) -> (f64, f64, CurrentLoop) {
        let mut current_loop = CurrentLoop::new(&WINDING, BANDWIDTH, RATE).unwrap();
        let (mut current, mut duty, mut peak) = (0.0, 0.0, 0.0_f64);
        for _ in 0..periods {
            let next = current_loop.step(current as f32, demand, supply_voltage);
            current = winding_after(
                current,
                f64::from(duty) * f64::from(supply_voltage) - back_emf,
            );
            duty = next;
            if current.abs() > peak {
                peak = current.abs();
            }
        }
        (current, peak, current_loop)
    }

    #[test]
    fn step_rises_with_the_asked_bandwidth_and_settles_without_error() {
        let (after_one_time_constant, _, _) = run(5.0, 0.0, 24.0, 12); // 10 periods + 2 of delay
        assert!(
            (after_one_time_constant - 5.0 * 0.632).abs() < 0.5,
            "{after_one_time_constant}"
        );
        let (settled, peak, _) = run(5.0, 6.0, 24.0, 4_000);
        assert!((settled - 5.0).abs() < 1e-3, "{settled}");
        assert!(peak < 9.5, "the step of the back-EMF alone draws {peak} A");
    }

    #[test]
    fn demand_above_the_limit_gives_the_limit() {
        let (settled, peak, _) = run(f32::INFINITY, 0.0, 48.0, 4_000);
        assert!((settled - 20.0).abs() < 1e-2, "{settled}");
        assert!(peak < 21.5, "{peak}");
    }

    #[test]
    fn saturation_leaves_no_windup_behind() {
        // 20 A need 8 V plus 10 V of back-EMF. A supply of 12 V cannot give that.
        let mut current_loop = run(20.0, 10.0, 12.0, 20_000).2;
        let mut current = 3.5;
        for _ in 0..60 {
            let duty = current_loop.step(current as f32, 0.0, 12.0);
            current = winding_after(current, f64::from(duty) * 12.0 - 10.0);
        }
        assert!(current.abs() < 1.0, "still {current} A after 3 ms");
    }

    #[test]
    fn duty_is_finite_and_bounded_for_any_input() {
        let values = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            24.0,
            1e-40,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
            5.0,
            -300.0,
        ];
        let mut current_loop = CurrentLoop::new(&WINDING, BANDWIDTH, RATE).unwrap();
        for sample in values {
            for demand in values {
                for voltage in values {
                    let duty = current_loop.step(sample, demand, voltage);
                    assert!(
                        duty.abs() <= MAX_DUTY,
                        "{duty} from {sample} {demand} {voltage}"
                    );
                    assert!(current_loop.integral.is_finite());
                }
            }
        }
        assert_eq!(current_loop.step(f32::NAN, 5.0, 24.0), 0.0);
        assert_eq!(current_loop.step(0.0, f32::NAN, 24.0), 0.0);
        assert_eq!(current_loop.step(0.0, 5.0, 4.9), 0.0);
    }

    #[test]
    fn refuses_what_it_cannot_control() {
        let dead = Winding {
            inductance: 0.0,
            ..WINDING
        };
        assert!(matches!(
            CurrentLoop::new(&dead, BANDWIDTH, RATE),
            Err(CurrentLoopError::NotPositive {
                name: "inductance",
                ..
            })
        ));
        assert!(matches!(
            CurrentLoop::new(&WINDING, f32::NAN, RATE),
            Err(CurrentLoopError::NotPositive { .. })
        ));
        assert!(matches!(
            CurrentLoop::new(&WINDING, 5_001.0, RATE),
            Err(CurrentLoopError::BandwidthTooHigh { .. })
        ));
    }
}

//! Proportional-integral (PI) controller of one current in fixed point.
//!
//! Its zero cancels the pole of the winding: `Kp = w L` and `Ki = w R` give a closed loop of first
//! order with the bandwidth `w`.

use super::{CurrentLoopError, VOLTAGE_FULL_SCALE};
use crate::math::Bound;
use crate::math::cubic::{mul_high, mul_high_add};
use crate::motor::bridge::Ratings;

/// Gains of a controller.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Gains {
    /// 2^27 is one full-scale voltage per full-scale current.
    proportional: i32,
    /// The same per period; 2^29 is one.
    integral: i32,
}

/// Winding and sampling of one axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct Winding {
    /// Resistance, ohm.
    pub resistance: f32,
    /// Inductance, henry.
    pub inductance: f32,
    /// Bandwidth of the closed loop, rad/s.
    pub bandwidth: f32,
    /// Full scale of the current, A.
    pub full_scale: f32,
    /// Calls per second.
    pub rate_hz: f32,
}

/// Bounds of the gains in their fixed-point formats.
const PROPORTIONAL: f32 = 16.0;
const INTEGRAL: f32 = 4.0;

/// Returns the bandwidth, rad/s, above which a gain of a winding with this resistance, ohm, and
/// inductance, H, exceeds its format at a power stage.
pub fn bandwidth_bound(resistance: f32, inductance: f32, ratings: &Ratings) -> f32 {
    let scale = VOLTAGE_FULL_SCALE / ratings.full_scale;
    let of_inductance = PROPORTIONAL * scale / inductance;
    let of_resistance = INTEGRAL * scale * ratings.pwm_hz as f32 / resistance;
    of_inductance.min(of_resistance)
}

impl Gains {
    /// Computes the gains.
    ///
    /// # Errors
    /// [`CurrentLoopError::GainTooLarge`] if a gain exceeds its fixed-point format.
    pub fn new(winding: &Winding) -> Result<Self, CurrentLoopError> {
        let per_ampere = winding.bandwidth * winding.full_scale / VOLTAGE_FULL_SCALE;
        let proportional = per_ampere * winding.inductance;
        let integral = per_ampere * winding.resistance / winding.rate_hz;
        let maximum = VOLTAGE_FULL_SCALE / winding.full_scale;
        for (name, gain, largest, got, maximum) in [
            (
                "inductance",
                proportional,
                PROPORTIONAL,
                winding.bandwidth * winding.inductance,
                PROPORTIONAL * maximum,
            ),
            (
                "resistance",
                integral,
                INTEGRAL,
                winding.bandwidth * winding.resistance,
                INTEGRAL * maximum * winding.rate_hz,
            ),
        ] {
            if !(gain < largest) {
                return Err(CurrentLoopError::GainTooLarge { name, got, maximum });
            }
        }
        Ok(Self {
            proportional: (proportional * (1 << 27) as f32) as i32,
            integral: (integral * (1 << 29) as f32) as i32,
        })
    }
}

/// State of a controller: the integral of the error. 2^26 is the full-scale voltage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Axis {
    integral: i32,
}

impl Axis {
    /// Clears the integral.
    #[inline]
    pub fn reset(&mut self) {
        self.integral = 0;
    }

    /// Computes the voltage, within `limit`; 2^24 is the full scale. `error` is the
    /// missing current (2^29 is the full scale, at most three times that). `feed_forward` is a
    /// voltage below 2^30.
    ///
    /// While the voltage is limited, the integral changes only in the direction that ends the
    /// limitation. So it does not wind up.
    #[inline]
    pub fn step(&mut self, gains: Gains, error: i32, feed_forward: i32, limit: Bound) -> i32 {
        // Rounded, because a sum of truncated products would drift.
        let integral =
            mul_high_add(self.integral, error, gains.integral).clamp(-(1 << 26), (1 << 26) - 1);
        let wanted = mul_high_add((integral >> 2) + feed_forward, error, gains.proportional);
        let voltage = limit.limit(wanted);
        // The high word of the product counts: an excess too small for it does no harm.
        if mul_high(wanted - voltage, error) <= 0 {
            self.integral = integral;
        }
        voltage
    }
}

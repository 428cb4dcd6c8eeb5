//! Measures inductances: a square wave of the voltage, synchronous with the PWM, causes a ripple of
//! the current.
//!
//! With the amplitude `U` and the half period `T`, half of the peak-to-peak current is
//! `U / R tanh(R T / 2 L)`. Two amplitudes are compared, so that the dead time of the bridge
//! cancels. The mean current is 0, so the rotor stands.

use super::record::{Quantity, Refusal};
use super::tick::Tick;
use crate::motor::current::{Excitation, Frame};
use core::num::NonZeroU32;

/// Half of the peak-to-peak current, as a fraction of the largest current.
const LEVELS: [f32; 2] = [0.5, 1.0];
/// First and largest amplitude of the voltage, as a fraction of the bridge's.
const FIRST: f32 = 0.01;
const LARGEST: f32 = 0.6;
/// Longest half of the ripple, PWM periods.
const LONGEST: u32 = 128;
/// Ticks in which a new amplitude settles, and ticks for which it is then measured: briefly to
/// adjust it, and longer for the result.
const SETTLE: u32 = 4;
const BRIEF: u32 = 16;
const LONG: u32 = 300;
/// Largest `tanh` with which the inductance can be told from the resistance.
const LARGEST_TANH: f32 = 0.9;

/// Response of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    /// Half of the peak-to-peak current per voltage, A/V.
    admittance: f32,
    /// Half of the period, s.
    half_period: f32,
}

impl Response {
    /// Computes the inductance, henry, with the resistance, ohm.
    pub fn inductance(self, resistance: f32) -> Result<f32, Refusal> {
        let tanh = self.admittance * resistance;
        if !(tanh <= LARGEST_TANH && tanh > 0.0) {
            return Err(Refusal::OutOfBounds {
                quantity: Quantity::Inductance,
                got: self.rough(),
                // The inductance at the bound, by the inverse of tanh(1.472) = 0.9.
                bound: resistance * self.half_period / (2.0 * 1.472),
            });
        }
        Ok(resistance * self.half_period / (2.0 * inverse_tanh(tanh)))
    }

    /// Inductance, henry, without regard to the resistance.
    pub fn rough(self) -> f32 {
        0.5 * self.half_period / self.admittance
    }
}

/// Inverse of the hyperbolic tangent from 0 to 0.9, by its continued fraction (Abramowitz and
/// Stegun, 4.6.22 at an imaginary argument). Error: below 2e-4 of the result.
fn inverse_tanh(y: f32) -> f32 {
    let square = y * y;
    let below = (1..=9).rev().fold(19.0, |sum, n| {
        let n = n as f32;
        2.0 * n - 1.0 - n * n * square / sum
    });
    y / below
}

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Inductance {
    frame: Frame,
    axes: usize,
    axis: usize,
    level: usize,
    amplitude: f32,
    half: u32,
    measuring: bool,
    ticks: u32,
    /// Sum and number of the samples of the response.
    sum: f32,
    samples: u32,
    /// Amplitude and response at the lower level.
    low: [f32; 2],
    found: [Response; 2],
}

impl Inductance {
    /// Begins in the axis d of `frame`; measures one axis or two.
    pub fn new(frame: Frame, axes: usize) -> Self {
        Self {
            frame,
            axes,
            axis: 0,
            level: 0,
            amplitude: 0.0,
            half: 1,
            measuring: false,
            ticks: 0,
            sum: 0.0,
            samples: 0,
            low: [0.0; 2],
            found: [Response::default(); 2],
        }
    }

    /// Runs one tick.
    pub fn tick(
        &mut self,
        tick: &Tick,
        excitation: &mut Excitation,
    ) -> Result<Option<[Response; 2]>, Refusal> {
        if self.amplitude == 0.0 {
            self.amplitude = FIRST * tick.limit;
        } else {
            self.listen(tick)?;
        }
        if self.axis == self.axes {
            return Ok(Some(self.found));
        }
        if let Some(amplitude) = excitation.ripple.get_mut(self.axis) {
            *amplitude = self.amplitude;
        }
        excitation.frame = self.frame;
        excitation.half_period = NonZeroU32::new(self.half).unwrap_or(NonZeroU32::MIN);
        Ok(None)
    }

    /// Collects samples, and evaluates them when there are enough.
    fn listen(&mut self, tick: &Tick) -> Result<(), Refusal> {
        self.ticks += 1;
        if self.ticks > SETTLE {
            let mean = tick.measured.response.get(self.axis).copied();
            self.sum += mean.unwrap_or_default() * tick.measured.responses as f32;
            self.samples += tick.measured.responses;
        }
        let enough = if self.measuring { LONG } else { BRIEF };
        if self.ticks < SETTLE + enough {
            return Ok(());
        }
        let response = self.sum / self.samples as f32;
        (self.ticks, self.sum, self.samples) = (0, 0.0, 0);
        if self.measuring {
            self.measuring = false;
            self.evaluate(tick, response);
            return Ok(());
        }
        self.adjust(tick, response)
    }

    fn adjust(&mut self, tick: &Tick, got: f32) -> Result<(), Refusal> {
        let wanted = LEVELS.get(self.level).copied().unwrap_or_default() * tick.plan.current;
        if got >= 0.9 * wanted {
            if self.amplitude <= FIRST * tick.limit && got > 2.0 * wanted {
                return Err(Refusal::OutOfBounds {
                    quantity: Quantity::Inductance,
                    got: 0.5 * self.half as f32 * tick.pwm_period() * self.amplitude / got,
                    bound: 0.25 * tick.pwm_period() * self.amplitude / wanted,
                });
            }
            self.measuring = true;
            return Ok(());
        }
        // Half as much again at most, because the dead time hides small voltages.
        let growth = crate::math::clamp(wanted / got, 1.05, 1.5);
        self.amplitude *= if got > 0.0 { growth } else { 1.5 };
        if self.amplitude > LARGEST * tick.limit {
            self.half *= 2;
            self.amplitude *= 0.4;
            self.level = 0;
            let bound = 0.5 * LONGEST as f32 * tick.pwm_period() * LARGEST * tick.limit / wanted;
            if self.half > LONGEST {
                return Err(Refusal::OutOfBounds {
                    quantity: Quantity::Inductance,
                    got: bound * wanted / got,
                    bound,
                });
            }
        }
        Ok(())
    }

    fn evaluate(&mut self, tick: &Tick, response: f32) {
        if self.level == 0 {
            self.low = [self.amplitude, response];
            self.level = 1;
            self.amplitude *= 1.5;
            return;
        }
        let [amplitude, low] = self.low;
        if let Some(found) = self.found.get_mut(self.axis) {
            *found = Response {
                admittance: (response - low) / (self.amplitude - amplitude),
                half_period: self.half as f32 * tick.pwm_period(),
            };
        }
        self.axis += 1;
        self.level = 0;
        self.half = 1;
        self.amplitude = FIRST * tick.limit;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_of_tanh_keeps_its_error() {
        for step in 1..=900 {
            let y = f64::from(step) * 1e-3;
            let expected = 0.5 * ((1.0 + y) / (1.0 - y)).ln();
            let error = f64::from(inverse_tanh(y as f32)) / expected - 1.0;
            assert!(error.abs() < 2e-4, "{y}: {error}");
        }
    }
}

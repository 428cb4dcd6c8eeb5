//! Measures the resistance of a brushed motor: a voltage of changing sign swings the rotor forth
//! and back, so that much current flows at little speed.
//!
//! A least-squares fit explains the voltage, less back-EMF and self-induction, by the current and
//! its direction. The second term is the voltage that dead time and brushes take.

use super::record::{Quantity, Refusal};
use super::tick::{Tick, check_at_least, check_at_most};
use crate::constants::CONTROL_PERIOD;
use crate::math::{max, sqrt};
use crate::motor::current::Excitation;

/// Duration of one direction, s.
const HALF: f32 = 0.01;
/// Amplitude at the start, as a fraction of the bridge's voltage, its growth per half, and its
/// bound.
const FIRST: f32 = 0.01;
const GROWTH: f32 = 1.08;
const LARGEST: f32 = 0.9;
/// Current that ends the growth, as a fraction of the largest.
const ENOUGH: f32 = 0.8;
/// The measured halves have amplitudes from this part to the whole. They are spread by the golden
/// ratio, so that the steps of a coarse encoder fall differently each time.
const SMALLEST_PART: f32 = 0.3;
const GOLDEN_RATIO: f32 = 0.618_034;
/// Fewest and most measured halves, and the standard error of the resistance that ends the
/// measurement between them.
const FEWEST_HALVES: u32 = 100;
const MOST_HALVES: u32 = 2400;
const ENOUGH_KNOWN: f32 = 0.008;
/// Ticks after each change of the voltage that are not used, and smallest number that is.
const SKIPPED: u32 = 3;
const FEWEST: u32 = 3;
/// Smallest current that is used, as a fraction of the largest. Below it, the dead time acts only
/// partly.
const SMALLEST: f32 = 0.25;
/// How far the speed may exceed its bound before the calibration ends.
const EXCESS: f32 = 1.3;
/// Largest standard error of the resistance, as a fraction.
const LARGEST_ERROR: f32 = 0.02;

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Swing {
    /// Inductance, henry, roughly, and back-EMF constant, V s/rad.
    inductance: f32,
    back_emf: f32,
    amplitude: f32,
    negative: bool,
    ticks: u32,
    /// Halves since the amplitude was found.
    measured: Option<u32>,
    part: f32,
    largest: f32,
    window: Window,
    fit: Fit,
}

/// Result of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Resistance, ohm.
    pub resistance: f32,
    /// Standard error of the resistance, as a fraction.
    pub residual: f32,
}

impl Swing {
    /// Begins with a rough inductance, henry, and the torque constant, N m/A.
    pub fn new(inductance: f32, torque_constant: f32) -> Self {
        Self {
            inductance,
            back_emf: torque_constant,
            amplitude: 0.0,
            negative: false,
            // The first half is short, so that the rotor swings about its place.
            ticks: 5,
            measured: None,
            part: 1.0,
            largest: 0.0,
            window: Window::default(),
            fit: Fit::default(),
        }
    }

    /// Runs one tick.
    pub fn tick(
        &mut self,
        tick: &Tick,
        excitation: &mut Excitation,
    ) -> Result<Option<Found>, Refusal> {
        let plan = tick.plan;
        let current = tick.measured.current[0];
        let turns = plan.turns(i64::from(tick.moved));
        let speed = turns * core::f32::consts::TAU / CONTROL_PERIOD;
        if self.amplitude == 0.0 {
            self.amplitude = FIRST * tick.limit;
        }
        self.largest = max(self.largest, current.abs());
        // Two counts are the noise of the sensor.
        let count = core::f32::consts::TAU / (plan.counts_per_turn as f32 * CONTROL_PERIOD);
        let bound = EXCESS * plan.speed + 2.0 * count;
        check_at_most(Quantity::Speed, speed.abs(), bound)?;
        tick.check_travel()?;
        self.collect(tick, current);
        self.ticks += 1;
        if self.ticks as f32 * CONTROL_PERIOD >= HALF {
            self.ticks = 0;
            self.evaluate(tick);
            self.negative = !self.negative;
            match self.measured {
                Some(halves) => {
                    self.measured = Some(halves + 1);
                    let known = halves >= FEWEST_HALVES && self.fit.solve().1 <= ENOUGH_KNOWN;
                    if known || halves >= MOST_HALVES {
                        return self.finish().map(Some);
                    }
                    // Both directions have the same amplitude, so that the rotor stays.
                    let place = GOLDEN_RATIO * (halves / 2) as f32;
                    let fraction = place - crate::math::to_i32(place) as f32;
                    self.part = SMALLEST_PART + (1.0 - SMALLEST_PART) * fraction;
                }
                None => self.grow(tick)?,
            }
        }
        let voltage = self.part * self.amplitude;
        excitation.voltage[0] = if self.negative { -voltage } else { voltage };
        Ok(None)
    }

    fn grow(&mut self, tick: &Tick) -> Result<(), Refusal> {
        let current = tick.plan.current;
        if self.largest >= ENOUGH * current {
            self.measured = Some(0);
            self.fit = Fit::default();
            return Ok(());
        }
        self.amplitude *= GROWTH;
        let resistance = self.amplitude / current;
        let bound = LARGEST * tick.limit / current;
        check_at_most(Quantity::Resistance, resistance, bound)
    }

    /// Adds a tick to the window, if the current flows as the voltage says.
    fn collect(&mut self, tick: &Tick, current: f32) {
        let current_along = if self.negative { -current } else { current };
        if self.ticks < SKIPPED || current_along < SMALLEST * tick.plan.current {
            return;
        }
        let window = &mut self.window;
        match window.ticks {
            0 => window.first[0] = current,
            1 => window.first[1] = current,
            _ => {}
        }
        window.last = [window.last[1], current];
        window.ticks += 1;
        window.current += current;
        window.voltage += tick.measured.voltage[0];
        window.moved += tick.moved;
    }

    /// Adds the means of the window to the fit. Over several ticks, the steps of the encoder count
    /// for little.
    fn evaluate(&mut self, tick: &Tick) {
        let window = core::mem::take(&mut self.window);
        if window.ticks < FEWEST {
            return;
        }
        let (ticks, period) = (window.ticks as f32, CONTROL_PERIOD);
        let turns = tick.plan.turns(i64::from(window.moved));
        let speed = turns * core::f32::consts::TAU / (ticks * period);
        // From the beginning of the first tick to the end of the last one.
        let ([first, second], [before, last]) = (window.first, window.last);
        let rise = (1.5 * last - 0.5 * before - 1.5 * first + 0.5 * second) / (ticks * period);
        let induced = self.inductance * rise + self.back_emf * speed;
        self.fit
            .add(window.current / ticks, window.voltage / ticks - induced);
    }

    fn finish(&self) -> Result<Found, Refusal> {
        let (resistance, residual) = self.fit.solve();
        check_at_most(Quantity::Fit, residual, LARGEST_ERROR)?;
        check_at_least(Quantity::Resistance, resistance, 1e-3)?;
        Ok(Found {
            resistance,
            residual,
        })
    }
}

/// Sums over the used ticks of one half.
#[derive(Clone, Debug, Default)]
struct Window {
    ticks: u32,
    /// Currents of the first two ticks and of the last two.
    first: [f32; 2],
    last: [f32; 2],
    current: f32,
    voltage: f32,
    moved: i32,
}

/// Sums of the least-squares fit `voltage = resistance * current + offset * sign(current)`.
#[derive(Clone, Debug, Default)]
struct Fit {
    samples: f32,
    current: f32,
    voltage: f32,
    current_squared: f32,
    product: f32,
    voltage_squared: f32,
}

impl Fit {
    /// Adds a sample. Turned to the direction of the current, the fit is a straight line.
    fn add(&mut self, current: f32, voltage: f32) {
        let voltage = if current < 0.0 { -voltage } else { voltage };
        let current = current.abs();
        self.samples += 1.0;
        self.current += current;
        self.voltage += voltage;
        self.current_squared += current * current;
        self.product += current * voltage;
        self.voltage_squared += voltage * voltage;
    }

    /// Returns the resistance and its standard error, as a fraction. NaN without samples, which
    /// every check refuses.
    fn solve(&self) -> (f32, f32) {
        let mean = self.current / self.samples;
        let spread = self.current_squared - mean * self.current;
        let resistance = (self.product - mean * self.voltage) / spread;
        let offset = self.voltage / self.samples - resistance * mean;
        let left = self.voltage_squared - resistance * self.product - offset * self.voltage;
        let variance = max(left, 0.0) / (self.samples - 2.0) / spread;
        (resistance, sqrt(variance) / resistance.abs())
    }
}

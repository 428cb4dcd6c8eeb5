//! Measures resistance and torque constant of a brushed motor: a voltage of changing sign swings
//! the rotor forth and back, and a least-squares fit explains the voltage by current and speed.
//!
//! Short halves of the swing give a large current at a low speed, long ones a high speed. The third
//! term of the fit is the voltage that dead time and brushes take.

use super::record::{Quantity, Refusal};
use super::sequence::{Next, Tick};
use crate::motor::current::Excitation;

/// Lengths of the halves, ms. Each length comes in both directions.
const HALVES: [u32; 8] = [10, 10, 20, 20, 50, 50, 150, 150];
/// Amplitude at the start, as a fraction of the bridge's voltage, its growth per half, and its
/// bound.
const FIRST: f32 = 0.01;
const GROWTH: f32 = 1.08;
const LARGEST: f32 = 0.9;
/// Current that ends the growth, as a fraction of the largest.
const ENOUGH: f32 = 0.8;
/// Halves that are measured.
const MEASURED: usize = 2 * HALVES.len();
/// Ticks after each change of the voltage that are not used.
const SKIPPED: u32 = 3;
/// Smallest current that is used, as a fraction of the largest. Below it, the dead time acts partly.
const SMALLEST: f32 = 0.05;
/// How far the speed may exceed its bound before the calibration ends.
const EXCESS: f32 = 1.3;
/// Largest part of the voltage that the fit may leave, and smallest that the back-EMF must have.
const LARGEST_RESIDUAL: f32 = 0.1;
const LEAST_BACK_EMF: f32 = 0.1;

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Swing {
    /// Inductance, henry, roughly.
    inductance: f32,
    amplitude: f32,
    half: usize,
    ticks: u32,
    /// Halves since the amplitude was found.
    measured: usize,
    found_amplitude: bool,
    fastest: f32,
    largest: f32,
    /// Current and speed of the last two ticks.
    history: [[f32; 2]; 2],
    fit: Fit,
}

/// Result of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub resistance: f32,
    /// `None` if the shaft did not turn fast enough.
    pub torque_constant: Option<f32>,
    pub residual: f32,
}

impl Swing {
    pub fn new(inductance: f32) -> Self {
        Self {
            inductance,
            amplitude: 0.0,
            half: 0,
            ticks: 0,
            measured: 0,
            found_amplitude: false,
            fastest: 0.0,
            largest: 0.0,
            history: [[0.0; 2]; 2],
            fit: Fit::default(),
        }
    }

    /// Runs one tick.
    pub fn tick(&mut self, tick: &Tick) -> Result<Next<Found>, Refusal> {
        let plan = tick.plan;
        let current = tick.measured.current[0];
        let speed =
            plan.turns(i64::from(tick.moved)) * core::f32::consts::TAU / plan.control_period();
        if self.amplitude == 0.0 {
            self.amplitude = FIRST * tick.limit;
        }
        self.fastest = crate::math::max(self.fastest, speed.abs());
        self.largest = crate::math::max(self.largest, current.abs());
        // A count more, because the speed is that of a single tick.
        let count = core::f32::consts::TAU / (plan.counts_per_turn as f32 * plan.control_period());
        tick.check_at_most(Quantity::Speed, self.fastest, EXCESS * plan.speed + count)?;
        tick.check_travel()?;
        self.collect(tick, current, speed);
        self.ticks += 1;
        if self.ticks >= self.length(tick) {
            self.ticks = 0;
            self.half = (self.half + 1) % HALVES.len();
            if self.found_amplitude {
                self.measured += 1;
                if self.measured == MEASURED {
                    return self.finish(tick).map(Next::Done);
                }
            } else {
                self.grow(tick)?;
            }
        }
        let sign = if self.half % 2 == 0 { 1.0 } else { -1.0 };
        Ok(Next::Excite(Excitation {
            voltage: [sign * self.amplitude, 0.0],
            sensing: tick.sensing,
            ..Excitation::default()
        }))
    }

    fn length(&self, tick: &Tick) -> u32 {
        let milliseconds = HALVES.get(self.half).copied().unwrap_or(1);
        milliseconds * tick.plan.control_hz / 1_000
    }

    fn grow(&mut self, tick: &Tick) -> Result<(), Refusal> {
        let plan = tick.plan;
        self.found_amplitude =
            self.largest >= ENOUGH * plan.current || self.fastest >= 0.9 * plan.speed;
        if self.found_amplitude {
            self.fit = Fit::default();
            return Ok(());
        }
        self.amplitude *= GROWTH;
        let most = LARGEST * tick.limit;
        let resistance = self.amplitude / plan.current;
        tick.check_at_most(Quantity::Resistance, resistance, most / plan.current)
    }

    /// Adds the middle one of three ticks to the fit, so that the change of the current is known.
    fn collect(&mut self, tick: &Tick, current: f32, speed: f32) {
        let [[before, _], [middle, turning]] = self.history;
        self.history = [self.history[1], [current, speed]];
        let smallest = SMALLEST * tick.plan.current;
        if self.ticks < SKIPPED + 2 || middle.abs() < smallest {
            return;
        }
        let rise = (current - before) / (2.0 * tick.plan.control_period());
        let voltage = tick.measured.voltage[0] - self.inductance * rise;
        let scaled = [
            middle / tick.plan.current,
            turning / tick.plan.speed,
            f32::copysign(1.0, middle),
        ];
        self.fit.add(scaled, voltage);
    }

    fn finish(&self, tick: &Tick) -> Result<Found, Refusal> {
        let plan = tick.plan;
        let turns = self.fastest >= 0.01 * plan.speed;
        let (solution, residual) = self.fit.solve(turns);
        let [resistance, torque_constant, _] = solution;
        let resistance = resistance / plan.current;
        tick.check_at_most(Quantity::Fit, residual, LARGEST_RESIDUAL)?;
        tick.check_at_least(Quantity::Resistance, resistance, 1e-3)?;
        let torque_constant = torque_constant / plan.speed;
        let back_emf = torque_constant.abs() * self.fastest;
        if plan.free_shaft {
            let least = LEAST_BACK_EMF * self.amplitude;
            tick.check_at_least(Quantity::BackEmf, torque_constant, 0.0)?;
            tick.check_at_least(Quantity::Speed, self.fastest, least / torque_constant.abs())?;
        }
        let measured = plan.free_shaft && back_emf >= LEAST_BACK_EMF * self.amplitude;
        Ok(Found {
            resistance,
            torque_constant: measured.then_some(torque_constant),
            residual,
        })
    }
}

/// Sums of a least-squares fit of a value by three variables.
#[derive(Clone, Debug, Default)]
struct Fit {
    products: [[f32; 3]; 3],
    right: [f32; 3],
    squares: f32,
}

impl Fit {
    fn add(&mut self, x: [f32; 3], value: f32) {
        for (row, left) in x.into_iter().enumerate() {
            for (column, right) in x.into_iter().enumerate() {
                self.products[row][column] += left * right;
            }
            self.right[row] += left * value;
        }
        self.squares += value * value;
    }

    /// Returns the factors, and the root of the mean square that they leave, divided by that of the
    /// value. `second`: the second variable was not always 0.
    fn solve(&self, second: bool) -> ([f32; 3], f32) {
        let (mut a, mut b) = (self.products, self.right);
        if !second {
            for index in 0..3 {
                (a[1][index], a[index][1]) = (0.0, 0.0);
            }
            (a[1][1], b[1]) = (1.0, 0.0);
        }
        // Gauss-Jordan elimination; the matrix is positive definite, so it needs no pivoting. If it
        // is singular, the results are not finite, and every check refuses them.
        for pivot in 0..3 {
            let inverse = 1.0 / a[pivot][pivot];
            for row in 0..3 {
                if row == pivot {
                    continue;
                }
                let factor = a[row][pivot] * inverse;
                for column in 0..3 {
                    a[row][column] -= factor * a[pivot][column];
                }
                b[row] -= factor * b[pivot];
            }
        }
        let solution = [b[0] / a[0][0], b[1] / a[1][1], b[2] / a[2][2]];
        let explained: f32 = (0..3).map(|row| solution[row] * self.right[row]).sum();
        let left = crate::math::max(1.0 - explained / self.squares, 0.0);
        (solution, crate::math::sqrt(left))
    }
}

//! Measures the flux linkage of a three-phase motor: the shaft turns freely at two speeds in each
//! direction, and the voltage in q rises with the speed by the flux linkage.
//!
//! Friction needs the same current at both speeds, so resistance and dead time cancel.

use super::record::{Quantity, Refusal};
use super::sequence::{Mean, Next, Tick};
use crate::motor::current::{Excitation, Frame};
use crate::motor::rotor::Rotor;
use crate::units::Angle;

/// Largest voltage, as a fraction of the bridge's.
const LARGEST: f32 = 0.6;
/// Time in which the voltage would rise to the bridge's, s.
const RISE: f32 = 3.0;
/// Ticks in which the speed is compared, and its largest change meanwhile, as a fraction.
const SETTLE: u32 = 250;
const STEADY: f32 = 1e-3;
const TICKS: u32 = 500;
/// Ticks after which a level must have been reached.
const TIMEOUT: u32 = 20_000;
/// Largest electrical angle per PWM period, rad.
const LARGEST_STEP: f32 = 0.1;
/// How far the speed may exceed its bound before the calibration ends.
const EXCESS: f32 = 1.3;
/// Largest difference of both directions, divided by the mean.
const LARGEST_DIFFERENCE: f32 = 0.05;
/// Part of the voltage that the back-EMF must have.
const LEAST_BACK_EMF: f32 = 0.3;

/// What the step must know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub rotor: Rotor,
    /// Pole pairs, with the sign of the direction.
    pub electrical_per_rotor: f32,
    pub resistance: f32,
    /// Inductances of the axes d and q, henry.
    pub inductance: [f32; 2],
}

/// State of the step.
#[derive(Clone, Debug)]
pub(super) struct Spin {
    known: Known,
    /// Voltage in q, and the voltage of the present level.
    voltage: f32,
    goal: f32,
    level: usize,
    reached: bool,
    ticks: u32,
    /// Counts in the last ticks, and in those before.
    moved: [i32; 2],
    steady: bool,
    /// Electrical speed, rad/s, smoothed.
    speed: f32,
    mean: Mean,
    /// Means at the high speed.
    high: Point,
    found: [f32; 2],
}

/// Means at one speed.
#[derive(Clone, Copy, Debug, Default)]
struct Point {
    voltage: f32,
    current: [f32; 2],
    speed: f32,
}

/// Result of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Flux linkage, V s.
    pub flux: f32,
    /// Difference of both directions, divided by their mean.
    pub residual: f32,
}

impl Spin {
    pub fn new(known: Known) -> Self {
        Self {
            known,
            voltage: 0.0,
            goal: 0.0,
            level: 0,
            reached: false,
            ticks: 0,
            moved: [0; 2],
            steady: false,
            speed: 0.0,
            mean: Mean::default(),
            high: Point::default(),
            found: [0.0; 2],
        }
    }

    /// Runs one tick.
    pub fn tick(&mut self, tick: &Tick) -> Result<Next<Found>, Refusal> {
        let plan = tick.plan;
        let per_count = self.known.electrical_per_rotor * core::f32::consts::TAU
            / (plan.counts_per_turn as f32 * plan.control_period());
        self.speed += (tick.moved as f32 * per_count - self.speed) * (1.0 / 16.0);
        let pole_pairs = self.known.electrical_per_rotor.abs();
        let bound = crate::math::min(
            plan.speed,
            LARGEST_STEP * plan.ratings.pwm_hz as f32 / pole_pairs,
        );
        let speed = self.speed.abs() / pole_pairs;
        tick.check_at_most(Quantity::Speed, speed, EXCESS * bound)?;
        self.ticks += 1;
        if self.steady {
            self.mean.add(tick);
            if self.ticks == TICKS {
                self.end_level(tick, per_count)?;
            }
        } else if self.reached {
            self.settle(tick)?;
        } else {
            self.approach(tick, speed >= bound)?;
        }
        if self.level == 5 && self.reached {
            return self.finish(tick).map(Next::Done);
        }
        let lead = 1.5 * self.speed / plan.ratings.pwm_hz as f32;
        Ok(Next::Excite(Excitation {
            frame: Frame::Rotor {
                rotor: self.known.rotor,
                lead: Angle::from_radians(lead),
            },
            // Cancels the coupling, so that the current in d stays small.
            voltage: [
                -self.speed * self.known.inductance[1] * tick.measured.current[1],
                self.voltage,
            ],
            sensing: tick.sensing,
            ..Excitation::default()
        }))
    }

    /// Changes the voltage towards that of the level while the current allows it. A high level
    /// also ends where the speed reaches its bound.
    fn approach(&mut self, tick: &Tick, fast: bool) -> Result<(), Refusal> {
        if self.ticks > TIMEOUT {
            return Err(tick.timeout(TIMEOUT));
        }
        let goal = match self.level {
            0 => LARGEST * tick.limit,
            2 => -LARGEST * tick.limit,
            _ => self.goal,
        };
        let [d, q] = tick.measured.current;
        let step = tick.limit * tick.plan.control_period() / RISE;
        let change = crate::math::limit(goal - self.voltage, step);
        // A change that reduces the current is always allowed.
        let allowed = d * d + q * q < tick.plan.current * tick.plan.current || q * change < 0.0;
        if allowed {
            self.voltage += change;
        }
        let high = self.level == 0 || self.level == 2;
        let right_way = self.voltage * goal > 0.0 && self.speed * goal > 0.0;
        if self.voltage == goal || high && fast && right_way {
            self.reached = true;
            self.ticks = 0;
        }
        Ok(())
    }

    /// Waits until the speed is steady: only then friction needs the same current at both speeds.
    fn settle(&mut self, tick: &Tick) -> Result<(), Refusal> {
        let [now, before] = &mut self.moved;
        *now += tick.moved;
        if self.ticks % SETTLE != 0 {
            return Ok(());
        }
        let change = (*now - *before).abs() as f32;
        // Two counts are the noise of the sensor.
        let steady = change <= STEADY * now.abs() as f32 + 2.0;
        self.moved = [0, *now];
        if steady && self.ticks > SETTLE {
            self.steady = true;
            self.ticks = 0;
        } else if self.ticks > TIMEOUT {
            return Err(tick.timeout(TIMEOUT));
        }
        Ok(())
    }

    fn end_level(&mut self, tick: &Tick, per_count: f32) -> Result<(), Refusal> {
        let mean = core::mem::take(&mut self.mean).result();
        let point = Point {
            voltage: mean.voltage[1],
            current: mean.current,
            speed: mean.moved * per_count,
        };
        self.ticks = 0;
        self.reached = false;
        self.steady = false;
        self.level += 1;
        if self.level % 2 == 1 {
            self.high = point;
            self.goal = 0.5 * self.voltage;
            return Ok(());
        }
        let high = self.high;
        let volts = high.voltage
            - point.voltage
            - self.known.resistance * (high.current[1] - point.current[1])
            - self.known.inductance[0]
                * (high.speed * high.current[0] - point.speed * point.current[0]);
        let faster = high.speed - point.speed;
        let pole_pairs = self.known.electrical_per_rotor.abs();
        let slowest = LEAST_BACK_EMF * (high.voltage - point.voltage).abs();
        // In volts, so that the bound needs no flux.
        if !(volts.abs() >= slowest && faster * volts > 0.0) {
            return Err(Refusal::OutOfBounds {
                quantity: Quantity::Speed,
                got: high.speed.abs() / pole_pairs,
                bound: tick.plan.speed,
            });
        }
        if let Some(found) = self.found.get_mut(self.level / 2 - 1) {
            *found = volts / faster;
        }
        self.goal = 0.0;
        if self.level == 4 {
            // Down to standstill before the bridge opens.
            self.level = 5;
        }
        Ok(())
    }

    fn finish(&self, tick: &Tick) -> Result<Found, Refusal> {
        let [forward, backward] = self.found;
        let flux = 0.5 * (forward + backward);
        let residual = (forward - backward).abs() / flux;
        tick.check_at_most(Quantity::TorqueConstant, residual, LARGEST_DIFFERENCE)?;
        Ok(Found { flux, residual })
    }
}

//! What the steps of a calibration share: readings of a tick, checks, means, and the control of a
//! current by a slowly changing voltage.

use super::record::{Quantity, Refusal};
use super::{Plan, Step};
use crate::constants::CONTROL_PERIOD;
use crate::motor::current::Measurement;

/// What a step needs in one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick<'a> {
    pub plan: &'a Plan,
    pub step: Step,
    /// Largest voltage of the bridge in every direction, V.
    pub limit: f32,
    pub measured: Measurement,
    /// Counts since the last tick, and since the start.
    pub moved: i32,
    pub travel: i64,
}

impl Tick<'_> {
    /// Length of a PWM period, s.
    pub fn pwm_period(&self) -> f32 {
        1.0 / self.plan.ratings.pwm_hz as f32
    }

    /// Refuses a position too far from the start.
    pub fn check_travel(&self) -> Result<(), Refusal> {
        let per_turn = core::f32::consts::TAU / self.plan.gear_ratio;
        let travel = self.plan.turns(self.travel).abs() * per_turn;
        check_at_most(Quantity::Travel, travel, self.plan.travel * per_turn)
    }

    /// The step has taken longer than this many ticks.
    pub fn timeout(&self, ticks: u32) -> Refusal {
        Refusal::Timeout {
            step: self.step,
            bound: ticks as f32 * CONTROL_PERIOD,
        }
    }
}

/// Refuses a value above `bound`, and NaN.
pub(super) fn check_at_most(quantity: Quantity, got: f32, bound: f32) -> Result<(), Refusal> {
    check(got <= bound, quantity, got, bound)
}

/// Refuses a value below `bound`, and NaN.
pub(super) fn check_at_least(quantity: Quantity, got: f32, bound: f32) -> Result<(), Refusal> {
    check(got >= bound, quantity, got, bound)
}

/// Refuses the value unless it is good.
pub(super) fn check(good: bool, quantity: Quantity, got: f32, bound: f32) -> Result<(), Refusal> {
    if good {
        return Ok(());
    }
    Err(Refusal::OutOfBounds {
        quantity,
        got,
        bound,
    })
}

/// Slow control of the current in d and q by the voltage.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Hold {
    /// Voltage in d and q, V.
    pub voltage: [f32; 2],
    /// Change of the voltage per missing current and tick, ohm.
    pub gain: f32,
}

impl Hold {
    /// Corrects the voltage by the missing current, A.
    pub fn update(&mut self, current: [f32; 2], wanted: [f32; 2]) {
        for axis in 0..2 {
            self.voltage[axis] += self.gain * (wanted[axis] - current[axis]);
        }
    }
}

/// Means over several ticks.
#[derive(Clone, Debug, Default)]
pub(super) struct Mean {
    ticks: u32,
    sums: Means,
}

/// Voltage, V, and current, A, in d and q; counts of the encoder per tick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Means {
    pub voltage: [f32; 2],
    pub current: [f32; 2],
    pub moved: f32,
}

impl Mean {
    /// Adds the values of a tick.
    pub fn add(&mut self, tick: &Tick) {
        self.ticks += 1;
        for axis in 0..2 {
            self.sums.voltage[axis] += tick.measured.voltage[axis];
            self.sums.current[axis] += tick.measured.current[axis];
        }
        self.sums.moved += tick.moved as f32;
    }

    /// Returns the means of the added ticks.
    pub fn result(&self) -> Means {
        let ticks = self.ticks as f32;
        Means {
            voltage: self.sums.voltage.map(|sum| sum / ticks),
            current: self.sums.current.map(|sum| sum / ticks),
            moved: self.sums.moved / ticks,
        }
    }
}

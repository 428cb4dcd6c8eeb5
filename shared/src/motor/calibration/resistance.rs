//! Measures the resistance of a three-phase motor: the slope of the voltage between two currents,
//! so that the dead time of the bridge cancels.
//!
//! The current flows along each phase in turn. Phases a and b have a converter of their own, so the
//! difference of their resistances is taken as the difference of their converters' gains. Their
//! common gain cannot be seen: all resistances change with it.

use super::record::{Quantity, Refusal};
use super::tick::{Hold, Mean, Tick, check_at_least, check_at_most};
use crate::motor::current::{Excitation, Frame};
use crate::units::Angle;

/// Voltage at the start, and its growth per tick until the current flows.
const FIRST: f32 = 1e-3;
const GROWTH: f32 = 1.02;
/// Ticks in which the current turns to the next direction.
const TURN: u32 = 1_000;
/// Ticks in which the rotor is watched, and the longest time to wait until it stands.
const SETTLE: u32 = 300;
const LONGEST: u32 = 3_000;
/// Turn of the rotor with which it counts as standing.
const STANDING: f32 = 5e-4;
const TICKS: u32 = 200;
/// Directions of the current, and levels in each.
const DIRECTIONS: [f32; 3] = [0.0, 120.0, 240.0];
const LEVELS: [f32; 2] = [0.5, 1.0];
/// Largest difference between two phases, divided by their mean.
const LARGEST_DIFFERENCE: f32 = 0.1;
/// Bounds of a plausible resistance, ohm.
const BOUNDS: (f32, f32) = (1e-3, 100.0);

/// State of the step.
#[derive(Clone, Debug, Default)]
pub(super) struct Resistance {
    hold: Hold,
    /// The current flows, and the voltage is controlled.
    flows: bool,
    place: usize,
    turned: u32,
    stands: bool,
    /// Lowest and highest position while it is watched, counts.
    range: Option<(i64, i64)>,
    ticks: u32,
    mean: Mean,
    /// Voltage and current at the lower level.
    low: [f32; 2],
    found: [f32; 3],
}

/// Result of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// Mean of the phases, ohm.
    pub resistance: f32,
    /// Gains of the converters.
    pub gain: [i32; 2],
    /// Difference of the phases that the gains do not explain, divided by their mean.
    pub residual: f32,
    /// Voltages that hold the full current in the last direction.
    pub hold: Hold,
}

impl Resistance {
    /// Runs one tick.
    pub fn tick(
        &mut self,
        tick: &Tick,
        excitation: &mut Excitation,
    ) -> Result<Option<Found>, Refusal> {
        let found = self.advance(tick)?;
        if found.is_none() {
            self.excite(excitation);
        }
        Ok(found)
    }

    fn advance(&mut self, tick: &Tick) -> Result<Option<Found>, Refusal> {
        let current = tick.measured.current;
        if !self.flows {
            let volts = self.hold.voltage[0] * GROWTH;
            self.hold.voltage[0] = if volts > 0.0 {
                volts
            } else {
                FIRST * tick.limit
            };
            let largest = 0.9 * tick.limit;
            let resistance = self.hold.voltage[0] / tick.plan.current;
            check_at_most(
                Quantity::Resistance,
                resistance,
                largest / tick.plan.current,
            )?;
            self.flows = current[0] >= tick.plan.current;
            self.hold.gain = 0.03 * resistance;
            return Ok(None);
        }
        let level = LEVELS[self.place % 2];
        self.hold.update(current, [level * tick.plan.current, 0.0]);
        if level < 1.0 && self.turned < TURN {
            self.turned += 1;
            return Ok(None);
        }
        self.ticks += 1;
        if !self.stands {
            self.watch(tick);
            return Ok(None);
        }
        self.mean.add(tick);
        if self.ticks == TICKS {
            let mean = core::mem::take(&mut self.mean).result();
            let point = [mean.voltage[0], mean.current[0]];
            if level < 1.0 {
                self.low = point;
            } else if let Some(found) = self.found.get_mut(self.place / 2) {
                *found = (point[0] - self.low[0]) / (point[1] - self.low[1]);
            }
            self.ticks = 0;
            self.turned = 0;
            self.stands = false;
            self.place += 1;
            if self.place == 2 * DIRECTIONS.len() {
                return self.finish().map(Some);
            }
        }
        Ok(None)
    }

    /// Waits until the rotor stands: while it swings, it induces a voltage.
    fn watch(&mut self, tick: &Tick) {
        let (low, high) = self.range.unwrap_or((tick.travel, tick.travel));
        let range = (low.min(tick.travel), high.max(tick.travel));
        self.range = Some(range);
        if !self.ticks.is_multiple_of(SETTLE) {
            return;
        }
        self.range = None;
        // Two counts are the noise of the sensor.
        let swings = tick.plan.turns(range.1 - range.0 - 2) > STANDING;
        if self.ticks > SETTLE && !swings || self.ticks >= LONGEST {
            self.stands = true;
            self.ticks = 0;
        }
    }

    fn excite(&self, excitation: &mut Excitation) {
        let direction = DIRECTIONS.get(self.place / 2).copied().unwrap_or_default();
        // The first direction is reached from the start, the others from the one before.
        let still = if self.place.is_multiple_of(2) && self.place > 0 {
            1.0 - self.turned as f32 / TURN as f32
        } else {
            0.0
        };
        let before = DIRECTIONS[1] * still * still * (3.0 - 2.0 * still);
        excitation.frame = Frame::Stator {
            angle: Angle::from_degrees(direction - before),
            step: Angle::ZERO,
        };
        excitation.voltage = self.hold.voltage;
    }

    fn finish(&self) -> Result<Found, Refusal> {
        let [a, b, c] = self.found;
        let mean = 0.5 * (a + b);
        check_at_least(Quantity::Resistance, mean, BOUNDS.0)?;
        check_at_most(Quantity::Resistance, mean, BOUNDS.1)?;
        let balance = (a - b) / mean;
        let residual = (c / mean - 1.0).abs();
        check_at_most(Quantity::Balance, balance.abs(), LARGEST_DIFFERENCE)?;
        check_at_most(Quantity::Balance, residual, LARGEST_DIFFERENCE)?;
        let one = (1 << 30) as f32;
        Ok(Found {
            resistance: mean,
            gain: [one * (1.0 + 0.5 * balance), one * (1.0 - 0.5 * balance)]
                .map(crate::math::to_i32),
            residual,
            hold: self.hold,
        })
    }
}

//! Measures the codes at which no current flows. All half bridges give the same voltage meanwhile.

use super::record::{Quantity, Refusal};
use super::tick::{Tick, check_at_most};
use crate::constants::CONTROL_PERIOD;

/// Largest distance of the zero from the middle of the converter's range, codes of 2^16.
const LARGEST: f32 = 2_000.0;
/// Ticks in which the rotor comes to rest.
const SETTLE: u32 = 300;
const TICKS: u32 = 300;

/// State of the step.
#[derive(Clone, Debug, Default)]
pub(super) struct Zero {
    ticks: u32,
    codes: [f32; 2],
    moved: i32,
}

impl Zero {
    /// Runs one tick, with zero voltage. The result has the codes.
    pub fn tick(&mut self, tick: &Tick) -> Result<Option<[i32; 2]>, Refusal> {
        self.ticks += 1;
        if self.ticks > SETTLE {
            for (sum, code) in self.codes.iter_mut().zip(tick.measured.codes) {
                *sum += code - 32_768.0;
            }
            self.moved += tick.moved;
        }
        if self.ticks < SETTLE + TICKS {
            return Ok(None);
        }
        // A rotor that turns induces a current. Two counts are the noise of the sensor.
        let speed = tick.plan.turns(i64::from(self.moved.abs() - 2)) * core::f32::consts::TAU
            / (TICKS as f32 * CONTROL_PERIOD);
        check_at_most(Quantity::SpeedAtStart, speed, 1.0)?;
        let zero = self.codes.map(|sum| sum / TICKS as f32);
        for code in zero {
            check_at_most(Quantity::CurrentZero, code.abs(), LARGEST)?;
        }
        Ok(Some(zero.map(|code| {
            32_768 + crate::math::to_i32(code + f32::copysign(0.5, code))
        })))
    }
}

//! Measures the codes at which no current flows: first with an open bridge, because a zero that is
//! far from the settings' one looks like an over-current. Then all half bridges give the same
//! voltage.

use super::record::{Quantity, Refusal};
use super::tick::{Tick, check_at_most};
use crate::constants::CONTROL_PERIOD;
use crate::math::to_i32;

/// Largest distance of the zero from the middle of the converter's range, codes of 2^16.
const FARTHEST: f32 = 16_384.0;
/// Largest distance of the zero of a live bridge from that of an open one.
const LARGEST: f32 = 2_000.0;
/// Lowest zero, code of 2^16. It gives the comparators their highest thresholds. It counts until
/// the zero of the open bridge is known.
pub(super) const LOWEST: i32 = 16_384;
/// Ticks after which the thresholds of the comparators have followed the zero.
const FOLLOW: u32 = 5;
/// Ticks that do not count and ticks that do, with an open bridge.
const OPEN: [u32; 2] = [100, 100];
/// The same with a live bridge. The rotor comes to rest first.
const LIVE: [u32; 2] = [300, 300];

/// State of the step.
#[derive(Clone, Debug, Default)]
pub(super) struct Zero {
    ticks: u32,
    /// Sums of the codes, less 2^15 each.
    codes: [f32; 2],
    moved: i32,
    open: Option<[i32; 2]>,
}

impl Zero {
    /// Zero of the open bridge, once it is known.
    pub fn of_open_bridge(&self) -> Option<[i32; 2]> {
        self.open
    }

    /// Whether the bridge is live: the board has set its comparators by the zero of the open one.
    pub fn is_live(&self) -> bool {
        self.open.is_some() && self.ticks > FOLLOW
    }

    /// Runs one tick, with zero voltage. The result has the codes.
    pub fn tick(&mut self, tick: &Tick) -> Result<Option<[i32; 2]>, Refusal> {
        let [settle, ticks] = if self.open.is_some() { LIVE } else { OPEN };
        self.ticks += 1;
        if self.ticks > settle {
            for (sum, code) in self.codes.iter_mut().zip(tick.measured.codes) {
                *sum += code - 32_768.0;
            }
            self.moved += tick.moved;
        }
        if self.ticks < settle + ticks {
            return Ok(None);
        }
        let zero = self.codes.map(|sum| {
            let mean = sum / ticks as f32;
            32_768 + to_i32(mean + f32::copysign(0.5, mean))
        });
        let Some(open) = self.open else {
            for code in zero {
                let distance = (code - 32_768).abs() as f32;
                check_at_most(Quantity::CurrentZero, distance, FARTHEST)?;
            }
            *self = Self {
                open: Some(zero),
                ..Self::default()
            };
            return Ok(None);
        };
        // A rotor that turns induces a current. Two counts are the noise of the sensor.
        let speed = tick.plan.turns(i64::from(self.moved.abs() - 2)) * core::f32::consts::TAU
            / (ticks as f32 * CONTROL_PERIOD);
        check_at_most(Quantity::SpeedAtStart, speed, 1.0)?;
        for (code, open) in zero.into_iter().zip(open) {
            let distance = (code - open).abs() as f32;
            check_at_most(Quantity::CurrentZero, distance, LARGEST)?;
        }
        Ok(Some(zero))
    }
}

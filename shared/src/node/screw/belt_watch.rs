//! Watches the tension of the belts for faults.

use crate::faults::{Fault, Faults};
use crate::settings::{Setting, Settings};

/// Ticks for which a tension must be too high, or too low.
const TOO_HIGH_TICKS: u8 = 50;
const TOO_LOW_TICKS: u8 = 200;

/// Bounds of the tension, N, and counters.
///
/// A fault is raised in one tick, so that a reset can clear it. It comes again after the same time
/// if the tension is still too high. A lost belt is reported once: without tension, there is none
/// that could be lost.
#[derive(Clone, Debug)]
pub(super) struct BeltWatch {
    limit: f32,
    minimum: f32,
    too_high: u8,
    too_low: u8,
    /// The belts had a tension of twice the minimum since they are taut.
    had_tension: bool,
}

impl BeltWatch {
    /// Reads the bounds from the settings.
    pub fn new(settings: &Settings) -> Self {
        Self {
            limit: settings.si(Setting::TensionLimit),
            minimum: settings.si(Setting::TensionMinimum),
            too_high: 0,
            too_low: 0,
            had_tension: false,
        }
    }

    /// Runs a tick. `tension` is the estimate, N. `taut` is whether the screw keeps the belts taut
    /// by the law, and has taken up what was slack.
    pub fn tick(&mut self, tension: f32, taut: bool) -> Faults {
        let mut faults = Faults::NONE;
        let fault = lasts(&mut self.too_high, tension > self.limit, TOO_HIGH_TICKS);
        faults.insert_if(Fault::BeltOverload, fault);
        self.had_tension = taut && (self.had_tension || tension > 2.0 * self.minimum);
        let lost = self.had_tension && tension < self.minimum;
        let fault = lasts(&mut self.too_low, lost, TOO_LOW_TICKS);
        self.had_tension &= !fault;
        faults.insert_if(Fault::BeltLost, fault);
        faults
    }
}

/// Counts the ticks for which a condition lasts. Returns true, and starts anew, at `dwell`.
fn lasts(ticks: &mut u8, condition: bool, dwell: u8) -> bool {
    *ticks = if condition { *ticks + 1 } else { 0 };
    let reached = *ticks >= dwell;
    if reached {
        *ticks = 0;
    }
    reached
}

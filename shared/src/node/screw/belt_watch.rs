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

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks until a fault comes, at this tension, N.
    fn ticks(watch: &mut BeltWatch, tension: f32, taut: bool) -> Option<(usize, Faults)> {
        let faults = (1..=1_000).map(|tick| (tick, watch.tick(tension, taut)));
        faults.into_iter().find(|(_, faults)| !faults.is_empty())
    }

    #[test]
    fn only_taut_belts_that_had_a_tension_are_lost_and_only_once() {
        let mut watch = BeltWatch::new(&Settings::default());
        let lost = Some((200, Faults::of(Fault::BeltLost)));
        assert_eq!(ticks(&mut watch, 0.0, true), None, "no tension before");
        for (before, taut, expected) in [
            (19.0, true, None),
            (21.0, true, lost),
            (0.0, true, None),
            (50.0, false, None),
            (50.0, true, lost),
        ] {
            watch.tick(before, taut);
            assert_eq!(ticks(&mut watch, 9.0, taut), expected, "{before} {taut}");
        }
        watch.tick(50.0, true);
        watch.tick(0.0, false);
        assert_eq!(ticks(&mut watch, 0.0, true), None, "released meanwhile");
        watch.tick(50.0, true);
        assert_eq!(ticks(&mut watch, 11.0, true), None);
    }

    #[test]
    fn an_overload_is_reported_in_any_mode_and_again_while_it_lasts() {
        let mut watch = BeltWatch::new(&Settings::default());
        let overload = Some((50, Faults::of(Fault::BeltOverload)));
        for taut in [false, true, true] {
            assert_eq!(ticks(&mut watch, 401.0, taut), overload);
        }
        assert_eq!(ticks(&mut watch, 399.0, true), None);
        for _ in 0..1_000 {
            let spikes = (0..49).map(|_| watch.tick(1e9, true));
            assert!(spikes.fold(Faults::NONE, Faults::or).is_empty());
            watch.tick(0.0, false);
        }
    }
}

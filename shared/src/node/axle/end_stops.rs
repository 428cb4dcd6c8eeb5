//! Keeps the set-point inside of the limit switches and of the travel.

use super::{ActiveLimit, Axle};
use crate::bus::cia402::mode;
use crate::math::Turns;
use crate::motor::profile::Motion;
use crate::sensors::Switches;

/// Positions at which the positive and the negative limit switch stop the set-point, while they are
/// closed.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct EndStops([Option<Turns>; 2]);

impl EndStops {
    pub fn places(&self) -> &[Option<Turns>; 2] {
        &self.0
    }

    /// Forgets where the switches have closed.
    pub fn clear(&mut self) {
        self.0 = [None; 2];
    }
}

impl Axle {
    /// Prevents the set-point from moving outward while a limit switch is closed, and beyond the
    /// travel. It stops where the switch closed, or at its farthest place inward since then. Inward
    /// motion is free. `before` is the position of the set-point in the previous tick; `None` if
    /// the velocity alone is the set-point.
    pub(super) fn stop_at_ends(&mut self, switches: Switches, before: Option<Turns>) {
        let place = self.motion.position;
        let from = before.unwrap_or_else(|| {
            let velocity = self.motion.velocity;
            let step = i32::from(velocity > 0.0) - i32::from(velocity < 0.0);
            place - Turns::from_bits(step.into())
        });
        let in_position = before.is_some();
        self.stop_at_end(false, switches.positive_limit, from, in_position);
        self.stop_at_end(true, switches.negative_limit, from, in_position);
    }

    /// Runs [`Self::stop_at_ends`] for the positive or the `negative` direction. The set-point came
    /// from the place `from`.
    #[inline(never)] // one copy for two directions
    fn stop_at_end(&mut self, negative: bool, closed: bool, from: Turns, in_position: bool) {
        let direction = usize::from(negative);
        // Makes the place that is farther outward the greater number, and back.
        let outward = |place: Turns| Turns::from_bits(place.to_bits() ^ -i64::from(negative));
        let (from, place) = (outward(from), outward(self.motion.position));
        let stop = closed.then(|| {
            let stop = self.end_stops.0[direction].unwrap_or_else(|| self.position());
            outward(stop).min(place)
        });
        self.end_stops.0[direction] = stop.map(outward);
        let (end, limit) = match (stop, self.ends()) {
            (Some(stop), _) => (stop, ActiveLimit::Switch),
            (None, Some(ends)) => {
                let end = outward(ends[direction]);
                if place <= end {
                    return;
                }
                // A set-point that is outside of the travel already stays there.
                let outside = in_position && from > end;
                (if outside { from } else { end }, ActiveLimit::Travel)
            }
            (None, None) => return,
        };
        if place > from || in_position && place == from && place > end {
            self.motion = Motion::at(outward(end));
            self.active_limit = limit;
        }
    }

    /// Returns the upper and the lower end of the travel; `None` while the axle has none.
    pub(super) fn ends(&self) -> Option<[Turns; 2]> {
        let travel = self.travel.filter(|_| self.homed);
        let (low, high) = travel.filter(|_| self.mode != mode::HOMING)?;
        Some([high, low])
    }
}

//! Cyclic synchronous torque mode.

use super::{ActiveLimit, Axle, Inputs};
use crate::math::{Turns, limit};
use crate::motor::cascade::Demand;
use crate::motor::profile::Motion;

/// End of motion in one direction, at which torque mode holds the position.
#[derive(Clone, Copy, Debug)]
struct Barrier {
    position: Turns,
    /// 1 or -1.
    direction: f32,
    limit: ActiveLimit,
}

/// State of torque mode.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TorqueMode {
    /// Demanded current, A.
    current: f32,
    barrier: Option<Barrier>,
}

impl TorqueMode {
    /// State of an axle that demands this current, A, and has met no end of motion.
    pub fn at(current: f32) -> Self {
        Self {
            current,
            barrier: None,
        }
    }
}

impl Axle {
    /// Runs one tick of torque mode. The torque approaches its target with the torque slope. The
    /// velocity limit reduces it, and a closed limit switch or an end of travel ends it: there the
    /// axle holds its position.
    pub(super) fn control_torque(&mut self, inputs: &Inputs) -> Demand {
        let target = self.command.target as f32 * self.offset.amperes();
        let target = limit(target, self.envelope.current_limit);
        let step = self.options.torque_step * self.offset.amperes();
        self.torque.current += limit(target - self.torque.current, step);
        // This updates where the switches closed. Its set-point is of no use here.
        self.stop_at_ends(inputs.switches, None);
        if let Some(barrier) = self.barrier(target) {
            if self.torque.barrier.is_none() {
                // The torque was directed outward.
                self.envelope.cascade.reset();
            }
            self.torque.barrier = Some(barrier);
            self.motion = Motion::at(barrier.position);
            self.active_limit = barrier.limit;
            self.torque.current = 0.0;
            return self.follow(self.envelope.full);
        }
        self.torque.barrier = None;
        self.active_limit = ActiveLimit::None;
        let velocity = self.velocity();
        self.motion = Motion {
            position: self.position(),
            velocity,
            acceleration: 0.0,
        };
        let cascade = &mut self.envelope.cascade;
        let current = cascade.current(self.torque.current) + self.offset.current();
        cascade.torque(current, cascade.rate(velocity), self.envelope.full)
    }

    /// Returns what a torque of this sign, or the motion, is directed against. A barrier stays
    /// until the torque turns away from it.
    fn barrier(&self, torque: f32) -> Option<Barrier> {
        if let Some(barrier) = self.torque.barrier
            && torque * barrier.direction > 0.0
        {
            return Some(barrier);
        }
        let (position, velocity) = (self.position(), self.velocity());
        let ends = self.ends().map_or([None; 2], |[high, low]| {
            [
                (position >= high).then_some(high),
                (position <= low).then_some(low),
            ]
        });
        let mut sides = self.end_stops.places().iter().zip(ends).zip([1.0, -1.0]);
        sides.find_map(|((switch, end), direction)| {
            let outward = torque * direction > 0.0 || velocity * direction > 0.0;
            let (position, limit) = match (switch, end) {
                (Some(stop), _) => (*stop, ActiveLimit::Switch),
                (None, Some(end)) => (end, ActiveLimit::Travel),
                (None, None) => return None,
            };
            outward.then_some(Barrier {
                position,
                direction,
                limit,
            })
        })
    }
}

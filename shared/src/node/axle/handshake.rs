//! Set-points of profile position mode (CiA 402): a rising edge of "new set-point" hands over a
//! target, and "set-point acknowledge" confirms it. One more target waits until the axle has
//! reached the first.
//!
//! The handshake is for clients in bench mode. The guard sends its target with every SYNC, and each
//! counts at once.

use super::{ActiveLimit, Axle, SetPoint};
use crate::bus::cia402::{CHANGE_IMMEDIATELY, CONTROL_START, RELATIVE, State, mode};
use crate::constants::CONTROL_PERIOD;
use crate::math::Turns;

/// Targets that were handed over.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Handshake {
    /// Target that the axle moves to or has reached; `None` before the first one.
    target: Option<Turns>,
    /// Target after this one.
    next: Option<Turns>,
    /// "New set-point" is high, and its target was accepted.
    accepted: bool,
}

impl Handshake {
    /// Returns whether the bit "set-point acknowledge" is set: the newest target was accepted and
    /// its controlword bit has not fallen yet, or no further target can be accepted.
    pub fn acknowledges(&self) -> bool {
        self.accepted || self.next.is_some()
    }

    /// Returns whether there is a target, and no further one waits.
    pub fn is_last(&self) -> bool {
        self.target.is_some() && self.next.is_none()
    }

    /// Takes the target of a rising edge. Without "change immediately" it waits while the axle
    /// moves, unless another one waits already.
    fn take(&mut self, target: Turns, immediately: bool, moving: bool) {
        if immediately || !moving {
            (self.target, self.next) = (Some(target), None);
        } else if self.next.is_none() {
            self.next = Some(target);
        } else {
            return;
        }
        self.accepted = true;
    }
}

impl Axle {
    /// Returns whether targets of profile position mode need the handshake.
    pub(super) fn shakes_hands(&self) -> bool {
        self.mode == mode::PROFILE_POSITION && self.authority.bench()
    }

    /// Takes the bits of a controlword that hand over a target. `risen` are the bits that rose.
    pub(super) fn take_target(&mut self, set_point: SetPoint, risen: u16) {
        let word = set_point.controlword;
        if word & CONTROL_START == 0 {
            self.handshake.accepted = false;
        }
        let takes = self.shakes_hands() && self.homed && self.state == State::OperationEnabled;
        if !takes || risen & CONTROL_START == 0 {
            return;
        }
        let last = self.handshake.next.or(self.handshake.target);
        let target = if word & RELATIVE != 0 {
            let distance = self.scale.distance_from_bus(i64::from(set_point.target));
            last.unwrap_or(self.motion.position) + distance
        } else {
            self.scale
                .position_from_bus(set_point.target, self.position())
        };
        let target = self.within_travel(target);
        let moving = self.moves_to_target();
        let immediately = word & CHANGE_IMMEDIATELY != 0;
        self.handshake.take(target, immediately, moving);
        self.windows.leave_target();
    }

    /// Returns whether the set-point has not reached its target yet.
    pub(super) fn moves_to_target(&self) -> bool {
        let target = self.handshake.target;
        target.is_some_and(|target| target != self.motion.position || self.motion.velocity != 0.0)
    }

    /// Moves the set-point by one tick, to the target that was handed over.
    pub(super) fn move_to_target(&mut self) {
        if !self.moves_to_target()
            && let Some(next) = self.handshake.next.take()
        {
            self.handshake.target = Some(next);
            self.windows.leave_target();
        }
        let limits = self.options.profile(self.envelope.limits);
        match self.handshake.target {
            Some(target) => {
                // The travel may have become narrower.
                let target = self.within_travel(target);
                self.motion.toward_position(target, limits, CONTROL_PERIOD);
            }
            None => self.motion.toward_velocity(0.0, limits, CONTROL_PERIOD),
        }
    }

    /// Returns the position within the travel that is nearest to `position`.
    pub(super) fn within_travel(&mut self, position: Turns) -> Turns {
        match self.travel {
            Some((low, _)) if self.homed && position < low => {
                self.active_limit = ActiveLimit::Travel;
                low
            }
            Some((_, high)) if self.homed && position > high => {
                self.active_limit = ActiveLimit::Travel;
                high
            }
            _ => position,
        }
    }
}

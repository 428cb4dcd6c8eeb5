//! The windows of CiA 402 around a target: following error, and target reached.

use super::{Axle, State};
use crate::bus::cia402::{mode, status};
use crate::math::limit;

impl Axle {
    /// Measures for how long the position has been outside of the following error window, and
    /// within the position window.
    pub(super) fn watch_windows(&mut self) {
        let (error, options) = (self.following_error().unsigned_abs(), &self.options);
        self.following_ticks = if error > options.following.distance {
            self.following_ticks.saturating_add(1)
        } else {
            0
        };
        if self.shakes_hands() {
            let reached = error <= options.position.distance && !self.moves_to_target();
            self.in_window = if reached {
                self.in_window.saturating_add(1)
            } else {
                0
            };
        }
    }

    /// Returns the bits of the statusword whose meaning depends on the mode, in operation and in
    /// another mode than homing.
    pub(super) fn status_of_mode(&self) -> u16 {
        if self.state != State::OperationEnabled {
            return 0;
        }
        if self.stopping.halted {
            return if self.stands() && self.motion.velocity == 0.0 {
                status::TARGET_REACHED
            } else {
                0
            };
        }
        let bit = |bit: u16, set: bool| if set { bit } else { 0 };
        let following = self.exit.is_none() && self.brake.is_released();
        let ticks = self.following_ticks;
        let error = bit(
            status::ERROR_OF_MODE,
            ticks > 0 && ticks >= self.options.following.ticks,
        );
        match self.mode {
            mode::PROFILE_POSITION if self.shakes_hands() => {
                let (ticks, handshake) = (self.in_window, &self.handshake);
                let reached = ticks > 0 && ticks >= self.options.position.ticks;
                bit(status::TARGET_REACHED, reached && handshake.is_last())
                    | bit(status::FOLLOWING, handshake.acknowledges())
                    | error
            }
            mode::PROFILE_VELOCITY => {
                let target = self.scale.velocity_from_bus(self.command.target);
                let fastest = self.options.profile(self.force.limits).velocity;
                let reached = self.motion.velocity == limit(target, fastest);
                bit(status::TARGET_REACHED, reached && following)
                    | bit(status::FOLLOWING, self.stands())
            }
            mode::CYCLIC_POSITION | mode::PROFILE_POSITION => {
                bit(status::FOLLOWING, following) | error
            }
            _ => bit(status::FOLLOWING, following),
        }
    }
}

//! The windows of CiA 402 around a target: following error, and target reached.

use super::{Axle, State};
use crate::bus::cia402::{mode, status};
use crate::math::limit;

/// How long the position has been where the windows tell, ticks.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Windows {
    /// Outside of the following error window.
    outside: u32,
    /// Within the position window.
    within: u32,
}

impl Windows {
    /// Begins to count anew how long the position is within its window, because the target is new.
    pub fn leave_target(&mut self) {
        self.within = 0;
    }
}

/// One more tick while the condition lasts, otherwise 0.
fn count(ticks: u32, lasts: bool) -> u32 {
    if lasts { ticks.saturating_add(1) } else { 0 }
}

impl Axle {
    /// Measures for how long the position has been outside of the following error window, and
    /// within the position window.
    pub(super) fn watch_windows(&mut self) {
        let (error, options) = (self.following_error().distance(), &self.options);
        let follows = error <= options.following.distance;
        self.windows.outside = count(self.windows.outside, !follows);
        if self.shakes_hands() {
            let reached = error <= self.options.position.distance && !self.moves_to_target();
            self.windows.within = count(self.windows.within, reached);
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
        let ticks = self.windows.outside;
        let error = bit(
            status::ERROR_OF_MODE,
            ticks > 0 && ticks >= self.options.following.ticks,
        );
        match self.mode {
            mode::PROFILE_POSITION if self.shakes_hands() => {
                let (ticks, handshake) = (self.windows.within, &self.handshake);
                let reached = ticks > 0 && ticks >= self.options.position.ticks;
                bit(status::TARGET_REACHED, reached && handshake.is_last())
                    | bit(status::FOLLOWING, handshake.acknowledges())
                    | error
            }
            mode::PROFILE_VELOCITY => {
                let target = self.scale.velocity_from_bus(self.command.target);
                let fastest = self.options.profile(self.envelope.limits).velocity;
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

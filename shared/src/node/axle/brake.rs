//! The sequence of a holding brake: released once the motor carries its current, engaged before the
//! motor loses it.

use super::{Axle, Inputs};
use crate::constants::CONTROL_PERIOD;
use crate::motor::cascade::Demand;
use crate::motor::profile::Motion;
use crate::settings::{Setting, Settings};

/// Ticks in which the current builds up before the brake is released: forty time constants of the
/// slowest motor whose current loop is at 4000 rad/s.
const BUILD_UP_TICKS: u32 = 10;

/// State of the brake, with the ticks that are left of it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Stage {
    Engaged,
    BuildsUp(u32),
    Releasing(u32),
    Released,
    Engaging(u32),
}

/// A brake and its times. A drive without a brake has one with the times 0.
#[derive(Clone, Debug)]
pub(super) struct Brake {
    stage: Stage,
    release_ticks: u32,
    engage_ticks: u32,
}

impl Brake {
    /// Creates an engaged brake with the times of the settings.
    pub fn new(settings: &Settings) -> Self {
        let ticks = |setting| settings.milliseconds(setting) as u32 / (CONTROL_PERIOD * 1e6) as u32;
        Self {
            stage: Stage::Engaged,
            release_ticks: ticks(Setting::BrakeReleaseTime),
            engage_ticks: ticks(Setting::BrakeEngageTime),
        }
    }

    /// Returns whether releasing or engaging takes time.
    pub fn takes_time(&self) -> bool {
        self.release_ticks | self.engage_ticks != 0
    }

    /// Returns whether the brake's coil is energized.
    pub fn is_energized(&self) -> bool {
        matches!(self.stage, Stage::Releasing(_) | Stage::Released)
    }

    /// Returns whether the axle may move.
    pub fn is_released(&self) -> bool {
        self.stage == Stage::Released
    }

    /// Engages the brake at once.
    pub fn drop_in(&mut self) {
        self.stage = Stage::Engaged;
    }

    /// Runs one tick under power, without an exit. Returns whether the axle may move.
    pub fn release(&mut self) -> bool {
        self.stage = match self.stage {
            _ if !self.takes_time() => Stage::Released,
            Stage::Engaged | Stage::Engaging(_) => Stage::BuildsUp(BUILD_UP_TICKS),
            Stage::BuildsUp(0) => Stage::Releasing(self.release_ticks),
            Stage::Releasing(0) | Stage::Released => Stage::Released,
            Stage::BuildsUp(left) => Stage::BuildsUp(left - 1),
            Stage::Releasing(left) => Stage::Releasing(left - 1),
        };
        self.is_released()
    }

    /// Runs one tick under power at the end of an exit. Returns whether the brake holds.
    pub fn engage(&mut self) -> bool {
        self.stage = match self.stage {
            _ if !self.takes_time() => Stage::Engaged,
            Stage::Engaged | Stage::Engaging(0) | Stage::BuildsUp(_) => Stage::Engaged,
            Stage::Engaging(left) => Stage::Engaging(left - 1),
            Stage::Releasing(_) | Stage::Released => Stage::Engaging(self.engage_ticks),
        };
        self.stage == Stage::Engaged
    }
}

impl Axle {
    /// Holds the position in operation until the brake is released. The torque feed-forward carries
    /// the load meanwhile.
    pub(super) fn hold_on_brake(&mut self, inputs: &Inputs) -> Demand {
        self.offset
            .update(inputs.torque_offset, &self.envelope.cascade);
        self.motion = Motion::at(self.motion.position);
        self.interpolation_ticks = 0;
        self.follow(self.envelope.full)
    }
}

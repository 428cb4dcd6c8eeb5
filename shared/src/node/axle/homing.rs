//! The reference run: to the switch, and slowly off it again; where it opens, the position is known.

use super::super::{CONTROL_PERIOD, Switches};
use super::Axle;

/// Stage of a reference run.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Homing {
    Idle,
    /// Towards the switch until it closes.
    Seek,
    /// Away from it, slowly, until it opens.
    BackOff,
    Done,
    Failed,
}

const HOMING_TICKS: u32 = 20_000;

impl Axle {
    /// One tick of the run.
    pub(super) fn home(&mut self, switches: Switches) {
        let towards = self.reference_direction * self.reference_speed;
        self.homing_ticks = self.homing_ticks.saturating_add(1);
        let running = matches!(self.homing, Homing::Seek | Homing::BackOff);
        if running && self.homing_ticks > HOMING_TICKS {
            self.homing = Homing::Failed;
        }
        let wanted = match self.homing {
            Homing::Seek if switches.reference => {
                self.homing = Homing::BackOff;
                0.0
            }
            Homing::Seek => towards,
            Homing::BackOff if !switches.reference => {
                self.observer.set_position(self.reference_position);
                self.anchor();
                self.referenced = true;
                self.homing = Homing::Done;
                0.0
            }
            Homing::BackOff => -0.2 * towards,
            Homing::Idle | Homing::Done | Homing::Failed => 0.0,
        };
        self.motion
            .toward_velocity(wanted, self.limits, CONTROL_PERIOD);
    }
}

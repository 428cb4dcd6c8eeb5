//! What the guard publishes of the robot's balance.

use super::Balance;
use crate::sensing::trust::Trust;
use crate::stability::bands::Band;
use crate::stability::limits::MotionLimits;
use crate::stability::parameters::Refusal;
use crate::stability::trip::Snapshot;

/// What the guard knows of the robot's balance (objects 0x4006 and 0x4007).
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Telemetry {
    /// Band of the narrowest margin.
    pub band: Band,
    /// How far the sensors on the body are believed.
    pub trust: Trust,
    /// The measured force counts besides the centre of gravity.
    pub with_force: bool,
    /// The guard has tripped.
    pub tripped: bool,
    /// Trips since power-up.
    pub trips: u16,
    /// Limits of motion that follow from the margins.
    pub limits: MotionLimits,
    /// What the guard knew at the last trip.
    pub snapshot: Option<Snapshot>,
    /// Why the robot is not armed.
    pub refusal: Option<Refusal>,
}

impl Balance {
    /// Returns what is published; `refusal` is why the robot is not armed.
    pub fn telemetry(&self, refusal: Option<Refusal>) -> Telemetry {
        Telemetry {
            band: self.bands.band(),
            trust: self.trust,
            with_force: self.found.force_counts,
            tripped: self.trip.latched(),
            trips: self.trip.count(),
            limits: self.limits,
            snapshot: self.trip.snapshot().copied(),
            refusal,
        }
    }
}

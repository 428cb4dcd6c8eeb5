//! Limits the first current after arming until the shaft has turned the way of its torque. So a
//! reversed encoder, swapped leads or a wrong rotor angle are found at a low torque.
//!
//! A shaft that does not turn shows no sign: the current stays at the limit of the probe, and the
//! fault "blocked" is raised there. A shaft that creeps counts as one that does not turn.

use crate::motor::from_radians;
use crate::settings::{Setting, Settings};
use core::f32::consts::TAU;

/// Electrical angle whose motion is a proof: 18 degrees, rad. A brushed motor counts as a motor
/// with four pole pairs.
const PROOF: f32 = TAU / 20.0;
const POLE_PAIRS_OF_BRUSHED: i32 = 4;
/// Part of the limit of the probe from which on the shaft must turn.
const PUSHING: f32 = 0.5;
/// Part of the limit of the probe from which on a motion counts.
const COUNTED: f32 = 0.25;
/// Control periods in which the shaft must turn by a [`PART`]th of [`PROOF`], and after which it
/// counts as still.
const STANDING: u8 = 20;
const STILL: u8 = 10;
const PART: i64 = 4;

/// What the probe has found in a control period.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub(super) struct Sign {
    /// The shaft has turned against its torque.
    pub against: bool,
    /// The shaft does not turn.
    pub stands: bool,
}

/// The probe of one axle.
#[derive(Clone, Debug)]
pub(super) struct SignProbe {
    /// Largest current during the probe, A; 0 without a probe.
    current: f32,
    /// Motion that is a proof, 2^-32 turn of the output shaft.
    proof: i64,
    /// Whether the current is negative; `None` while it is too small.
    backward: Option<bool>,
    /// Position from which the motion counts.
    from: Option<i64>,
    /// Whether the shaft may still move with the speed from before the torque.
    coasts: bool,
    /// Position near which the shaft has stood for this many control periods.
    near: i64,
    still: u8,
    /// Control periods for which the shaft has had to turn.
    pushed: u8,
    proven: bool,
}

impl SignProbe {
    /// Creates the probe of an axle that is off.
    pub fn new(settings: &Settings) -> Self {
        let pole_pairs = match settings.get(Setting::MotorKind) {
            0 => POLE_PAIRS_OF_BRUSHED,
            _ => settings.get(Setting::PolePairs),
        };
        let electrical = settings.scaled(Setting::GearRatio, 1e-3) * pole_pairs as f32;
        Self {
            current: settings.scaled(Setting::ProbeCurrent, 1e-3),
            proof: from_radians(PROOF / electrical),
            backward: None,
            from: None,
            coasts: true,
            near: 0,
            still: 0,
            pushed: 0,
            proven: false,
        }
    }

    /// Begins anew: the axle gets power.
    pub fn start(&mut self) {
        (self.from, self.backward, self.proven) = (None, None, false);
    }

    /// Returns the current limit: `limit`, or that of the probe.
    #[inline]
    pub fn bound(&self, limit: f32) -> f32 {
        if self.probes() && self.current < limit {
            self.current
        } else {
            limit
        }
    }

    #[inline]
    fn probes(&self) -> bool {
        !self.proven && self.current != 0.0
    }

    /// Runs one control period under power, at this position, with the demanded current of the last
    /// one, A. A position that is `doubtful` is no proof.
    #[inline]
    pub fn tick(&mut self, position: i64, doubtful: bool, demand: f32) -> Sign {
        if !self.probes() {
            return Sign::default();
        }
        let from = self.from.get_or_insert(position);
        if position.wrapping_sub(self.near).unsigned_abs() >= (self.proof / PART) as u64 {
            (self.near, self.still) = (position, 0);
        }
        self.still = self.still.saturating_add(1);
        let (size, backward) = (demand.abs(), demand < 0.0);
        let counts = size >= COUNTED * self.current;
        if !counts || self.backward == Some(!backward) {
            // What moves without a torque proves nothing.
            *from = position;
            (self.pushed, self.coasts) = (0, true);
        }
        self.backward = counts.then_some(backward);
        let moved = position.wrapping_sub(*from);
        let along = if backward {
            moved.wrapping_neg()
        } else {
            moved
        };
        if self.coasts {
            if along < 0 {
                *from = position;
            }
            self.coasts = self.still < STILL && along < self.proof / PART;
        }
        if !(size >= PUSHING * self.current) {
            self.pushed = 0;
            return Sign::default();
        }
        self.pushed = self.pushed.saturating_add(1);
        self.proven = along >= self.proof && !doubtful;
        Sign {
            against: along <= -(self.proof / 2),
            stands: self.pushed.min(self.still) > STANDING,
        }
    }
}

//! Limits the first current after arming until the shaft has turned the way of its torque. So a
//! reversed encoder, swapped leads or a wrong rotor angle are found at a low torque.
//!
//! A shaft that does not turn shows no sign: the current stays at the limit of the probe, and the
//! fault "blocked" is raised there.

use crate::motor::from_radians;
use crate::settings::{Setting, Settings};
use core::f32::consts::TAU;

/// Electrical angle whose motion is a proof: 18 degrees, rad. A brushed motor counts as a motor
/// with four pole pairs.
const PROOF: f32 = TAU / 20.0;
const POLE_PAIRS_OF_BRUSHED: i32 = 4;
/// Part of the limit of the probe from which on a current counts.
const PUSHING: f32 = 0.5;

/// The probe of one axle.
#[derive(Clone, Debug)]
pub(super) struct SignProbe {
    /// Largest current during the probe, A; 0 without a probe.
    current: f32,
    /// Motion that is a proof, 2^-32 turn of the output shaft.
    proof: i64,
    /// Position from which the motion counts; `None` before the first current and after the proof.
    from: Option<i64>,
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
            from: None,
            proven: false,
        }
    }

    /// Begins anew: the axle gets power.
    pub fn start(&mut self) {
        (self.from, self.proven) = (None, false);
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

    /// Returns the current from which on the shaft must turn during the probe, A.
    #[inline]
    pub fn pushing(&self) -> f32 {
        if self.probes() {
            PUSHING * self.current
        } else {
            f32::INFINITY
        }
    }

    #[inline]
    fn probes(&self) -> bool {
        !self.proven && self.current != 0.0
    }

    /// Runs one control period under power, at this position, with the demanded current of the last
    /// one, A. Returns whether the shaft has turned against its torque.
    #[inline]
    pub fn tick(&mut self, position: i64, demand: f32) -> bool {
        if !self.probes() {
            return false;
        }
        let from = *self.from.get_or_insert(position);
        let moved = position.wrapping_sub(from);
        if !(demand.abs() >= self.pushing()) {
            // What moves without a torque proves nothing.
            self.from = Some(position);
            return false;
        }
        let along = if demand < 0.0 {
            moved.wrapping_neg()
        } else {
            moved
        };
        self.proven = along >= self.proof;
        along <= self.proof.wrapping_neg()
    }
}

//! Watches the rotor's angle of a three-phase motor at low speed, where the back-EMF is too small
//! for [`BackEmf`]: by its alternating part ([`Ripple`]), and with a current that makes no torque
//! ([`AngleProbe`]).
//!
//! The constants of both were tuned on this project's motor model, and nobody has tried them on a
//! motor. So a setting enables the watch.

use super::angle_probe::AngleProbe;
use super::back_emf::{BackEmf, Observed};
use super::ripple::Ripple;
use crate::settings::{Setting, Settings};

/// The watch of one motor.
#[derive(Clone, Debug)]
pub struct AngleWatch {
    ripple: Ripple,
    probe: AngleProbe,
}

impl AngleWatch {
    /// Creates the watch of this motor; `None` for a brushed one, or if the settings do not enable
    /// it.
    pub fn new(settings: &Settings, motor: &BackEmf) -> Option<Self> {
        let enabled = settings.get(Setting::AngleWatch) != 0;
        (enabled && motor.electrical != 0.0).then(|| Self {
            ripple: Ripple::default(),
            probe: AngleProbe::new(motor),
        })
    }

    /// Takes over the limits of this motor. A probe under way ends.
    pub fn retune(&mut self, motor: &BackEmf) {
        self.probe = AngleProbe::new(motor);
    }

    /// Returns the watch of the alternating back-EMF, which [`BackEmf::check`] updates.
    pub fn ripple(&mut self) -> &mut Ripple {
        &mut self.ripple
    }

    /// Runs the probe for one control period, after the ripple; only while the axle is `powered`.
    /// Returns whether it has found a wrong angle.
    #[inline]
    pub fn tick(&mut self, now: &Observed, powered: bool) -> bool {
        if powered {
            self.probe.tick(now, self.ripple.is_calm())
        } else {
            self.probe.reset();
            false
        }
    }

    /// Forgets what depends on the rotor's angle: it is not known.
    pub fn forget_angle(&mut self) {
        self.ripple.reset();
    }

    /// Returns the probe, whose current the current limiter takes into account.
    pub fn probe(&self) -> &AngleProbe {
        &self.probe
    }
}

//! The voltage that the bridge gives, and the current in d that weakens the field so that this
//! voltage suffices.
//!
//! At a high speed, the back-EMF of a three-phase motor exceeds the voltage of the bridge. Without
//! a current in d, nothing then controls the current. A negative current in d takes `w L_d |i_d|`
//! from the back-EMF `e` (amplitudes of a phase, at the electrical speed `w`), so that
//!
//! `(e + R i_q - w L_d |i_d|)^2 + (w L_q i_q)^2 <= V^2`.

use super::supply::positive;
use crate::math::{min, root_of_sum};
use crate::motor::bridge::MAX_DUTY;
use crate::settings::{Setting, Settings};

/// `1 / sqrt 3`
const BY_ROOT_3: f32 = 0.577_350_26;
/// Part of the bridge's largest voltage with which the computation reckons.
const RECKONED: f32 = 0.95;
/// Part of it that a braking motor may need before the field is weakened more than computed.
const NEEDED: f32 = 0.97;
/// Part of the voltage beyond that which is added to the computed back-EMF in a control period.
const GAIN: f32 = 0.5;
/// Largest such addition, as a part of the back-EMF. The settings may be wrong by 10 % in flux and
/// by 20 % in inductance.
const LARGEST_ERROR: f32 = 0.3;
/// Part of the current that is left for the torque, however much the field needs.
const LEAST: f32 = 0.4;
/// Part of the current limit that a motor which drives may use for its field. What is left brakes.
const LARGEST_WEAKENING: f32 = 0.9;
/// Number of bisections by which the largest current is found: to 1 % of the rest.
const BISECTIONS: usize = 6;

/// Readings of one control period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readings {
    /// Speed of the output shaft, rad/s, and supply voltage, V.
    pub speed: f32,
    pub supply: f32,
    /// Amplitude of the bridge's voltage, V.
    pub voltage: f32,
    /// The motor brakes.
    pub brakes: bool,
    /// Current by which it brakes more than it must, A.
    pub excess: f32,
}

/// Voltages of a three-phase motor.
#[derive(Clone, Debug)]
pub(super) struct Voltage {
    /// Amplitude of a phase's back-EMF, V s/rad of the output shaft.
    emf_constant: f32,
    resistance: f32,
    /// Reactances of d and q, ohm s/rad of the output shaft.
    reactances: [f32; 2],
    /// Largest current in d for a higher speed, A.
    weakening: f32,
    /// What the computed back-EMF lacks, V.
    lacking: f32,
}

/// Voltages at one speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct AtSpeed {
    /// Back-EMF as it is computed, and with what it lacks, V.
    emf: [f32; 2],
    /// Largest voltage of the bridge, V.
    largest: f32,
    resistance: f32,
    /// Reactances of d and q, ohm.
    reactances: [f32; 2],
    weakening: f32,
}

impl Voltage {
    /// Reads the motor's parameters from the settings; `None` for a brushed motor.
    pub fn new(settings: &Settings) -> Option<Self> {
        if settings.get(Setting::MotorKind) == 0 {
            return None;
        }
        let gear = settings.si(Setting::GearRatio);
        let electrical = gear * settings.get(Setting::PolePairs) as f32;
        let inductance = settings.si(Setting::Inductance);
        let inductance_q = settings.si_or(Setting::InductanceQ, Setting::Inductance);
        Some(Self {
            emf_constant: settings.si(Setting::TorqueConstant) * gear / 1.5,
            resistance: settings.si(Setting::Resistance),
            reactances: [electrical * inductance, electrical * inductance_q],
            weakening: min(
                settings.si(Setting::FieldWeakeningCurrent),
                LARGEST_WEAKENING * settings.si(Setting::CurrentLimit),
            ),
            lacking: 0.0,
        })
    }

    /// Takes over what `before` has found to be missing.
    pub fn take_over(&mut self, before: &Self) {
        self.lacking = before.lacking;
    }

    /// Returns the voltages of one control period. It corrects the computed back-EMF while a
    /// braking motor needs nearly all of the voltage.
    #[inline]
    pub fn at(&mut self, now: &Readings) -> AtSpeed {
        let emf = now.speed * self.emf_constant;
        let largest = now.supply * (MAX_DUTY * BY_ROOT_3);
        let beyond = now.voltage - NEEDED * largest;
        if now.brakes || beyond < 0.0 {
            // A current that brakes more than it must needs voltage in d, which q then lacks: such
            // a current grows.
            let uncontrolled = if beyond > 0.0 {
                self.reactances[1] * now.speed * now.excess
            } else {
                0.0
            };
            let lacking = positive(self.lacking + GAIN * beyond + uncontrolled);
            self.lacking = min(lacking, LARGEST_ERROR * emf);
        }
        AtSpeed {
            emf: [emf, emf + self.lacking],
            largest,
            resistance: self.resistance,
            reactances: self.reactances.map(|reactance| reactance * now.speed),
            weakening: self.weakening,
        }
    }
}

impl AtSpeed {
    /// Returns the largest current that accelerates, A.
    #[inline]
    pub fn accelerating(&self) -> f32 {
        let left = self.largest + self.reactances[0] * self.weakening - self.emf[0];
        positive(left) / self.resistance
    }

    /// Returns the largest current for the torque, A, beside which `bound`, A, leaves room for the
    /// current in d that it needs. If there is none, some current is left for the torque, and the
    /// field is weakened as far as possible.
    #[inline]
    pub fn reach(&self, bound: f32, along: bool) -> f32 {
        if self.weakening(bound, along) == 0.0 {
            return bound;
        }
        self.bisect(bound, along)
    }

    #[cold]
    fn bisect(&self, bound: f32, along: bool) -> f32 {
        let mut reached = LEAST * bound;
        let mut step = bound - reached;
        for _ in 0..BISECTIONS {
            step *= 0.5;
            let current = reached + step;
            let direct = self.weakening(current, along);
            if current * current + direct * direct <= bound * bound {
                reached = current;
            }
        }
        reached
    }

    /// Returns the size of the current in d, A, that weakens the field for this current, A, along
    /// the motion or against it.
    #[inline]
    pub fn weakening(&self, current: f32, along: bool) -> f32 {
        let [_, emf] = self.emf;
        let [reactance, across] = self.reactances;
        let available = RECKONED * self.largest;
        let drop = self.resistance * current;
        let across = across * current;
        let square = available * available - across * across;
        let voltage = if along { emf + drop } else { emf - drop };
        let wanted = if square < 0.0 {
            // The current alone needs more voltage in d.
            f32::INFINITY
        } else if voltage > 0.0 && voltage * voltage > square {
            (voltage - root_of_sum(square)) / reactance
        } else {
            return 0.0;
        };
        if !along {
            return positive(wanted);
        }
        // A motor that drives has a weaker field only as far as that is allowed.
        let needed = positive(emf - self.largest) / reactance;
        let most = if needed > self.weakening {
            needed
        } else {
            self.weakening
        };
        positive(if wanted < most { wanted } else { most })
    }
}

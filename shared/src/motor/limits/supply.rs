//! Power between supply and motor: limits of the supply's current in both directions, of the power,
//! and their reduction near the ends of the supply voltage.
//!
//! The power at the terminals of a motor is `e i + r i^2`: `e` is the torque constant times the
//! speed, `r i^2` are the losses. Torque constant and losses are those of the amplitude of a
//! three-phase motor's currents, so `r` is 1.5 times the resistance of a phase.

use super::ActiveLimit;
use super::heat::fraction;
use crate::math::sqrt;
use crate::settings::{Setting, Settings};

/// Part of the bands of the supply voltage in which no power is left. It covers the delay of a
/// control period and the errors of the motor's parameters.
const MARGIN: f32 = 0.25;

/// Returns `value`; 0 if it is negative or NaN.
pub(super) fn positive(value: f32) -> f32 {
    if value > 0.0 { value } else { 0.0 }
}

/// A limit of the power, W, and what sets it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power {
    pub watts: f32,
    pub cause: ActiveLimit,
}

/// What the supply gives and takes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Supply {
    /// Back-EMF constant at the output shaft, W s/rad per A.
    emf_constant: f32,
    /// Losses of the winding, W/A^2.
    pub loss: f32,
    /// The winding can turn braking power into heat by a current that makes no torque.
    pub burns: bool,
    /// Largest currents from and to the supply, A.
    currents: [f32; 2],
    power: f32,
    /// Supply voltages at which no power is taken or returned any more, V.
    low: f32,
    high: f32,
    /// 1/V: inverse widths of the bands in which the power is reduced.
    low_band: f32,
    high_band: f32,
}

impl Supply {
    /// Reads the limits from the settings.
    pub fn new(settings: &Settings) -> Self {
        let (under, over) = (
            settings.si(Setting::UnderVoltage),
            settings.si(Setting::OverVoltage),
        );
        let (motoring, regeneration) = (
            settings.si(Setting::MotoringVoltage),
            settings.si(Setting::RegenerationVoltage),
        );
        let low = under + MARGIN * positive(motoring - under);
        let high = over - MARGIN * positive(over - regeneration);
        // A band without width is infinitely steep: the factor is 0 or 1.
        let steepness = |width: f32| if width > 0.0 { 1.0 / width } else { f32::MAX };
        let three_phase = settings.get(Setting::MotorKind) != 0;
        let gear = settings.si(Setting::GearRatio);
        let resistance = settings.si(Setting::Resistance);
        Self {
            emf_constant: settings.si(Setting::TorqueConstant) * gear,
            loss: if three_phase {
                1.5 * resistance
            } else {
                resistance
            },
            burns: three_phase,
            currents: [
                settings.si(Setting::SupplyCurrentLimit),
                settings.si(Setting::RegenerationCurrentLimit),
            ],
            power: settings.si(Setting::PowerLimit),
            low,
            high,
            low_band: steepness(motoring - low),
            high_band: steepness(high - regeneration),
        }
    }

    /// Returns the back-EMF constant times the speed, W/A; not negative.
    #[inline]
    pub fn emf(&self, speed: f32) -> f32 {
        self.emf_constant * speed
    }

    /// Returns the power that the motor may take at this supply voltage, V. It asks for at most
    /// `most` W. Near the under-voltage, a part of that is allowed.
    #[inline]
    pub fn motoring(&self, voltage: f32, most: f32) -> Power {
        let part = fraction((voltage - self.low) * self.low_band);
        let cause = if part < 1.0 {
            ActiveLimit::LowSupplyVoltage
        } else {
            ActiveLimit::SupplyCurrent
        };
        self.part(voltage * self.currents[0], most, part, cause)
    }

    /// Returns the power that a braking motor may return at this supply voltage, V. It converts at
    /// most `most` W. Near the over-voltage, a part of that is allowed.
    #[inline]
    pub fn regenerating(&self, voltage: f32, most: f32) -> Power {
        let part = fraction((self.high - voltage) * self.high_band);
        let cause = if part < 1.0 {
            ActiveLimit::HighSupplyVoltage
        } else {
            ActiveLimit::RegenerationCurrent
        };
        self.part(voltage * self.currents[1], most, part, cause)
    }

    /// Returns `part` of the smallest of three powers: of the supply, of the settings, and `most`.
    #[inline]
    fn part(&self, supply: f32, most: f32, part: f32, cause: ActiveLimit) -> Power {
        let (watts, cause) = if part == 1.0 && supply >= self.power {
            (self.power, ActiveLimit::Power)
        } else if supply >= self.power {
            (self.power, cause)
        } else {
            (supply, cause)
        };
        let watts = if most < watts { most } else { watts } * part;
        // NaN and negative values are no power.
        Power {
            watts: positive(watts),
            cause,
        }
    }

    /// Returns the largest currents, A, that take at most `watts` from the supply: one that
    /// accelerates, and one that brakes. At `watts` = 0 the second is the current of a shorted
    /// winding.
    #[inline]
    pub fn currents(&self, emf: f32, watts: f32) -> [f32; 2] {
        // Roots of `r i^2 + e i - P = 0`.
        let sum = emf + sqrt(emf * emf + 4.0 * self.loss * watts);
        let along = if sum > 0.0 { 2.0 * watts / sum } else { 0.0 };
        [along, sum / (self.loss + self.loss)]
    }

    /// Returns the power, W, that a braking motor may convert while the supply may take back
    /// `watts`, and while the winding may carry `bound` A.
    ///
    /// Braking never ends: what the winding can turn into heat is always allowed. A three-phase
    /// motor burns it with a current in d. A brushed motor cannot; it returns at most this power.
    #[inline]
    pub fn braking(&self, watts: f32, bound: f32) -> f32 {
        let heat = self.loss * bound * bound;
        if self.burns {
            watts + heat
        } else if heat > watts {
            heat
        } else {
            watts
        }
    }
}

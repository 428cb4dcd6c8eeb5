//! Results of a calibration: the record of the values that were found, or why they were refused.

use crate::math::to_i32;
use crate::motor::bridge::CurrentSensing;
use crate::motor::rotor::ElectricalAngle;
use crate::settings::{Setting, Settings};
use core::fmt;

/// Values that a calibration has found.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Record {
    /// Offset of the current converter, and the difference of its gains.
    pub sensing: CurrentSensing,
    /// Resistance of winding and bridge, ohm; of one phase, if there are three.
    pub resistance: f32,
    /// Inductances of the axes d and q, henry; equal for a brushed motor.
    pub inductance: [f32; 2],
    /// Pole pairs; 0 for a brushed motor.
    pub pole_pairs: i32,
    /// The electrical angle falls while the counts rise.
    pub reversed: bool,
    /// Electrical angle at count 0 of the rotor sensor, or at the pulse of its index.
    pub offset: ElectricalAngle,
    /// Torque per current at the rotor, N m/A; `None` if the shaft was not free to turn.
    pub torque_constant: Option<f32>,
    /// How well the measurements agree.
    pub residuals: Residuals,
}

/// How well the measurements agree with each other; 0 is best.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Residuals {
    /// Difference of the resistances of the phases (brushed: voltage that the fit does not
    /// explain), divided by the resistance (by the voltage).
    pub resistance: f32,
    /// Electrical angle by which friction makes the rotor lag behind the current, rad.
    pub lag: f32,
    /// Difference of the torque constants in both directions, divided by the torque constant.
    pub torque_constant: f32,
}

/// Number of settings that a record has values of.
pub const SETTINGS: usize = 10;

impl Record {
    /// Returns the values as settings. A value that was not measured is `None`.
    pub fn settings(&self) -> [Option<(Setting, i32)>; SETTINGS] {
        let rounded = |value: f32| to_i32(value + 0.5);
        let three_phase = self.pole_pairs != 0;
        let degrees = i64::from(self.offset.0.to_bits()) * 360_000;
        let [a, b] = self.sensing.gain;
        [
            Some((Setting::CurrentZeroA, self.sensing.zero[0])),
            Some((Setting::CurrentZeroB, self.sensing.zero[1])),
            Some((Setting::CurrentBalance, balance_setting(a, b))),
            Some((Setting::Resistance, rounded(self.resistance * 1e3))),
            Some((Setting::Inductance, rounded(self.inductance[0] * 1e6))),
            three_phase.then(|| (Setting::InductanceQ, rounded(self.inductance[1] * 1e6))),
            three_phase.then_some((Setting::PolePairs, self.pole_pairs)),
            three_phase.then_some((Setting::PhaseOrder, if self.reversed { -1 } else { 1 })),
            three_phase.then_some((
                Setting::ElectricalOffset,
                ((degrees + (1 << 31)) >> 32) as i32,
            )),
            self.torque_constant
                .map(|value| (Setting::TorqueConstant, rounded(value * 1e6))),
        ]
    }

    /// Stores the values in `settings`.
    ///
    /// # Errors
    /// [`Refusal::NoSetting`] with the first value that is out of the bounds of its setting. The
    /// settings may then contain some of the values.
    pub fn store(&self, settings: &mut Settings) -> Result<(), Refusal> {
        for (setting, value) in self.settings().iter().flatten().copied() {
            settings
                .set(setting.bounds().key, value)
                .map_err(|_| Refusal::NoSetting {
                    setting,
                    got: value,
                })?;
        }
        Ok(())
    }
}

/// Difference of two gains, in the unit of the setting `current_balance`.
fn balance_setting(a: i32, b: i32) -> i32 {
    to_i32((a - b) as f32 * (1e4 / (1 << 30) as f32))
}

/// Creates the sensing from the settings.
pub fn sensing(settings: &Settings) -> CurrentSensing {
    // 2^29 / 10^4, half of the balance for each converter.
    let half = settings.get(Setting::CurrentBalance) * 53_687;
    let one = 1 << 30;
    CurrentSensing {
        zero: [
            settings.get(Setting::CurrentZeroA),
            settings.get(Setting::CurrentZeroB),
        ],
        gain: [one + half, one - half],
    }
}

/// Value that a calibration checks against bounds. The number of a value is what object 0x2052
/// shows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[repr(u8)]
pub enum Quantity {
    /// Supply voltage, V.
    SupplyVoltage = 1,
    /// Speed of the rotor at the start, rad/s.
    SpeedAtStart = 2,
    /// Distance of the current converter's zero from the middle of its range, codes.
    CurrentZero = 3,
    /// Resistance, ohm.
    Resistance = 4,
    /// Difference of the resistances of two phases, divided by their mean.
    Balance = 5,
    /// Travel of the output shaft, rad.
    Travel = 6,
    /// Turns of the rotor per turn of the current: 1 / pole pairs.
    RotorPerElectrical = 7,
    /// Distance of the pole pairs from a whole number.
    PolePairs = 8,
    /// Counts of the rotor sensor per electrical turn.
    SensorCounts = 9,
    /// Electrical angle by which the rotor lags behind the current, rad.
    Lag = 10,
    /// Inductance, henry.
    Inductance = 11,
    /// Speed of the rotor, rad/s.
    Speed = 12,
    /// Difference of the torque constants in both directions, divided by their mean.
    TorqueConstant = 13,
    /// Voltage that the fit of a brushed motor does not explain, divided by the voltage.
    Fit = 14,
    /// Torque constant of a brushed motor, N m/A; negative if its leads are swapped.
    BackEmf = 15,
    /// Current, A.
    Current = 16,
    /// Pulses of the encoder's index.
    IndexPulses = 17,
}

/// Why a calibration ended without a record.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Refusal {
    /// A value is out of its bounds.
    OutOfBounds {
        /// What was measured.
        quantity: Quantity,
        /// Its value.
        got: f32,
        /// The bound that it violates.
        bound: f32,
    },
    /// A step took longer than its timeout.
    Timeout {
        /// The step.
        step: super::Step,
        /// Its timeout, s.
        bound: f32,
    },
    /// A value is out of the bounds of its setting.
    NoSetting {
        /// The setting.
        setting: Setting,
        /// The value in its unit.
        got: i32,
    },
    /// The motor of these values cannot be controlled.
    NoLoop,
    /// The calibration was ended: bench mode ended, the drive was armed or has a fault, or the
    /// request was withdrawn.
    Ended,
}

impl fmt::Display for Refusal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfBounds {
                quantity,
                got,
                bound,
            } => write!(out, "{quantity:?} = {got}, bound {bound}"),
            Self::Timeout { step, bound } => write!(out, "{step:?} took longer than {bound} s"),
            Self::NoSetting { setting, got } => {
                let row = setting.description();
                write!(
                    out,
                    "{} = {got} {}, allowed {} to {}",
                    row.name, row.unit, row.minimum, row.maximum
                )
            }
            Self::NoLoop => write!(out, "the current loop refuses the motor"),
            Self::Ended => write!(out, "the calibration was ended"),
        }
    }
}

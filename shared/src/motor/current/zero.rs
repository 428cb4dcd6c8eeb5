//! Follows the zero of the current converters while the bridge is open: then no current flows. A
//! zero that drifts with the temperature would give the motor a wrong torque, and hide an
//! over-current.

use crate::motor::bridge::CurrentSensing;

/// Largest error of the zero that is followed, as a fraction of the current limit.
const FOLLOWED: f32 = 0.02;
/// The same of a sound converter, as a fraction of its full scale: two steps of one with 12 bits.
pub const ZERO_ERROR: f32 = 1.0 / 1024.0;
/// Control periods in succession with an open bridge after which the mean counts. Currents of
/// before are gone by then.
const PERIODS: u8 = 20;
/// Part of the difference to a new value that the mean covers in a control period.
const FILTER: f32 = 0.1;

/// Zero of the converters of one drive, codes of 2^16.
#[derive(Clone, Debug)]
pub(super) struct ConverterZero {
    /// Number of converters that the motor needs.
    converters: usize,
    /// Largest error that is followed.
    bound: f32,
    /// Zero of the settings.
    stored: [i32; 2],
    /// Mean distance from it, and control periods that it contains, up to [`PERIODS`].
    mean: [f32; 2],
    periods: u8,
    wrong: bool,
}

impl ConverterZero {
    /// Creates the zero of a drive with this number of converters, and with this current limit, as
    /// a fraction of full scale.
    pub fn new(converters: usize, current_limit: f32) -> Self {
        Self {
            converters,
            bound: (FOLLOWED * current_limit + ZERO_ERROR) * 32_768.0,
            stored: CurrentSensing::default().zero,
            mean: [0.0; 2],
            periods: 0,
            wrong: false,
        }
    }

    /// Begins with the zero of the settings.
    pub fn set(&mut self, stored: [i32; 2]) {
        self.stored = stored;
        (self.periods, self.wrong) = (0, false);
    }

    /// Takes the mean codes of a control period; `None` if a current may have flowed. Returns the
    /// zero that counts from now on, if it is known.
    pub fn update(&mut self, codes: Option<[f32; 2]>) -> Option<[i32; 2]> {
        let Some(codes) = codes else {
            self.periods = 0;
            return None;
        };
        let means = self.mean.iter_mut().take(self.converters);
        for ((mean, code), stored) in means.zip(codes).zip(self.stored) {
            let away = code - stored as f32;
            if self.periods == 0 {
                *mean = away;
            } else {
                *mean += (away - *mean) * FILTER;
            }
        }
        if self.periods < PERIODS {
            self.periods += 1;
            return None;
        }
        self.wrong = self.mean.iter().any(|mean| mean.abs() > self.bound);
        let mut zero = self.stored;
        for (zero, mean) in zero.iter_mut().zip(self.mean) {
            // Less than a code is noise.
            *zero += mean.clamp(-self.bound, self.bound) as i32;
        }
        Some(zero)
    }

    /// Returns whether the error was larger than what is followed when the bridge was open last.
    pub fn is_wrong(&self) -> bool {
        self.wrong
    }
}

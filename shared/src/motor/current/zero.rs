//! Follows the zero of the current converters while the bridge is open: then no current flows. A
//! zero that drifts with the temperature would give the motor a wrong torque, and hide an
//! over-current.

use crate::math::to_i32;
use crate::motor::bridge::CurrentSensing;

/// Largest error of the zero that is followed, as a fraction of the current limit.
const FOLLOWED: f32 = 0.02;
/// The same of a sound converter, as a fraction of its full scale: two steps of one with 12 bits.
pub const ZERO_ERROR: f32 = 1.0 / 1024.0;
/// Control periods in succession with an open bridge after which the mean counts. Currents of
/// before are gone by then.
const PERIODS: u8 = 20;
/// Part of the difference to a new value that the mean covers in a control period: 2 to minus this.
const FILTER_BITS: u32 = 3;
/// Fraction bits of the mean.
const FRACTION_BITS: u32 = 8;

/// One converter.
#[derive(Clone, Debug)]
struct Converter {
    /// Zero of the settings, codes of 2^16.
    stored: i32,
    /// Mean distance from it, with [`FRACTION_BITS`].
    mean: i32,
}

impl Converter {
    fn new(stored: i32) -> Self {
        Self { stored, mean: 0 }
    }

    /// Adds the sum of this number of codes.
    #[inline]
    fn add(&mut self, samples: i32, sum: i32, first: bool) {
        let away = ((sum - samples * self.stored) << FRACTION_BITS) / samples;
        if first {
            self.mean = away;
        } else {
            self.mean += (away - self.mean) >> FILTER_BITS;
        }
    }

    /// Returns the whole codes of the mean: less than a code is noise.
    #[inline]
    fn away(&self) -> i32 {
        self.mean / (1 << FRACTION_BITS)
    }
}

/// Zero of the converters of one drive. It uses integers and no loops, because the PWM interrupt
/// waits meanwhile.
#[derive(Clone, Debug)]
pub(super) struct ConverterZero {
    a: Converter,
    b: Converter,
    /// The motor needs both.
    both: bool,
    /// Largest error that is followed, codes.
    bound: i32,
    /// Control periods that the means contain, up to [`PERIODS`].
    periods: u8,
    wrong: bool,
}

impl ConverterZero {
    /// Creates the zero of a drive that needs `both` converters or only the first, with this
    /// current limit, as a fraction of full scale.
    pub fn new(both: bool, current_limit: f32) -> Self {
        let [a, b] = CurrentSensing::default().zero.map(Converter::new);
        Self {
            a,
            b,
            both,
            bound: to_i32((FOLLOWED * current_limit + ZERO_ERROR) * 32_768.0),
            periods: 0,
            wrong: false,
        }
    }

    /// Begins with the zero of the settings.
    pub fn set(&mut self, stored: [i32; 2]) {
        let [a, b] = stored.map(Converter::new);
        (self.a, self.b) = (a, b);
        (self.periods, self.wrong) = (0, false);
    }

    /// Takes the sums of the codes of this number of PWM periods; `None` if a current may have
    /// flowed. Returns the zero that counts from now on, if it is known.
    #[inline]
    pub fn update(&mut self, codes: Option<(i32, [i32; 2])>) -> Option<[i32; 2]> {
        let Some((samples, [a, b])) = codes else {
            self.periods = 0;
            return None;
        };
        let first = self.periods == 0;
        self.a.add(samples, a, first);
        if self.both {
            self.b.add(samples, b, first);
        }
        if self.periods < PERIODS {
            self.periods += 1;
            return None;
        }
        let (a, b, bound) = (self.a.away(), self.b.away(), self.bound);
        self.wrong = a.abs() > bound || b.abs() > bound;
        Some([
            self.a.stored + a.clamp(-bound, bound),
            self.b.stored + b.clamp(-bound, bound),
        ])
    }

    /// Returns whether the error was larger than what is followed when the bridge was open last.
    pub fn is_wrong(&self) -> bool {
        self.wrong
    }
}

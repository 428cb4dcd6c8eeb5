//! Follows the zero of the current converters while the bridge is open: then no current flows. A
//! zero that drifts with the temperature would give the motor a wrong torque, and hide an
//! over-current. The second converter of a brushed motor and the third one only check the others,
//! and the calibration does not measure them: their zero may be anywhere.

use crate::math::{Bound, to_i32};

/// Largest error of the zero that is followed, as a fraction of the current limit.
const FOLLOWED: f32 = 0.02;
/// The same of a sound converter, as a fraction of its full scale: two steps of one with 12 bits.
pub const ZERO_ERROR: f32 = 1.0 / 1024.0;
/// Control periods in succession with an open bridge that do not count: currents of before decay.
const SETTLE: u8 = 10;
/// Control periods in succession with an open bridge after which the mean becomes the zero.
const PERIODS: u8 = 32;
/// Score from which on the zero is wrong. A control period with a larger error adds 1, another one
/// subtracts 1.
const WRONG: u8 = 20;
/// The mean covers 1/4 of the difference to a new value in a control period. It moves by at most an
/// eighth of what is followed, so that a disturbed sample counts little.
const FILTER_BITS: u32 = 2;
/// Fraction bits of the mean.
const FRACTION_BITS: u32 = 8;
/// Middle of the range of a converter, and largest distance from it of a zero that may be anywhere,
/// codes.
const MIDDLE: i32 = 1 << 15;
const FREE: i32 = 1 << 14;
/// Such a zero moves by this part of the sum of the distances in a control period, 2^-7, and by at
/// most this number of codes.
const FREE_BITS: u32 = 7;
const FREE_STEP: i32 = 64;

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

    /// Adds the sum of this number of codes. Returns whether their mean is farther away than
    /// `bound`, codes.
    #[inline]
    fn add(&mut self, samples: i32, sum: i32, bound: i32) -> bool {
        let distance = (sum - samples * self.stored) << FRACTION_BITS;
        let away = distance.checked_div(samples).unwrap_or(0);
        let step = bound << (FRACTION_BITS - 3);
        let difference = away - self.mean;
        // Rounded away from 0. Otherwise the mean would stop below a constant value, and a missing
        // code is a current of 2 mA that no demand explains.
        let rounding = if difference > 0 {
            (1 << FILTER_BITS) - 1
        } else {
            0
        };
        self.mean += Bound::of_size(step).limit((difference + rounding) >> FILTER_BITS);
        away.abs() > bound << FRACTION_BITS
    }

    /// Returns the zero, at most `bound` codes away. It has the whole codes of the mean: less than
    /// a code is noise.
    #[inline]
    fn zero(&self, bound: i32) -> i32 {
        let away = self.mean / (1 << FRACTION_BITS);
        self.stored + Bound::of_size(bound).limit(away)
    }
}

/// Zero of the converters of one drive. It uses integers and no loops, because the PWM interrupt
/// waits meanwhile.
#[derive(Clone, Debug)]
pub(super) struct ConverterZero {
    a: Converter,
    b: Converter,
    /// Zero of the converter that only checks the others: c, or b if the motor needs only a.
    free: i32,
    /// The motor needs the first two.
    both: bool,
    /// Largest error that is followed, codes.
    bound: i32,
    /// Control periods in succession with an open bridge, up to [`PERIODS`].
    periods: u8,
    /// Score of control periods with a larger error, up to [`WRONG`].
    far: u8,
    /// The score was [`WRONG`], and has not been 0 since.
    wrong: bool,
}

impl ConverterZero {
    /// Creates the zero of a drive that needs the first two converters (`both`) or only the first,
    /// with this current limit, as a fraction of full scale.
    pub fn new(both: bool, current_limit: f32) -> Self {
        let mut zero = Self {
            a: Converter::new(MIDDLE),
            b: Converter::new(MIDDLE),
            free: MIDDLE,
            both,
            bound: 0,
            periods: 0,
            far: 0,
            wrong: false,
        };
        zero.set_limit(current_limit);
        zero
    }

    /// Sets the current limit, as a fraction of full scale.
    pub fn set_limit(&mut self, current_limit: f32) {
        self.bound = to_i32((FOLLOWED * current_limit + ZERO_ERROR) * 32_768.0);
    }

    /// Begins with the zero of the settings.
    pub fn set(&mut self, stored: [i32; 2]) {
        let [a, b] = stored.map(Converter::new);
        (self.a, self.b, self.free) = (a, b, stored[1]);
        (self.periods, self.far, self.wrong) = (0, 0, false);
    }

    /// Takes the sums of the codes of this number of PWM periods; `None` if a current may have
    /// flowed. Returns the zero that counts from now on, if it is known.
    #[inline]
    pub fn update(&mut self, codes: Option<(i32, [i32; 3])>) -> Option<[i32; 3]> {
        let Some((samples, [a, b, c])) = codes else {
            self.periods = 0;
            return None;
        };
        if self.periods < PERIODS {
            self.periods += 1;
        }
        if self.periods <= SETTLE {
            return None;
        }
        let bound = self.bound;
        let free = if self.both { c } else { b } - samples * self.free;
        self.free += Bound::of_size(FREE_STEP).limit(free >> FREE_BITS);
        let free_is_far = (self.free - MIDDLE).abs() > FREE;
        let a_is_far = self.a.add(samples, a, bound);
        let b_is_far = self.both && self.b.add(samples, b, bound);
        if a_is_far || b_is_far || free_is_far {
            self.far = if self.far < WRONG {
                self.far + 1
            } else {
                WRONG
            };
        } else {
            self.far = self.far.saturating_sub(1);
        }
        self.wrong = self.far == WRONG || self.wrong && self.far > 0;
        if self.periods < PERIODS {
            return None;
        }
        let b = if self.both {
            self.b.zero(bound)
        } else {
            self.free
        };
        Some([self.a.zero(bound), b, self.free])
    }

    /// Returns whether the error was larger than what is followed when the bridge was open last.
    pub fn is_wrong(&self) -> bool {
        self.wrong
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STORED: i32 = 1 << 15;
    /// PWM periods in a control period.
    const SAMPLES: i32 = 20;

    /// Takes control periods with this distance of the codes from the stored zero.
    fn take(zero: &mut ConverterZero, away: i32, periods: usize) -> Option<[i32; 2]> {
        let [a, b] = [STORED + away, STORED - away].map(|code| SAMPLES * code);
        let sums = [a, b, SAMPLES * STORED];
        let mut last = None;
        for _ in 0..periods {
            last = zero.update(Some((SAMPLES, sums)));
        }
        last.map(|[a, b, _]| [a, b])
    }

    #[test]
    fn a_converter_that_only_checks_the_others_may_have_its_zero_anywhere_within_a_half_range() {
        let take = |both: bool, away: i32| {
            let mut zero = ConverterZero::new(both, 0.1);
            let codes = if both { [0, 0, away] } else { [0, away, 0] };
            let codes = codes.map(|away| SAMPLES * (STORED + away));
            let mut last = [0; 3];
            for _ in 0..500 {
                last = zero.update(Some((SAMPLES, codes))).unwrap_or(last);
            }
            let followed = last[if both { 2 } else { 1 }];
            ((followed - STORED - away).abs(), zero.is_wrong())
        };
        for both in [false, true] {
            for away in [-16_380, -8_081, -1_640, 0, 1_640, 16_380] {
                let (error, wrong) = take(both, away);
                assert!(error <= 7 && !wrong, "{both} {away}: {error}");
            }
            assert!(take(both, 16_400).1 && take(both, -16_400).1);
        }
    }

    #[test]
    fn currents_that_flow_for_ten_periods_after_the_bridge_opened_do_not_count() {
        let mut zero = ConverterZero::new(true, 0.1);
        take(&mut zero, 30_000, 10);
        assert_eq!(take(&mut zero, 0, 22), Some([STORED; 2]));
        assert!(!zero.is_wrong());
    }

    #[test]
    fn an_error_within_the_bound_is_followed_when_the_mean_counts() {
        let mut zero = ConverterZero::new(true, 0.1);
        let bound = zero.bound;
        assert_eq!(take(&mut zero, bound, 31), None);
        let [a, b] = take(&mut zero, bound, 1).expect("a zero");
        for followed in [a - STORED, STORED - b] {
            assert!((bound - followed).abs() <= 1, "{followed} of {bound}");
        }
        assert!(!zero.is_wrong());
    }

    #[test]
    fn a_constant_error_is_followed_to_the_code() {
        let zero = ConverterZero::new(true, 0.1);
        for error in -zero.bound..=zero.bound {
            let followed = take(&mut zero.clone(), error, 60);
            assert_eq!(followed, Some([STORED + error, STORED - error]));
        }
    }

    #[test]
    fn one_disturbed_period_accuses_nobody_and_moves_the_zero_by_an_eighth_of_the_bound() {
        for disturbed in 0..60 {
            let mut zero = ConverterZero::new(true, 0.1);
            for period in 0..60 {
                let away = if period == disturbed { 30_000 } else { 0 };
                if let Some([a, b]) = take(&mut zero, away, 1) {
                    let moved = (a - STORED).abs().max((b - STORED).abs());
                    assert!(moved <= zero.bound / 8 + 1, "{disturbed} {period}: {moved}");
                }
                assert!(!zero.is_wrong(), "{disturbed} {period}");
            }
        }
    }

    #[test]
    fn a_larger_error_is_wrong_until_the_settings_change() {
        let mut zero = ConverterZero::new(true, 0.1);
        let bound = zero.bound;
        take(&mut zero, bound + 2, 29);
        assert!(!zero.is_wrong());
        take(&mut zero, bound + 2, 1);
        assert!(zero.is_wrong());
        zero.update(None);
        assert!(zero.is_wrong());
        zero.set([STORED; 2]);
        assert!(!zero.is_wrong());
    }
}

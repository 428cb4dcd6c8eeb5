//! Monitors age and rate of one sensor.

use super::trust::{Reason, Trust};
use crate::math::{clamp, max, to_i32};

/// Minimum age of the newest usable reading from which a sensor is in doubt, and from which it is
/// not trusted, s.
const DOUBTED_AGE: f32 = 0.015;
const LOST_AGE: f32 = 0.05;
/// The same ages in periods of the sensor. The longer time counts.
const DOUBTED_PERIODS: f32 = 2.5;
const LOST_PERIODS: f32 = 5.0;
/// Minimum time over which the rate is measured, s, and the same in periods of the sensor.
const WINDOW: f32 = 0.25;
const WINDOW_PERIODS: f32 = 20.0;
/// Rate below which a sensor is too slow, as a fraction of the rate in its setting.
const SLOW: f32 = 0.75;

/// What the guard publishes of one sensor (objects 0x2100 to 0x2102).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct SensorState {
    /// Code of the trust in it ([`Trust::code`]).
    pub health: u8,
    /// Measured rate of its usable readings, 0.1 Hz.
    pub rate: u16,
    /// Age of its newest usable reading, ms. It stops rising a second after the sensor is lost.
    pub age_ms: u16,
}

impl SensorState {
    /// What `watch` and the `trust` in the sensor say.
    pub fn new(watch: &SensorWatch, trust: Trust) -> Self {
        Self {
            health: trust.code(),
            rate: to_i32(watch.rate * 10.0) as u16,
            age_ms: to_i32(watch.age * 1e3) as u16,
        }
    }
}

/// Monitor of one sensor.
#[derive(Clone, Debug)]
pub struct SensorWatch {
    period: f32,
    age: f32,
    /// Time since the newest reading, usable or not, s.
    silence: f32,
    complaint: Reason,
    window: f32,
    readings: f32,
    rate: f32,
    slow: bool,
}

impl SensorWatch {
    /// Monitor of a sensor that measures `rate` times per second, at least once.
    pub fn new(rate: f32) -> Self {
        let period = 1.0 / max(rate, 1.0);
        let mut watch = Self {
            period,
            age: 0.0,
            silence: 0.0,
            complaint: Reason::Silent,
            window: 0.0,
            readings: 0.0,
            rate: 0.0,
            slow: false,
        };
        watch.age = watch.lost_age();
        watch
    }

    /// Advances by one control period of `period` s. `reading` says whether the sensor has a new
    /// reading, and whether it can be used.
    pub fn advance(&mut self, reading: Option<Result<(), Reason>>, period: f32) {
        // Ages beyond the last threshold make no difference.
        let most = self.lost_age() + 1.0;
        self.age = clamp(self.age + period, 0.0, most);
        self.silence = clamp(self.silence + period, 0.0, most);
        match reading {
            Some(Ok(())) => {
                if self.age >= self.lost_age() {
                    // A sensor that begins or comes back is measured from here on.
                    (self.window, self.readings, self.slow) = (0.0, -1.0, false);
                }
                (self.age, self.silence) = (0.0, 0.0);
                self.readings += 1.0;
            }
            Some(Err(reason)) => (self.silence, self.complaint) = (0.0, reason),
            // A late reading is silence, whatever was wrong with the one before.
            None if self.silence > DOUBTED_PERIODS * self.period => {
                self.complaint = Reason::Silent;
            }
            None => {}
        }
        self.window += period;
        let whole = max(WINDOW, WINDOW_PERIODS * self.period);
        if self.window >= whole {
            self.rate = self.readings / self.window;
            self.slow = self.rate * self.period < SLOW;
            (self.window, self.readings) = (0.0, 0.0);
        }
    }

    /// Time between two readings by the setting, s.
    pub fn period(&self) -> f32 {
        self.period
    }

    /// Age of the newest usable reading, s. It stops rising a second after the sensor is lost.
    pub fn age(&self) -> f32 {
        self.age
    }

    /// Measured rate of usable readings, Hz; 0 until it was measured once.
    pub fn rate(&self) -> f32 {
        self.rate
    }

    /// How far the sensor is trusted by its age and its rate.
    pub fn trust(&self) -> Trust {
        let doubted = max(DOUBTED_AGE, DOUBTED_PERIODS * self.period);
        // The comparison is false for NaN.
        if !(self.age < self.lost_age()) {
            Trust::None(self.complaint)
        } else if self.age >= doubted {
            Trust::Degraded(self.complaint)
        } else if self.slow {
            Trust::Degraded(Reason::Slow)
        } else {
            Trust::Full
        }
    }

    fn lost_age(&self) -> f32 {
        max(LOST_AGE, LOST_PERIODS * self.period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a sensor with the setting `rate` that measures every `every` ms, for `time` ms.
    fn run(watch: &mut SensorWatch, every: u32, time: u32) {
        for step in 0..time {
            let reading = step.is_multiple_of(every).then_some(Ok(()));
            watch.advance(reading, 1e-3);
        }
    }

    #[test]
    fn a_sensor_at_its_own_rate_is_trusted_whatever_the_rate() {
        for rate in [20, 50, 100, 125, 200, 500, 1_000] {
            let mut watch = SensorWatch::new(rate as f32);
            assert_eq!(watch.trust(), Trust::None(Reason::Silent));
            for _ in 0..3_000 / (1_000 / rate) {
                run(&mut watch, 1_000 / rate, 1_000 / rate);
                assert_eq!(watch.trust(), Trust::Full, "{rate} Hz");
            }
            assert!((watch.rate() - rate as f32).abs() < 0.06 * rate as f32);
        }
    }

    #[test]
    fn silence_is_doubted_after_two_and_a_half_periods_and_lost_after_five() {
        for (rate, doubted, lost) in [(1_000, 15, 50), (100, 25, 50), (50, 50, 100)] {
            let mut watch = SensorWatch::new(rate as f32);
            run(&mut watch, 1_000 / rate, 2_000);
            // The last reading is one period old, less a millisecond.
            let mut silent = 1_000 / rate - 1;
            let (mut first_doubt, mut first_loss) = (0, 0);
            while first_loss == 0 {
                watch.advance(None, 1e-3);
                silent += 1;
                match watch.trust() {
                    Trust::Degraded(Reason::Silent) if first_doubt == 0 => first_doubt = silent,
                    Trust::None(Reason::Silent) => first_loss = silent,
                    _ => {}
                }
            }
            assert!(
                first_doubt.abs_diff(doubted) <= 1,
                "{rate} Hz: {first_doubt} ms"
            );
            assert!(first_loss.abs_diff(lost) <= 1, "{rate} Hz: {first_loss} ms");
        }
    }

    #[test]
    fn half_the_rate_is_named_within_two_windows_and_forgiven_when_it_ends() {
        for rate in [50, 100, 1_000] {
            let (period, window) = (1_000 / rate, (20_000 / rate).max(250));
            let mut watch = SensorWatch::new(rate as f32);
            run(&mut watch, period, 2_000);
            assert_eq!(watch.trust(), Trust::Full);
            run(&mut watch, 2 * period, 2 * window);
            assert_eq!(watch.trust(), Trust::Degraded(Reason::Slow), "{rate} Hz");
            run(&mut watch, period, 2 * window);
            assert_eq!(watch.trust(), Trust::Full, "{rate} Hz");
        }
    }
}

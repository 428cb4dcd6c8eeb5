//! Classifies the narrowest margin into four bands of tip-over danger.
//!
//! A margin is the horizontal distance of the centre of gravity to an edge of the support, m,
//! positive inside. A hysteresis and a dwell time keep the band from changing too often; large
//! excursions change it faster.

use super::parameters::Parameters;
use super::support::narrowest;

/// Band of the narrowest margin, in the order of increasing danger.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Band {
    /// Above the caution margin: commands pass unchanged.
    Free = 0,
    /// Below the caution margin: commands are scaled.
    Caution = 1,
    /// Below the stop margin, or a margin is unknown (also before the first one): only motion away
    /// from the edge passes.
    #[default]
    Limit = 2,
    /// Below the trip margin: the guard trips.
    Stop = 3,
}

impl Band {
    /// Returns the band with this number (object 0x4006:1).
    pub fn from_byte(byte: u8) -> Option<Self> {
        [Self::Free, Self::Caution, Self::Limit, Self::Stop]
            .into_iter()
            .find(|band| *band as u8 == byte)
    }

    /// Name in logs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Caution => "caution",
            Self::Limit => "limit",
            Self::Stop => "stop",
        }
    }

    /// Band of one margin by the levels alone; [`Band::Stop`] for a margin that is not finite.
    fn of(margin: f32, parameters: &Parameters) -> Self {
        if !margin.is_finite() || margin < parameters.trip {
            Self::Stop
        } else if margin < parameters.stop {
            Self::Limit
        } else if margin < parameters.caution {
            Self::Caution
        } else {
            Self::Free
        }
    }
}

/// Tracks the current band.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    band: Band,
    /// How long the samples have been in a worse and in a better band than the current one, s.
    worse: f32,
    better: f32,
}

impl Bands {
    /// Updates the band with the margins, `period` s after the previous update. The narrowest
    /// margin counts.
    ///
    /// A change to a worse band takes the dwell time. If the robot is outside the support (a margin
    /// below zero, a "large excursion"), two samples are enough; a single one is not. A change to a
    /// better band takes the dwell time, with the margin above the level by the hysteresis. If a
    /// margin is not finite, the band becomes at least [`Band::Limit`] at once and [`Band::Stop`]
    /// after the dwell time.
    pub fn update(&mut self, margins: &[f32; 4], period: f32, parameters: &Parameters) -> Band {
        let narrowest = margins[narrowest(margins) as usize];
        let known = margins.iter().all(|margin| margin.is_finite());
        let narrowest = if known { narrowest } else { f32::NAN };
        if !known && self.band < Band::Limit {
            self.band = Band::Limit;
        }
        let sample = Band::of(narrowest, parameters);
        let spared = Band::of(narrowest - parameters.hysteresis, parameters);
        // A period that is negative or NaN counts as zero.
        let period = if period > 0.0 { period } else { 0.0 };
        let outside = known && narrowest < 0.0;
        let enough = if outside {
            1.5 * period
        } else {
            parameters.dwell
        };
        self.worse = if sample > self.band {
            self.worse + period
        } else {
            0.0
        };
        self.better = if spared < self.band {
            self.better + period
        } else {
            0.0
        };
        if self.worse > 0.0 && self.worse >= enough {
            (self.band, self.worse) = (sample, 0.0);
        } else if self.better > 0.0 && self.better >= parameters.dwell {
            (self.band, self.better) = (spared, 0.0);
        }
        self.band
    }

    /// The present band.
    pub fn band(&self) -> Band {
        self.band
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    /// Bands after one second with the margin `margin`.
    fn settled(margin: f32) -> Bands {
        let mut bands = Bands::default();
        run(&mut bands, margin, 250);
        bands
    }

    fn run(bands: &mut Bands, margin: f32, samples: usize) -> Band {
        let parameters = Parameters::new(&Settings::default());
        (0..samples)
            .map(|_| bands.update(&[0.3, margin, 0.2, 0.2], 4e-3, &parameters))
            .last()
            .expect("at least one sample")
    }

    #[test]
    fn the_band_is_that_of_the_narrowest_margin() {
        for (margin, band) in [
            (0.101, Band::Free),
            (0.07, Band::Caution),
            (0.04, Band::Limit),
            (0.005, Band::Stop),
        ] {
            assert_eq!(settled(margin).band(), band, "{margin}");
        }
    }

    #[test]
    fn no_single_sample_changes_it_and_an_excursion_takes_two() {
        let mut bands = settled(0.2);
        assert_eq!(run(&mut bands, -0.3, 1), Band::Free);
        assert_eq!(run(&mut bands, -0.3, 1), Band::Stop);
        let mut bands = settled(0.2);
        assert_eq!(run(&mut bands, 0.005, 2), Band::Free);
        // With the two samples before, 24 samples of 4 ms exceed the dwell time of 100 ms.
        assert_eq!(run(&mut bands, 0.005, 24), Band::Stop);
    }

    #[test]
    fn a_margin_that_dances_about_a_level_does_not() {
        let mut bands = settled(0.08);
        for _ in 0..500 {
            assert_eq!(run(&mut bands, 0.095, 1), Band::Caution);
            assert_eq!(run(&mut bands, 0.085, 1), Band::Caution);
        }
        assert_eq!(run(&mut bands, 0.101, 26), Band::Free);
    }

    #[test]
    fn what_is_no_number_is_never_free() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut bands = settled(0.2);
            let mut margins = [0.3; 4];
            margins[2] = bad;
            let parameters = Parameters::new(&Settings::default());
            assert!(bands.update(&margins, 4e-3, &parameters) >= Band::Limit);
            assert_eq!(run(&mut bands, f32::NAN, 26), Band::Stop);
        }
        assert_ne!(Bands::default().band(), Band::Free);
    }
}

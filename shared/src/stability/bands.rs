//! How near to falling a robot is, in four bands: with hysteresis, a dwell time, and a fast path for large excursions.

use super::parameters::Parameters;
use super::support::narrowest;

/// Band of the narrowest margin.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Band {
    /// Above the caution margin: commands pass as asked.
    Free = 0,
    /// Below it: commands are scaled.
    Caution = 1,
    /// Below the stop margin, or nothing is known (also before the first margin): only what leads away from the edge passes.
    #[default]
    Limit = 2,
    /// Below the trip margin: the guard trips.
    Stop = 3,
}

impl Band {
    /// The band with this number (object 0x4006:1).
    pub fn from_byte(byte: u8) -> Option<Self> {
        [Self::Free, Self::Caution, Self::Limit, Self::Stop]
            .into_iter()
            .find(|band| *band as u8 == byte)
    }

    /// Its name, as logs and reports show it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Caution => "caution",
            Self::Limit => "limit",
            Self::Stop => "stop",
        }
    }

    /// Band of one margin by the levels alone; a margin that is no finite number is [`Band::Stop`].
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

/// The present band.
#[derive(Clone, Debug, Default)]
pub struct Bands {
    band: Band,
    /// How long samples have been on the worse or the better side of it, s.
    worse: f32,
    better: f32,
}

impl Bands {
    /// Takes the margins `period` s after those before; the narrowest counts.
    ///
    /// A worse band must last for the dwell time. Outside of the support ("large excursion": a margin below zero), two samples do; one never does.
    /// A better band must last as long, with the hysteresis to spare. Margins that are no numbers count as the worst at once up to [`Band::Limit`], and
    /// to [`Band::Stop`] after the dwell time.
    pub fn update(&mut self, margins: &[f32; 4], period: f32, parameters: &Parameters) -> Band {
        let narrowest = margins[narrowest(margins) as usize];
        let known = margins.iter().all(|margin| margin.is_finite());
        let narrowest = if known { narrowest } else { f32::NAN };
        if !known && self.band < Band::Limit {
            self.band = Band::Limit;
        }
        let sample = Band::of(narrowest, parameters);
        let spared = Band::of(narrowest - parameters.hysteresis, parameters);
        // A time of which nothing is known passes too.
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

    /// Bands that have seen `margin` for a second.
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
        // 100 ms.
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

//! Samples the inclinometer at its rate.
//!
//! A plant updates its sensors in every step. The chips of the other sensors, which the guard's
//! node simulates, have rates of their own.

use tautrack::link::{BodyMeasurands, STEP_US};

/// Inclinometer with its rate.
#[derive(Clone, Debug)]
pub struct Sampling {
    inclinometer_hz: u64,
    begun: bool,
}

impl Sampling {
    /// Inclinometer before its first reading.
    pub fn new(inclinometer_hz: u64) -> Self {
        Self {
            inclinometer_hz,
            begun: false,
        }
    }

    /// Returns what the guard's board gets in step number `step`, in which the inclinometer could
    /// measure `now`.
    pub fn sample(&mut self, step: u64, now: BodyMeasurands) -> BodyMeasurands {
        let measures = !self.begun || due(step, self.inclinometer_hz);
        self.begun = true;
        BodyMeasurands {
            inclination: now.inclination.filter(|_| measures),
            ..now
        }
    }
}

/// Whether a sensor with this rate measures in this step.
fn due(step: u64, hz: u64) -> bool {
    let readings = |step: u64| step * STEP_US * hz / 1_000_000;
    readings(step) > readings(step.saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inclinometer_shows_as_many_readings_as_its_rate_says() {
        for rate in [1_000, 66, 50, 25] {
            let mut sampling = Sampling::new(rate);
            let now = BodyMeasurands {
                inclination: Some([0.1, 0.2]),
                ..BodyMeasurands::default()
            };
            assert_eq!(sampling.sample(0, now).inclination, now.inclination);
            let shown = (1..=1_000).filter(|step| {
                let sampled = sampling.sample(*step, now);
                assert!(
                    sampled
                        .inclination
                        .is_none_or(|angles| angles == [0.1, 0.2])
                );
                sampled.inclination.is_some()
            });
            assert_eq!(shown.count() as u64, rate);
        }
    }
}

//! Samples the sensors on the body at the rate of each.
//!
//! A plant updates its sensors in every step. A sensor with a lower rate shows the reading of one
//! step until the next one is due.

use tautrack::link::STEP_US;
use tautrack::sensors::{BodySensors, Fresh};

/// Sensors on the body with their rates.
#[derive(Clone, Debug)]
pub struct Sampling {
    inertial_hz: u64,
    inclinometer_hz: u64,
    shown: Option<BodySensors>,
}

impl Sampling {
    /// Sensors before their first reading.
    pub fn new(inertial_hz: u64, inclinometer_hz: u64) -> Self {
        Self {
            inertial_hz,
            inclinometer_hz,
            shown: None,
        }
    }

    /// Returns what the sensors show in step number `step`, in which they could measure `now`.
    ///
    /// The plant gives its magnetometer a rate. A new value is a new reading of it.
    pub fn sample(&mut self, step: u64, now: BodySensors) -> BodySensors {
        let Some(mut shown) = self.shown else {
            return *self.shown.insert(BodySensors {
                fresh: Fresh::ALL,
                ..now
            });
        };
        let inertial = due(step, self.inertial_hz);
        shown.fresh = Fresh {
            inclinometer: due(step, self.inclinometer_hz),
            accelerometer: inertial,
            gyroscope: inertial,
            magnetometer: now.magnetic_field != shown.magnetic_field,
        };
        if shown.fresh.inclinometer {
            shown.inclination = now.inclination;
        }
        if inertial {
            shown.specific_force = now.specific_force;
            shown.angular_rate = now.angular_rate;
        }
        shown.magnetic_field = now.magnetic_field;
        *self.shown.insert(shown)
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
    fn each_sensor_shows_as_many_readings_as_its_rate_says() {
        for (inertial, inclinometer) in [(1_000, 1_000), (66, 50), (100, 25)] {
            let mut sampling = Sampling::new(inertial, inclinometer);
            let mut counts = [0_u64; 3];
            for step in 0..=1_000_u64 {
                let value = (step + 1) as f32;
                let now = BodySensors {
                    inclination: [value; 2],
                    specific_force: [value; 3],
                    angular_rate: [value; 3],
                    magnetic_field: [(step / 100) as f32; 3],
                    fresh: Fresh::ALL,
                };
                let shown = sampling.sample(step, now);
                assert_eq!(shown.fresh.gyroscope, shown.angular_rate[0] == value);
                assert_eq!(shown.fresh.inclinometer, shown.inclination[0] == value);
                if step > 0 {
                    counts[0] += u64::from(shown.fresh.gyroscope);
                    counts[1] += u64::from(shown.fresh.inclinometer);
                    counts[2] += u64::from(shown.fresh.magnetometer);
                }
            }
            assert_eq!(counts, [inertial, inclinometer, 10]);
        }
    }
}

//! Evaluates how far the body sensors can be trusted. Doubtful sensors first slow the robot down,
//! then stop it; they never count as stable.

use super::field_watch::FieldWatch;
use super::noise_watch::NoiseWatch;
use super::sensor_watch::SensorWatch;
use super::stuck::Stuck;
use super::trust::{Reason, Trust};
use crate::constants::{CONTROL_PERIOD, GRAVITY};
use crate::estimate::attitude::Attitude;
use crate::math::max;
use crate::math::vector::Vector;
use crate::sensors::{BodySensors, Fresh, Sensor};
use crate::settings::{Setting, Settings};

/// Largest readings that such sensors give: inclination in rad (either way up and a little more),
/// specific force in m/s^2 (16 g), angular rate in rad/s (2000 degrees/s), flux density in uT.
const INCLINATION_RANGE: f32 = 3.2;
const FORCE_RANGE: f32 = 160.0;
const RATE_RANGE: f32 = 35.0;
const FIELD_RANGE: f32 = 5_000.0;
/// Smallest changes that count as noise if the next reading takes them back, in the same units and
/// order. An angular acceleration of [`ANGULAR_ACCELERATION`] changes the rate by 1 rad/s in 50 ms,
/// the longest period of a gyroscope. An acceleration of 1 g turns the inclinometer's reading by
/// 0.8 rad. Turned upside down between two readings, a magnetometer changes by twice the strongest
/// field of the earth.
const NOISE: [f32; ON_BODY] = [1.0, GRAVITY, 1.0, 130.0];
/// Duration of a contradiction from which the sensors are in doubt, and from which they are not
/// trusted, s. A fall onto the next nose (front edge of a step) lasts 0.5 s.
const DOUBTED_AFTER: f32 = 0.75;
const LOST_AFTER: f32 = 2.0;
/// Largest deviation of the specific force from 1 g, as a fraction of 1 g, while the robot is slow.
const OFF_GRAVITY: f32 = 0.15;
/// Tangent of the largest angle between the specific force and the vertical of the attitude filter,
/// while the robot is slow.
const DISAGREEMENT: f32 = 0.15;
/// Angular acceleration that no reading shows yet, rad/s^2. A robot that starts to fall over an
/// edge 0.15 m beside its centre of gravity, 0.2 m high, has `g 0.15 / (0.15^2 + 0.2^2)` = 24
/// rad/s^2 as a point mass; its own inertia makes it less.
const ANGULAR_ACCELERATION: f32 = 20.0;

/// Timer of a contradiction: counts up while the contradiction is present, and down as fast while
/// it is not.
#[derive(Clone, Copy, Debug, Default)]
struct Lasting(f32);

impl Lasting {
    fn update(&mut self, there: bool, period: f32) {
        let next = if there {
            self.0 + period
        } else {
            self.0 - period
        };
        self.0 = crate::math::clamp(next, 0.0, LOST_AFTER + 0.5);
    }

    fn trust(self, reason: Reason) -> Trust {
        // The comparison is false for NaN.
        if !(self.0 < LOST_AFTER) {
            Trust::None(reason)
        } else if self.0 < DOUBTED_AFTER {
            Trust::Full
        } else {
            Trust::Degraded(reason)
        }
    }
}

/// Number of sensors on the body: those of [`Sensor`] without the GNSS receiver.
const ON_BODY: usize = 4;

/// Settings of [`Watch`].
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Expectations {
    /// Number of equal readings after which an axis of the inertial unit counts as stuck; 0: never.
    pub stuck_readings: u32,
    /// Rates of inclinometer, accelerometer, gyroscope and magnetometer, Hz.
    pub rates: [f32; ON_BODY],
}

impl Expectations {
    /// Reads the settings.
    pub fn new(settings: &Settings) -> Self {
        let rate = |setting| settings.get(setting) as f32;
        Self {
            stuck_readings: settings.get(Setting::StuckReadings) as u32,
            rates: [
                rate(Setting::InclinometerRate),
                rate(Setting::InertialRate),
                rate(Setting::InertialRate),
                rate(Setting::CompassRate),
            ],
        }
    }
}

/// Monitors the readings of the body sensors.
#[derive(Clone, Debug)]
pub struct Watch {
    sensors: [SensorWatch; ON_BODY],
    noise: [NoiseWatch; ON_BODY],
    stuck: Stuck,
    field: FieldWatch,
    off_gravity: Lasting,
    disagreement: Lasting,
}

impl Watch {
    /// Monitor of sensors that should be like this.
    pub fn new(expectations: &Expectations) -> Self {
        Self {
            sensors: expectations.rates.map(SensorWatch::new),
            noise: core::array::from_fn(|sensor| {
                NoiseWatch::new(NOISE[sensor], expectations.rates[sensor])
            }),
            stuck: Stuck::new(expectations.stuck_readings),
            field: FieldWatch::default(),
            off_gravity: Lasting::default(),
            disagreement: Lasting::default(),
        }
    }

    /// Takes the readings of one control period, if there are any. Returns which of them are new
    /// and may be used.
    pub fn receive(&mut self, sensors: Option<&BodySensors>, period: f32) -> Fresh {
        let Some(sensors) = sensors else {
            for watch in &mut self.sensors {
                watch.advance(None, period);
            }
            return Fresh::NONE;
        };
        let fresh = sensors.fresh;
        let found = [
            (
                fresh.inclinometer,
                &sensors.inclination[..],
                INCLINATION_RANGE,
            ),
            (fresh.accelerometer, &sensors.specific_force, FORCE_RANGE),
            (fresh.gyroscope, &sensors.angular_rate, RATE_RANGE),
            (fresh.magnetometer, &sensors.magnetic_field, FIELD_RANGE),
        ];
        let mut usable = [false; ON_BODY];
        for (index, (new, values, range)) in found.into_iter().enumerate() {
            let mut reading = new.then(|| plausible(values, range));
            if index == Sensor::Magnetometer as usize
                && reading == Some(Ok(()))
                && self.field.repeats(values)
            {
                reading = Some(Err(Reason::Stuck));
            }
            usable[index] = reading == Some(Ok(()));
            self.sensors[index].advance(reading, period);
            if usable[index] {
                self.noise[index].receive(values);
            }
        }
        let [inclinometer, accelerometer, gyroscope, magnetometer] = usable;
        let usable = Fresh {
            inclinometer,
            accelerometer,
            gyroscope,
            magnetometer,
        };
        if usable.gyroscope {
            let period = self.sensors[Sensor::Gyroscope as usize].period();
            self.field.turn(&sensors.angular_rate, period);
        }
        self.stuck.receive(sensors, usable);
        usable
    }

    /// Compares the sensors with each other, once per evaluation: the low-passed specific `force`
    /// in level axes with gravity, and repeated readings with the `attitude`. `slow` means that the
    /// robot does not accelerate enough to explain a difference.
    pub fn compare(&mut self, force: Vector<f32>, attitude: &Attitude, slow: bool, period: f32) {
        let across = force[0] * force[0] + force[1] * force[1];
        let square = across + force[2] * force[2];
        let bound = |share: f32| GRAVITY * GRAVITY * share * share;
        let is_gravity = square > bound(1.0 - OFF_GRAVITY) && square < bound(1.0 + OFF_GRAVITY);
        let agrees = force[2] > 0.0 && across < DISAGREEMENT * DISAGREEMENT * force[2] * force[2];
        self.stuck.compare(attitude, period);
        // While the robot is fast, the timers stand still.
        let period = if slow { period } else { 0.0 };
        self.off_gravity.update(!is_gravity, period);
        self.disagreement.update(!agrees, period);
    }

    /// Current trust in the sensors. It does not depend on the magnetometer, because balance does
    /// not.
    pub fn trust(&self) -> Trust {
        self.own_trust()
            .or(self.disagreement.trust(Reason::Disagreement))
            .or(self.off_gravity.trust(Reason::OffGravity))
    }

    /// Current trust in these sensors, each by its own readings alone.
    pub fn own_trust(&self) -> Trust {
        self.trust_in(Sensor::Inclinometer)
            .or(self.trust_in(Sensor::Gyroscope))
            .or(self.trust_in(Sensor::Accelerometer))
    }

    /// Current trust in one sensor on the body by its own readings; full for another sensor.
    pub fn trust_in(&self, sensor: Sensor) -> Trust {
        let number = sensor as usize;
        let trust = match (self.sensors.get(number), self.noise.get(number)) {
            (Some(watch), Some(noise)) => watch.trust().or(noise.trust()),
            _ => Trust::Full,
        };
        match sensor {
            Sensor::Magnetometer | Sensor::GnssReceiver => trust,
            _ => trust.or(self.stuck.trust(number)),
        }
    }

    /// Age and measured rate of a sensor on the body; `None` for another sensor.
    pub fn sensor(&self, sensor: Sensor) -> Option<&SensorWatch> {
        self.sensors.get(sensor as usize)
    }

    /// Time between two readings of a sensor on the body by its setting, s; 0 for another sensor.
    pub fn period(&self, sensor: Sensor) -> f32 {
        self.sensor(sensor).map_or(0.0, SensorWatch::period)
    }

    /// How far the attitude may have turned without a reading of the gyroscope that shows it, rad:
    /// `a t^2 / 2` in the time `t` since the newest reading. The rate of that reading is known, and
    /// the attitude goes on with it.
    ///
    /// The time is at least the period between two readings, so that the result does not swing
    /// with every reading. A gyroscope that measures in every control period has no such time.
    pub fn unseen_rotation(&self) -> f32 {
        let watch = &self.sensors[Sensor::Gyroscope as usize];
        let time = max(watch.age(), watch.period()) - CONTROL_PERIOD;
        if time > 0.0 {
            0.5 * ANGULAR_ACCELERATION * time * time
        } else {
            0.0
        }
    }
}

/// Checks that every value is finite and within the range of such a sensor.
fn plausible(values: &[f32], range: f32) -> Result<(), Reason> {
    let (mut finite, mut within) = (true, true);
    for value in values {
        finite &= value.is_finite();
        within &= value.abs() <= range;
    }
    match (finite, within) {
        (false, _) => Err(Reason::NotFinite),
        (_, false) => Err(Reason::OutOfRange),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPECTED: Expectations = Expectations {
        stuck_readings: 200,
        rates: [1_000.0, 1_000.0, 1_000.0, 10.0],
    };

    /// Readings of a robot at rest; the last digits of every reading are noise.
    fn reading(step: u32) -> BodySensors {
        let noise = |channel: u32| 1e-3 * ((step * 7 + channel) % 5) as f32;
        BodySensors {
            inclination: [noise(0), noise(1)],
            specific_force: [noise(2), noise(3), GRAVITY + noise(4)],
            angular_rate: [noise(5), noise(6), noise(7)],
            ..BodySensors::default()
        }
    }

    fn watched(steps: u32, change: impl Fn(&mut BodySensors)) -> Watch {
        let (mut watch, level) = (Watch::new(&EXPECTED), Attitude::default());
        for step in 0..steps {
            let mut sensors = reading(step);
            change(&mut sensors);
            watch.receive(Some(&sensors), 1e-3);
            if step % 4 == 0 {
                watch.compare(sensors.specific_force, &level, true, 4e-3);
            }
        }
        watch
    }

    #[test]
    fn sound_sensors_are_believed_and_nothing_before_the_first_reading() {
        assert_eq!(watched(3_000, |_| ()).trust(), Trust::Full);
        assert_eq!(Watch::new(&EXPECTED).trust(), Trust::None(Reason::Silent));
    }

    #[test]
    fn silence_is_doubted_then_not_believed() {
        let mut watch = watched(100, |_| ());
        let mut run = |ticks| {
            (0..ticks).for_each(|_| {
                watch.receive(None, 1e-3);
            });
            watch.trust()
        };
        assert_eq!(run(10), Trust::Full);
        assert_eq!(run(10), Trust::Degraded(Reason::Silent));
        assert_eq!(run(40), Trust::None(Reason::Silent));
    }

    #[test]
    fn each_sensor_has_its_own_rate_and_its_own_silence() {
        let mut watch = Watch::new(&Expectations {
            rates: [50.0, 100.0, 100.0, 10.0],
            ..EXPECTED
        });
        let mut run = |steps: core::ops::Range<u32>, gyroscope: bool| {
            for step in steps {
                let fresh = Fresh {
                    inclinometer: step % 20 == 0,
                    accelerometer: step % 10 == 0,
                    gyroscope: gyroscope && step % 10 == 0,
                    magnetometer: step % 100 == 0,
                };
                let sensors = BodySensors {
                    fresh,
                    ..reading(step / 10)
                };
                assert_eq!(watch.receive(Some(&sensors), 1e-3), fresh);
            }
            Sensor::ALL.map(|sensor| watch.trust_in(sensor))
        };
        assert_eq!(run(0..3_000, true), [Trust::Full; 5]);
        let silent = run(3_000..3_060, false);
        assert_eq!(silent[2], Trust::None(Reason::Silent));
        assert_eq!([silent[0], silent[1], silent[3]], [Trust::Full; 3]);
        assert_eq!(watch.trust(), Trust::None(Reason::Silent));
    }

    #[test]
    fn balance_does_not_depend_on_the_magnetometer() {
        let absent = |sensors: &mut BodySensors| sensors.fresh.magnetometer = false;
        let watch = watched(3_000, absent);
        assert_eq!(watch.trust(), Trust::Full);
        assert_eq!(
            watch.trust_in(Sensor::Magnetometer),
            Trust::None(Reason::Silent)
        );
    }

    #[test]
    fn readings_that_cannot_be_are_not_used_and_named() {
        for (bad, reason) in [
            (f32::NAN, Reason::NotFinite),
            (f32::NEG_INFINITY, Reason::NotFinite),
            (500.0, Reason::OutOfRange),
        ] {
            let mut watch = watched(100, |_| ());
            for step in 0..60 {
                let mut sensors = reading(step);
                sensors.angular_rate[1] = bad;
                let usable = watch.receive(Some(&sensors), 1e-3);
                assert!(!usable.gyroscope && usable.inclinometer && usable.accelerometer);
            }
            assert_eq!(watch.trust(), Trust::None(reason));
        }
    }

    #[test]
    fn a_force_that_is_not_gravity_counts_when_it_lasts() {
        let weak = |sensors: &mut BodySensors| {
            sensors.specific_force[2] = 0.7 * GRAVITY + sensors.specific_force[1];
        };
        assert_eq!(watched(500, weak).trust(), Trust::Full);
        assert_eq!(
            watched(1_500, weak).trust(),
            Trust::Degraded(Reason::OffGravity)
        );
        assert_eq!(
            watched(2_500, weak).trust(),
            Trust::None(Reason::OffGravity)
        );
    }

    #[test]
    fn an_attitude_that_the_accelerometer_denies_counts_when_it_lasts() {
        // A force in level axes that is tilted by 15 degrees.
        let tilted = |sensors: &mut BodySensors| sensors.specific_force[0] += 0.26 * GRAVITY;
        assert_eq!(
            watched(1_500, tilted).trust(),
            Trust::Degraded(Reason::Disagreement)
        );
        assert_eq!(
            watched(2_500, tilted).trust(),
            Trust::None(Reason::Disagreement)
        );
    }

    /// The unseen rotation is half the angular acceleration times the square of the age.
    #[test]
    fn an_old_reading_of_a_slow_gyroscope_hides_a_rotation() {
        assert_eq!(watched(100, |_| ()).unseen_rotation(), 0.0);
        let mut watch = Watch::new(&Expectations {
            rates: [50.0; 4],
            ..EXPECTED
        });
        watch.receive(Some(&reading(0)), 1e-3);
        // 19 ms between the control periods with two readings, then 49 ms.
        assert!((watch.unseen_rotation() - 10.0 * 0.019 * 0.019).abs() < 1e-6);
        for _ in 0..50 {
            watch.receive(None, 1e-3);
        }
        assert!((watch.unseen_rotation() - 10.0 * 0.049 * 0.049).abs() < 1e-5);
    }
}

//! Evaluates how far the body sensors can be trusted. Doubtful sensors first slow the robot down,
//! then stop it; they never count as stable.

use crate::constants::GRAVITY;
use crate::math::vector::Vector;
use crate::sensors::BodySensors;

/// Largest readings that such sensors give: inclination in rad (either way up and a little more),
/// specific force in m/s^2 (16 g), angular rate in rad/s (2000 degrees/s).
const RANGES: [f32; 8] = [3.2, 3.2, 160.0, 160.0, 160.0, 35.0, 35.0, 35.0];
/// Age of the newest plausible reading from which the sensors are in doubt, and from which they are
/// not trusted, s.
const DOUBTED_AGE: f32 = 0.015;
const LOST_AGE: f32 = 0.05;
/// Duration of a contradiction from which the sensors are in doubt, and from which they are not
/// trusted, s. A fall onto the next nose (front edge of a step) lasts 0.5 s.
const DOUBTED_AFTER: f32 = 0.75;
const LOST_AFTER: f32 = 2.0;
/// Largest deviation of the specific force from 1 g, as a fraction of 1 g, while the robot is slow.
const OFF_GRAVITY: f32 = 0.15;
/// Tangent of the largest angle between the specific force and the vertical of the attitude filter,
/// while the robot is slow.
const DISAGREEMENT: f32 = 0.15;

/// Fault of the body sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reason {
    /// No reading was received in time.
    Silent = 1,
    /// Readings are not finite.
    NotFinite = 2,
    /// Readings are beyond the range of such a sensor.
    OutOfRange = 3,
    /// A reading repeats bit-identically, which the reading of a noisy sensor does not do.
    Stuck = 4,
    /// The specific force of a slow robot deviates from 1 g for too long.
    OffGravity = 5,
    /// Accelerometer and attitude filter (gyroscope and inclinometer) disagree on the vertical.
    Disagreement = 6,
}

impl Reason {
    /// Returns the reason with this number.
    pub fn from_byte(byte: u8) -> Option<Self> {
        use Reason::{Disagreement, NotFinite, OffGravity, OutOfRange, Silent, Stuck};
        [
            Silent,
            NotFinite,
            OutOfRange,
            Stuck,
            OffGravity,
            Disagreement,
        ]
        .into_iter()
        .find(|reason| *reason as u8 == byte)
    }

    /// Text in logs and reports.
    pub fn words(self) -> &'static str {
        match self {
            Self::Silent => "sensors silent",
            Self::NotFinite => "sensors not finite",
            Self::OutOfRange => "sensors out of range",
            Self::Stuck => "sensor stuck",
            Self::OffGravity => "force is not gravity",
            Self::Disagreement => "sensors disagree",
        }
    }
}

/// Trust in the body sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Trust {
    /// The sensors are trusted.
    Full,
    /// The sensors are in doubt: the robot may go on slowly.
    Degraded(Reason),
    /// The sensors are not trusted: nothing passes.
    None(Reason),
}

impl Trust {
    /// Code in object 0x4006:2: 0, or 0x10 (degraded) or 0x20 (none) with the reason.
    pub fn code(self) -> u8 {
        match self {
            Self::Full => 0,
            Self::Degraded(reason) => 0x10 | reason as u8,
            Self::None(reason) => 0x20 | reason as u8,
        }
    }

    /// Returns the trust with this code, if there is one.
    pub fn from_code(code: u8) -> Option<Self> {
        if code == 0 {
            return Some(Self::Full);
        }
        let reason = Reason::from_byte(code & 0x0f)?;
        match code >> 4 {
            1 => Some(Self::Degraded(reason)),
            2 => Some(Self::None(reason)),
            _ => None,
        }
    }

    /// The worse of two: none is worse than degraded. The first if both are equally bad.
    fn or(self, other: Self) -> Self {
        if other.code() >> 4 > self.code() >> 4 {
            other
        } else {
            self
        }
    }
}

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

/// Monitors the readings of the body sensors.
#[derive(Clone, Debug)]
pub struct Watch {
    stuck_readings: u32,
    bits: [u32; 8],
    equal: [u32; 8],
    age: f32,
    complaint: Reason,
    off_gravity: Lasting,
    disagreement: Lasting,
}

impl Watch {
    /// Monitor for which a sensor is stuck after `stuck_readings` equal readings; 0 means never.
    pub fn new(stuck_readings: u32) -> Self {
        Self {
            stuck_readings,
            bits: [0; 8],
            equal: [0; 8],
            age: LOST_AGE,
            complaint: Reason::Silent,
            off_gravity: Lasting::default(),
            disagreement: Lasting::default(),
        }
    }

    /// Takes the reading of one control period, if one was received. Returns whether it may be
    /// used.
    ///
    /// The magnetometer is not checked, because balance does not depend on it.
    pub fn receive(&mut self, sensors: Option<&BodySensors>, period: f32) -> bool {
        // Ages beyond the last threshold make no difference.
        self.age = crate::math::clamp(self.age + period, 0.0, 1.0);
        let Some(sensors) = sensors else {
            self.complaint = Reason::Silent;
            return false;
        };
        let [pitch, roll] = sensors.inclination;
        let [x, y, z] = sensors.specific_force;
        let [rate_x, rate_y, rate_z] = sensors.angular_rate;
        let values = [pitch, roll, x, y, z, rate_x, rate_y, rate_z];
        let (mut finite, mut within) = (true, true);
        for (value, range) in values.into_iter().zip(RANGES) {
            finite &= value.is_finite();
            within &= value.abs() <= range;
        }
        for (index, value) in values.into_iter().enumerate() {
            let bits = value.to_bits();
            let equal = self.equal[index].saturating_add(1);
            self.equal[index] = if bits == self.bits[index] { equal } else { 0 };
            self.bits[index] = bits;
        }
        if within {
            self.age = 0.0;
        } else {
            self.complaint = if finite {
                Reason::OutOfRange
            } else {
                Reason::NotFinite
            };
        }
        within
    }

    /// Compares the low-passed specific force in level axes with gravity, once per evaluation.
    /// `slow` means that the robot does not accelerate enough to explain a difference.
    pub fn compare(&mut self, force: Vector<f32>, slow: bool, period: f32) {
        let across = force[0] * force[0] + force[1] * force[1];
        let square = across + force[2] * force[2];
        let bound = |share: f32| GRAVITY * GRAVITY * share * share;
        let is_gravity = square > bound(1.0 - OFF_GRAVITY) && square < bound(1.0 + OFF_GRAVITY);
        let agrees = force[2] > 0.0 && across < DISAGREEMENT * DISAGREEMENT * force[2] * force[2];
        // While the robot is fast, the timers stand still.
        let period = if slow { period } else { 0.0 };
        self.off_gravity.update(!is_gravity, period);
        self.disagreement.update(!agrees, period);
    }

    /// Current trust in the sensors.
    pub fn trust(&self) -> Trust {
        let age = if !(self.age < LOST_AGE) {
            Trust::None(self.complaint)
        } else if self.age < DOUBTED_AGE {
            Trust::Full
        } else {
            Trust::Degraded(self.complaint)
        };
        let longest = self
            .equal
            .iter()
            .fold(0, |most, count| if *count > most { *count } else { most });
        let stuck = match self.stuck_readings {
            0 => Trust::Full,
            limit if longest >= limit.saturating_mul(2) => Trust::None(Reason::Stuck),
            limit if longest >= limit => Trust::Degraded(Reason::Stuck),
            _ => Trust::Full,
        };
        age.or(stuck)
            .or(self.disagreement.trust(Reason::Disagreement))
            .or(self.off_gravity.trust(Reason::OffGravity))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut watch = Watch::new(200);
        for step in 0..steps {
            let mut sensors = reading(step);
            change(&mut sensors);
            watch.receive(Some(&sensors), 1e-3);
            if step % 4 == 0 {
                watch.compare(sensors.specific_force, true, 4e-3);
            }
        }
        watch
    }

    #[test]
    fn sound_sensors_are_believed_and_nothing_before_the_first_reading() {
        assert_eq!(watched(3_000, |_| ()).trust(), Trust::Full);
        assert_eq!(Watch::new(200).trust(), Trust::None(Reason::Silent));
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
                assert!(!watch.receive(Some(&sensors), 1e-3));
            }
            assert_eq!(watch.trust(), Trust::None(reason));
        }
    }

    #[test]
    fn one_stuck_axis_is_enough() {
        let stuck = |sensors: &mut BodySensors| sensors.inclination[1] = 0.1;
        assert_eq!(watched(150, stuck).trust(), Trust::Full);
        assert_eq!(watched(250, stuck).trust(), Trust::Degraded(Reason::Stuck));
        assert_eq!(watched(450, stuck).trust(), Trust::None(Reason::Stuck));
        let mut never = Watch::new(0);
        (0..1_000).for_each(|_| {
            never.receive(Some(&BodySensors::default()), 1e-3);
        });
        assert_eq!(never.trust(), Trust::Full);
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

    #[test]
    fn codes_survive() {
        for code in 0..=0xff_u8 {
            if let Some(trust) = Trust::from_code(code) {
                assert_eq!(trust.code(), code);
            }
        }
        assert_eq!(Trust::from_code(0x24), Some(Trust::None(Reason::Stuck)));
    }
}

//! The state q of the robot: each coordinate with its validity and age.

use super::compass::Compass;
use super::nmea::{Counts, Reader, Sentence};
use super::position::{Fix, Position};
use crate::estimate::attitude::Attitude;
use crate::math::sin_cos;
use crate::sensors::BodySensors;
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// Largest age of a fix at which a position counts as measured, us.
pub const FIX_TIMEOUT_US: u64 = 1_000_000;
/// Largest age of a compass reading at which the heading counts as measured, us.
pub const COMPASS_TIMEOUT_US: u64 = 500_000;
/// Largest age of readings of encoders and attitude at which they count as measured, us. Dead
/// reckoning needs readings that are not older.
pub const ENCODER_TIMEOUT_US: u64 = 60_000;
/// Largest difference of compass and heading at which the heading counts as measured: 10 degrees.
const SETTLED: Angle = Angle::from_degrees(10.0);
/// Maximum time for which one reading of the compass counts, s.
const COMPASS_PERIOD: f32 = 0.2;

/// Quality of a value.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Validity {
    /// It was never measured; the value is 0.
    #[default]
    Invalid = 0,
    /// It is neither measured nor reckoned any more; the value is the last one.
    Stale = 1,
    /// It is carried on from the last measurement, by the distance that the belts travel or by
    /// angular rates. Its error grows with its age.
    Reckoned = 2,
    /// It was measured within the timeout.
    Measured = 3,
}

/// One coordinate of the state.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Reading {
    /// Value, m or rad; 0 while invalid.
    pub value: f32,
    /// Time since the last measurement, ms. It saturates after 71 minutes and is 0 while invalid.
    pub age_ms: u32,
    /// Quality of the value.
    pub validity: Validity,
}

impl Reading {
    /// Creates a reading of `value`, last measured at `measured_us`. If this is longer ago than
    /// `timeout_us`, the value is reckoned or stale.
    fn new(
        value: f32,
        measured_us: Option<u64>,
        timeout_us: u64,
        reckoned: bool,
        now_us: u64,
    ) -> Self {
        let Some(measured_us) = measured_us else {
            return Self::default();
        };
        let age_us = now_us.saturating_sub(measured_us);
        Self {
            value,
            // 32 bits of microseconds are more than an hour, and they divide in one instruction.
            age_ms: u32::try_from(age_us).unwrap_or(u32::MAX) / 1_000,
            validity: if age_us <= timeout_us {
                Validity::Measured
            } else if reckoned {
                Validity::Reckoned
            } else {
                Validity::Stale
            },
        }
    }
}

/// q1 to q8 of Paillat et al. in order; [`super`] has axes and units.
pub type State = [Reading; 8];

/// Position of an actuated joint by its encoder.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct Joint {
    /// q7, rad, or q8, m.
    pub value: f32,
    /// When its drive was last received, us; `None` while its position is not homed.
    pub received_us: Option<u64>,
}

/// Estimator of q: everything between the sensors and the state.
#[derive(Clone, Debug)]
pub struct Estimator {
    reader: Reader,
    compass: Compass,
    position: Position,
    field: [f32; 3],
    sensed_us: u64,
    heading_us: Option<u64>,
    attitude_us: Option<u64>,
    odometry_um: Option<i32>,
    reckoned_us: Option<u64>,
    joints: [Joint; 2],
    /// Newest fix and when it was received, us, until the position is updated.
    fix: Option<(Fix, u64)>,
    /// Speed over ground, m/s, and course, until `take_speed` takes them.
    velocity: Option<(f32, Angle)>,
}

impl Estimator {
    /// Creates an estimator of a robot with these settings.
    pub fn new(settings: &Settings) -> Self {
        Self {
            reader: Reader::default(),
            compass: Compass::with_settings(settings),
            position: Position::new(settings.si(Setting::SpeedLimit)),
            field: [0.0; 3],
            sensed_us: 0,
            heading_us: None,
            attitude_us: None,
            odometry_um: None,
            reckoned_us: None,
            joints: [Joint::default(); 2],
            fix: None,
            velocity: None,
        }
    }

    /// Takes the magnetometer's reading and corrects the heading of `attitude`. Call it after
    /// `attitude` took the other sensors.
    ///
    /// A reading that equals the previous one is not a new one, even if it says so: a defective
    /// magnetometer repeats its reading.
    pub fn sense(&mut self, sensors: &BodySensors, attitude: &mut Attitude, now_us: u64) {
        if sensors.fresh.gyroscope {
            self.attitude_us = Some(now_us);
        }
        let field = sensors.magnetic_field;
        if !sensors.fresh.magnetometer || field == self.field {
            return;
        }
        let elapsed = now_us.saturating_sub(self.sensed_us) as f32 * 1e-6;
        (self.field, self.sensed_us) = (field, now_us);
        let Ok(heading) = self.compass.heading(field, &attitude.level_axes()) else {
            return;
        };
        let period = if elapsed < COMPASS_PERIOD {
            elapsed
        } else {
            COMPASS_PERIOD
        };
        attitude.correct_heading(heading, period);
        let away = (heading - attitude.heading()).to_bits().unsigned_abs();
        if away <= SETTLED.to_bits().unsigned_abs() {
            self.heading_us = Some(now_us);
        }
    }

    /// Takes bytes from the GNSS receiver. A fix changes the position at the next
    /// [`Self::advance`], or when the next fix comes, so that no other tick has this work. Returns
    /// whether a fix came.
    pub fn listen(&mut self, bytes: &[u8], now_us: u64) -> bool {
        let mut fixed = false;
        for byte in bytes {
            let Some(Ok(sentence)) = self.reader.push(*byte) else {
                continue;
            };
            if let Some(fix) = Fix::from_sentence(&sentence) {
                self.take_fix();
                self.fix = Some((fix, now_us));
                fixed = true;
            }
            if let Sentence::Rmc(rmc) = sentence
                && let (Some(_), Some(speed), Some(course)) =
                    (rmc.place, rmc.speed_mm_s, rmc.course)
            {
                let course = Angle::from_degrees(f32::from(course) * 0.01);
                self.velocity = Some((speed as f32 * 1e-3, course));
            }
        }
        fixed
    }

    /// Corrects the position by the fix that waits.
    fn take_fix(&mut self) {
        if let Some((fix, received_us)) = self.fix.take() {
            self.position.fix(&fix, received_us);
        }
    }

    /// Returns the speed along the heading, m/s, if the GNSS receiver has measured one since the
    /// last call. It is signed, because the course tells backward from forward. It does not have
    /// the bias of a noisy magnitude.
    pub fn take_speed(&mut self, attitude: &Attitude) -> Option<f32> {
        let (speed, course) = self.velocity.take()?;
        // The course turns clockwise, the heading counter-clockwise.
        Some(speed * sin_cos(course + attitude.heading()).1)
    }

    /// Takes the encoders: the distance of the belts since power-up (it wraps), the time at which
    /// the older of both belts was received, and the joints.
    pub fn advance(
        &mut self,
        odometry_um: i32,
        belts_us: Option<u64>,
        joints: [Joint; 2],
        attitude: &Attitude,
        now_us: u64,
    ) {
        self.take_fix();
        self.joints = joints;
        let before = self.odometry_um.replace(odometry_um);
        let way = odometry_um.wrapping_sub(before.unwrap_or(odometry_um));
        let known = fresh(belts_us, now_us) && fresh(self.attitude_us, now_us);
        if known && self.heading_us.is_some() {
            self.position
                .advance(way, attitude.heading(), &attitude.level_axes());
            self.reckoned_us = Some(now_us);
        }
    }

    /// Returns the state at `now_us`.
    pub fn state(&self, attitude: &Attitude, now_us: u64) -> State {
        let [level_us, up_us] = self.position.fixed_us();
        let [north, east, up] = self.position.metres();
        let reckoned = fresh(self.reckoned_us, now_us);
        let turning = fresh(self.attitude_us, now_us);
        let place =
            |value, fixed_us| Reading::new(value, fixed_us, FIX_TIMEOUT_US, reckoned, now_us);
        let tilt = |angle: Angle| {
            Reading::new(
                angle.radians(),
                self.attitude_us,
                ENCODER_TIMEOUT_US,
                false,
                now_us,
            )
        };
        let joint = |joint: Joint| {
            Reading::new(
                joint.value,
                joint.received_us,
                ENCODER_TIMEOUT_US,
                false,
                now_us,
            )
        };
        [
            place(north, level_us),
            place(east, level_us),
            place(up, up_us),
            Reading::new(
                attitude.heading().radians(),
                self.heading_us,
                COMPASS_TIMEOUT_US,
                turning,
                now_us,
            ),
            tilt(attitude.roll()),
            tilt(attitude.pitch()),
            joint(self.joints[0]),
            joint(self.joints[1]),
        ]
    }

    /// Returns the estimate of the position, with its origin and the counts of fixes.
    pub fn position(&self) -> &Position {
        &self.position
    }

    /// Returns the counts of the receiver's sentences.
    pub fn sentences(&self) -> &Counts {
        self.reader.counts()
    }
}

fn fresh(received_us: Option<u64>, now_us: u64) -> bool {
    received_us.is_some_and(|received_us| now_us.saturating_sub(received_us) <= ENCODER_TIMEOUT_US)
}

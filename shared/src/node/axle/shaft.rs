//! Position at power-up by an absolute sensor at the output shaft.
//!
//! The angle counts only if [`READINGS`] new ones in a row agree with what the encoder shows, while
//! the axle has no power and stands. Afterwards the encoder alone counts: a sensor that fails in
//! motion changes nothing but its condition. If sensor and encoder drift apart, by more than
//! [`APART`], the axle has a fault ([`Fault::ShaftMismatch`](crate::faults::Fault::ShaftMismatch)).

use super::Axle;
use crate::math::Turns;
use crate::motor::rotor::ElectricalAngle;
use crate::motor::shaft_sensor::{Condition, Kind, Reading};
use crate::settings::{Setting, Settings};
use crate::units::Angle;

/// Number of angles in a row that must agree.
const READINGS: u8 = 8;
/// Difference up to which they agree: half a degree, more than the noise of both chips.
const TOLERANCE: u32 = (0.5 / 360.0 * 4_294_967_296.0) as u32;
/// Speed up to which the shaft stands, rad/s.
const STANDING: f32 = 0.05;
/// Difference above which sensor and encoder have drifted apart: 5 degrees. Both chips are wrong by
/// about 1 degree. The rest is for the place of the magnet, and for what the gear gives.
const APART: f32 = 5.0 / 360.0 * core::f32::consts::TAU;
/// Largest age of an angle: the time between two readings, a transfer and the filter of the AS5600,
/// s.
const AGE: f32 = 0.013;

/// The sensor of one axle.
#[derive(Clone, Debug)]
pub(super) struct Shaft {
    zero: Angle,
    reversed: bool,
    /// Position near which the axle is at power-up.
    middle: Turns,
    /// Number of the newest angle.
    number: u8,
    /// What its position was ahead of the encoder's, and how many agree with that.
    ahead: Angle,
    agreed: u8,
    /// The sensor has given the position of the axle.
    followed: bool,
    /// Angles in a row that are too far from the encoder's position.
    apart: u8,
}

impl Shaft {
    /// Creates the sensor of these settings, if they have one.
    pub fn new(settings: &Settings, travel: Option<(Turns, Turns)>) -> Option<Self> {
        Kind::of(settings)?;
        let middle = travel.map_or(0, |(low, high)| {
            i64::midpoint(low.to_bits(), high.to_bits())
        });
        Some(Self {
            zero: ElectricalAngle::from_milli_degrees(settings.get(Setting::ShaftZero)).0,
            reversed: settings.get(Setting::ShaftDirection) < 0,
            middle: Turns::from_bits(middle),
            number: 0,
            ahead: Angle::ZERO,
            agreed: 0,
            followed: false,
            apart: 0,
        })
    }

    /// Returns the angle of the shaft if this is a new reading of a sensor that runs.
    fn angle(&mut self, reading: Reading) -> Option<Angle> {
        let before = core::mem::replace(&mut self.number, reading.number);
        if reading.condition != Condition::Running {
            (self.agreed, self.apart) = (0, 0);
            return None;
        }
        let angle = reading.angle - self.zero;
        let angle = if self.reversed {
            Angle::ZERO - angle
        } else {
            angle
        };
        (before != reading.number).then_some(angle)
    }

    /// Takes a new angle, while the encoder is at this position. Returns the position of the shaft,
    /// when it is certain.
    fn take(&mut self, angle: Angle, encoder: Turns, stands: bool) -> Option<Turns> {
        if !stands {
            self.agreed = 0;
            return None;
        }
        let ahead = angle - encoder.angle();
        if (ahead - self.ahead).to_bits().unsigned_abs() > TOLERANCE {
            (self.ahead, self.agreed) = (ahead, 0);
        }
        self.agreed += 1;
        if self.agreed < READINGS {
            return None;
        }
        self.agreed = 0;
        Some(self.middle + Turns::from(angle - self.middle.angle()))
    }

    /// Compares a new angle with the encoder's position at this speed, rad/s.
    fn compare(&mut self, angle: Angle, encoder: Turns, speed: f32) {
        let bound = Turns::from_radians(APART + AGE * speed).distance();
        let apart = (angle - encoder.angle()).to_bits().unsigned_abs();
        self.apart = if u64::from(apart) > bound {
            self.apart.saturating_add(1)
        } else {
            0
        };
    }

    /// Returns whether sensor and encoder have drifted apart.
    pub fn has_drifted(&self) -> bool {
        self.apart >= READINGS
    }

    /// Ends the comparison: something else than the sensor gives the position.
    pub fn disregard(&mut self) {
        (self.followed, self.apart) = (false, 0);
    }
}

impl Axle {
    /// Takes the newest reading of the shaft sensor, before a tick. An axle without power that is
    /// not homed gets its position by it. Afterwards it is compared with the encoder.
    pub fn locate(&mut self, reading: Reading) {
        let rests = !self.powered() && !self.commutation.aligns();
        let (encoder, speed) = (self.position(), self.velocity().abs());
        let Some(shaft) = &mut self.shaft else {
            return;
        };
        let Some(angle) = shaft.angle(reading) else {
            return;
        };
        if self.homed {
            if shaft.followed {
                shaft.compare(angle, encoder, speed);
            }
        } else if let Some(position) = shaft.take(angle, encoder, rests && speed < STANDING) {
            self.found_home(position);
            if let Some(shaft) = &mut self.shaft {
                shaft.followed = true;
            }
        }
    }
}

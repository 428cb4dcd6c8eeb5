//! Position at power-up by an absolute sensor at the output shaft.
//!
//! The angle counts only if [`READINGS`] new ones in a row agree with what the encoder shows, while
//! the axle has no power and stands. Afterwards the encoder alone counts: a sensor that fails or
//! jumps in motion changes nothing but its condition.

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
/// Speed up to which the shaft stands, rad/s. An angle is older than the position by up to 11 ms.
const STANDING: f32 = 0.05;

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
        })
    }

    /// Takes the newest reading, while the encoder is at this position. Returns the position of the
    /// shaft, when it is certain.
    fn take(&mut self, reading: Reading, encoder: Turns, stands: bool) -> Option<Turns> {
        if reading.condition != Condition::Running || !stands {
            self.agreed = 0;
            self.number = reading.number;
            return None;
        }
        if core::mem::replace(&mut self.number, reading.number) == reading.number {
            return None;
        }
        let angle = reading.angle - self.zero;
        let angle = if self.reversed {
            Angle::ZERO - angle
        } else {
            angle
        };
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
}

impl Axle {
    /// Takes the newest reading of the shaft sensor, before a tick. An axle without power that is
    /// not homed gets its position by it.
    pub fn locate(&mut self, reading: Reading) {
        let rests = !self.powered() && !self.commutation.aligns() && !self.homed;
        let (encoder, stands) = (self.position(), self.velocity().abs() < STANDING);
        let Some(shaft) = self.shaft.as_mut().filter(|_| rests) else {
            return;
        };
        if let Some(position) = shaft.take(reading, encoder, stands) {
            self.found_home(position);
        }
    }
}

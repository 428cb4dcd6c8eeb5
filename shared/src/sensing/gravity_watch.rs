//! Finds in single readings what no robot on its tracks or wheels shows: an accelerometer that
//! reads zero, free fall, and a sensor that is upside down.

use super::trust::{Reason, Trust};
use crate::constants::GRAVITY;
use crate::math::clamp;
use crate::sensors::Sensor;

/// Duration of such readings from which the sensor is not believed, s. A fall from 18 mm is
/// shorter.
const AFTER: f32 = 0.06;
/// Specific force below which the robot falls freely, m/s^2.
const FREE_FALL: f32 = 0.2 * GRAVITY;
/// Force along the body's z axis below which the body is upside down, m/s^2: that of 120 degrees.
const DOWNWARD: f32 = -0.5 * GRAVITY;
/// Pitch beyond which an inclinometer is upside down, rad: 120 degrees.
const OVERTURNED: f32 = 2.09;

/// Monitor of these readings. A timer counts up with each of them, and down as fast.
#[derive(Clone, Debug, Default)]
pub struct GravityWatch {
    zero: f32,
    free_fall: f32,
    force_down: f32,
    inclination_down: f32,
}

fn count(timer: &mut f32, there: bool, period: f32) {
    let change = if there { period } else { -period };
    *timer = clamp(*timer + change, 0.0, 2.0 * AFTER);
}

impl GravityWatch {
    /// Takes a specific force in body axes that counts for `period` s, without its constant error.
    /// `zero`: the accelerometer itself reads zero.
    #[inline]
    pub fn receive_force(&mut self, [x, y, z]: [f32; 3], zero: bool, period: f32) {
        let square = x * x + y * y + z * z;
        count(&mut self.zero, zero, period);
        let falls = !zero && square < FREE_FALL * FREE_FALL;
        count(&mut self.free_fall, falls, period);
        count(&mut self.force_down, z < DOWNWARD, period);
    }

    /// Takes a pitch of the inclinometer, rad, that counts for `period` s.
    #[inline]
    pub fn receive_pitch(&mut self, pitch: f32, period: f32) {
        count(&mut self.inclination_down, pitch.abs() > OVERTURNED, period);
    }

    /// How far a sensor is believed by these readings.
    pub fn trust(&self, sensor: Sensor) -> Trust {
        let found = match sensor {
            Sensor::Inclinometer => [(self.inclination_down, Reason::UpsideDown); 3],
            Sensor::Accelerometer => [
                (self.zero, Reason::Zero),
                (self.free_fall, Reason::FreeFall),
                (self.force_down, Reason::UpsideDown),
            ],
            _ => return Trust::Full,
        };
        let named = found.into_iter().find(|(time, _)| *time >= AFTER);
        named.map_or(Trust::Full, |(_, reason)| Trust::None(reason))
    }

    /// How far the sensors are believed by these readings.
    pub fn worst(&self) -> Trust {
        let inclinometer = self.trust(Sensor::Inclinometer);
        inclinometer.or(self.trust(Sensor::Accelerometer))
    }
}

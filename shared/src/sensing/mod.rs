//! Decides which readings of the body's sensors are believed, and turns them to the axes of the
//! body. The readings of a drive are watched in [`crate::node::axle`].
//!
//! [`Sensing`] owns all of it. [`mounting`]: axes and constant errors of the sensor board.
//! [`watch`]: whether the sensors on the body are believed, with [`sensor_watch`] (age and rate of
//! one sensor), `noise_watch` (its noise), `stuck` and `field_watch` (repeated readings),
//! `gravity_watch` (readings that no robot on its tracks shows) and [`trust`] (the result).
//! [`rest`]: constant errors that show while the robot rests.

mod field_watch;
mod gravity_watch;
pub mod mounting;
mod noise_watch;
pub mod rest;
pub mod sensor_watch;
mod stuck;
pub mod trust;
pub mod watch;

use crate::constants::CONTROL_PERIOD;
use crate::estimate::attitude::{Attitude, LevelAxes};
use crate::estimate::specific_force::SpecificForce;
use crate::math::vector::{Vector, sub};
use crate::sensors::{BodySensors, Sensor};
use crate::settings::{Setting, Settings};
use gravity_watch::GravityWatch;
use mounting::Mounting;
use rest::Rest;
use sensor_watch::{SensorState, SensorWatch};
use trust::Trust;
use watch::{Expectations, Watch};

/// The sensors of a robot, as far as they are believed.
#[derive(Clone, Debug)]
pub struct Sensing {
    watch: Watch,
    /// Monitor of the GNSS receiver.
    fixes: SensorWatch,
    mounting: Mounting,
    gravity: GravityWatch,
    rest: Rest,
    /// Newest readings in the axes of the sensor board, and those in body axes.
    raw: BodySensors,
    body: BodySensors,
    force: SpecificForce,
}

impl Sensing {
    /// The sensors that the settings describe, before the first reading.
    pub fn new(settings: &Settings) -> Self {
        Self {
            watch: Watch::new(&Expectations::new(settings)),
            fixes: SensorWatch::new(settings.get(Setting::FixRate) as f32),
            mounting: Mounting::with_settings(settings),
            gravity: GravityWatch::default(),
            rest: Rest::default(),
            raw: BodySensors::default(),
            body: BodySensors::default(),
            force: SpecificForce::default(),
        }
    }

    /// Takes the sensors of one control period, in the axes of the sensor board. Returns the newest
    /// readings in body axes, without the constant errors of the sensors; those of this period that
    /// can be used are fresh.
    pub fn receive(&mut self, sensors: Option<&BodySensors>) -> &BodySensors {
        let fresh = self.watch.receive(sensors, CONTROL_PERIOD);
        if let Some(sensors) = sensors {
            let kept = &mut self.raw;
            if fresh.inclinometer {
                kept.inclination = sensors.inclination;
            }
            if fresh.accelerometer {
                kept.specific_force = sensors.specific_force;
                let force = self.mounting.turn(sensors.specific_force);
                let force = sub(force, self.rest.force());
                let zero = sensors.specific_force.iter().all(|value| *value == 0.0);
                let period = self.watch.period(Sensor::Accelerometer);
                self.gravity.receive_force(force, zero, period);
                self.force.receive(force);
            }
            if fresh.gyroscope {
                kept.angular_rate = sensors.angular_rate;
            }
            if fresh.magnetometer {
                kept.magnetic_field = sensors.magnetic_field;
            }
        }
        self.raw.fresh = fresh;
        let body = &mut self.body;
        *body = self.mounting.apply(&self.raw);
        if fresh.inclinometer {
            let period = self.watch.period(Sensor::Inclinometer);
            self.gravity.receive_pitch(body.inclination[0], period);
        }
        self.rest.receive(body);
        body.angular_rate = sub(body.angular_rate, self.rest.rate());
        body.specific_force = sub(body.specific_force, self.rest.force());
        body
    }

    /// Notes for one control period whether the GNSS receiver sent a fix.
    pub fn receive_fix(&mut self, fixed: bool) {
        self.fixes.advance(fixed.then_some(Ok(())), CONTROL_PERIOD);
    }

    /// Returns the specific force in level axes, m/s^2, low-passed, `period` s after the previous
    /// call.
    pub fn level_force(&mut self, axes: &LevelAxes, period: f32) -> Vector<f32> {
        self.force.advance(axes, period)
    }

    /// Learns the constant errors of the sensors, `period` s after the previous call, while the
    /// robot does not roll (`stands`). Returns pitch and roll, rad, when the errors are learned for
    /// the first time.
    pub fn learn(&mut self, stands: bool, period: f32) -> Option<[f32; 2]> {
        let believed = self.gravity.worst().or(self.watch.own_trust()) == Trust::Full;
        self.rest.advance(stands && believed, period)
    }

    /// Notes for one SYNC period of `period` s whether the robot could be armed if it had rested
    /// (`waits`). Returns whether it waits on.
    pub fn await_rest(&mut self, waits: bool, period: f32) -> bool {
        self.rest.wait(waits, period)
    }

    /// Returns the constant errors of the sensors.
    pub fn rest(&self) -> &Rest {
        &self.rest
    }

    /// Compares the sensors with each other, as [`Watch::compare`], and returns the trust in them.
    pub fn compare(
        &mut self,
        force: Vector<f32>,
        attitude: &Attitude,
        slow: bool,
        period: f32,
    ) -> Trust {
        // Before the first rest, the force has the constant error of the accelerometer.
        let slow = slow && self.rest.known();
        self.watch.compare(force, attitude, slow, period);
        self.gravity.worst().or(self.watch.trust())
    }

    /// Returns the newest readings in the axes of the sensor board.
    pub fn raw(&self) -> &BodySensors {
        &self.raw
    }

    /// Returns the newest readings in body axes, without the constant errors.
    pub fn body(&self) -> &BodySensors {
        &self.body
    }

    /// Largest error of the attitude, rad: what it may have turned unseen
    /// ([`Watch::unseen_rotation`]), and what the rest of the gyroscope's constant error turns it.
    pub fn uncertain_tilt(&self, attitude: &Attitude) -> f32 {
        self.watch.unseen_rotation() + attitude.drift(self.rest.rate_uncertainty())
    }

    /// Returns age, rate and health of a sensor.
    pub fn state(&self, sensor: Sensor) -> SensorState {
        match self.watch.sensor(sensor) {
            Some(found) => {
                let trust = self.gravity.trust(sensor).or(self.watch.trust_in(sensor));
                SensorState::new(found, trust)
            }
            None => SensorState::new(&self.fixes, self.fixes.trust()),
        }
    }
}

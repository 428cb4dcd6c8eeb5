//! What a calibration is allowed to do, and what it must know beforehand.

use super::record::{Quantity, Refusal};
use super::tick::check_at_most;
use crate::constants::{CONTROL_HZ, CONTROL_PERIOD, OBSERVER_BANDWIDTH};
use crate::motor::bridge::Ratings;
use crate::motor::current::MotorKind;
use crate::motor::rotor::RotorSensor;
use crate::settings::{Setting, Settings};

/// Largest speed of the rotor at the start, rad/s.
const LARGEST_SPEED_AT_START: f32 = 10.0;
/// Velocity that the observer shows after two counts, which are the noise of the sensor; counts/s.
const NOISE: f32 = 2.0 * OBSERVER_BANDWIDTH * OBSERVER_BANDWIDTH * CONTROL_PERIOD;

/// Bounds and known values of a calibration.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Plan {
    /// Kind of the motor.
    pub kind: MotorKind,
    /// Power stage of the board.
    pub ratings: Ratings,
    /// Counts of the rotor sensor per turn of the rotor.
    pub counts_per_turn: i32,
    /// Rotor turns per turn of the output shaft.
    pub gear_ratio: f32,
    /// Largest current, A.
    pub current: f32,
    /// Largest speed of the rotor, rad/s.
    pub speed: f32,
    /// Largest distance from the position at the start while the torque constant is not measured,
    /// turns of the rotor.
    pub travel: f32,
    /// Torque constant in the settings, N m/A. The resistance of a brushed motor whose shaft is not
    /// free is measured with it.
    pub torque_constant: f32,
    /// The sensor has an index, at whose pulse the electrical offset counts.
    pub index: bool,
    /// The shaft is free to turn, as far as it likes: the torque constant is measured too.
    pub free_shaft: bool,
}

impl Plan {
    /// Reads the plan from the settings.
    pub fn from_settings(settings: &Settings, ratings: &Ratings, free_shaft: bool) -> Self {
        let gear_ratio = settings.si(Setting::GearRatio);
        let current = settings.si(Setting::CalibrationCurrent);
        let travel = settings.si(Setting::CalibrationTravel);
        Self {
            kind: if settings.get(Setting::MotorKind) == 0 {
                MotorKind::Brushed
            } else {
                MotorKind::ThreePhase
            },
            ratings: *ratings,
            counts_per_turn: settings.get(Setting::EncoderCounts),
            gear_ratio,
            current: crate::math::limit(current, settings.si(Setting::CurrentLimit)),
            speed: settings.si(Setting::CalibrationSpeed) * gear_ratio,
            travel: travel * gear_ratio / core::f32::consts::TAU,
            torque_constant: settings.si(Setting::TorqueConstant),
            index: RotorSensor::of(settings) == Some(RotorSensor::Indexed),
            free_shaft,
        }
    }

    /// Refuses a shaft that turns with this observed velocity, rad/s. The first excitation shorts
    /// the winding, and the back-EMF then drives a current.
    ///
    /// # Errors
    /// [`Refusal::OutOfBounds`] with the speed of the rotor, also if it is NaN.
    pub fn check_standstill(&self, velocity: f32) -> Result<(), Refusal> {
        let noise = NOISE / self.counts_per_turn as f32 * core::f32::consts::TAU;
        let bound = crate::math::max(LARGEST_SPEED_AT_START, noise);
        let speed = velocity.abs() * self.gear_ratio;
        check_at_most(Quantity::SpeedAtStart, speed, bound)
    }

    /// Converts counts to turns of the rotor.
    pub(super) fn turns(&self, counts: i64) -> f32 {
        counts as f32 / self.counts_per_turn as f32
    }

    /// PWM periods per control period.
    pub fn periods_per_control(&self) -> u32 {
        self.ratings.pwm_hz / CONTROL_HZ
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor::observer::Observer;

    fn plan(counts: i32) -> Plan {
        let mut settings = Settings::default();
        settings
            .set(Setting::EncoderCounts.bounds().key, counts)
            .unwrap();
        let ratings = Ratings {
            pwm_hz: 20_000,
            period: 4_250,
            highest: 4_250,
            sampled: 4_250,
            full_scale: 40.0,
            highest_supply: f32::INFINITY,
        };
        Plan::from_settings(&settings, &ratings, false)
    }

    /// Runs 500 ticks in which the rotor moves by these counts. Returns in how many after the first
    /// 20 a calibration may begin, and in how many it is refused.
    fn allowed_and_refused(counts: i32, moves: impl Fn(i32) -> i32) -> [usize; 2] {
        let plan = plan(counts);
        let gear = (plan.gear_ratio * 1e3) as i32;
        let mut observer = Observer::new(counts, gear, OBSERVER_BANDWIDTH, 0);
        let mut encoder = 0;
        let mut ticks = [0; 2];
        for tick in 0..500 {
            encoder += moves(tick);
            observer.update(encoder, CONTROL_PERIOD);
            if tick >= 20 {
                let refused = plan.check_standstill(observer.velocity()).is_err();
                ticks[usize::from(refused)] += 1;
            }
        }
        ticks
    }

    #[test]
    fn the_noise_of_a_sensor_is_no_motion_and_a_coasting_shaft_is() {
        for counts in [48, 64, 200, 1_000, 4_096, 65_536] {
            for period in [1, 2, 7, 50] {
                let flicker = |tick: i32| {
                    [1, -1][(tick / period % 2) as usize] * i32::from(tick % period == 0)
                };
                let [allowed, refused] = allowed_and_refused(counts, flicker);
                assert!(allowed > 0 && refused == 0, "{counts}, {period}: {refused}");
            }
        }
        // 100 rad/s of the rotor.
        for counts in [64, 1_000, 4_096, 65_536] {
            let position = |tick: i32| {
                (f64::from(tick) * 0.1 / core::f64::consts::TAU * f64::from(counts)) as i32
            };
            let [allowed, refused] =
                allowed_and_refused(counts, |tick| position(tick) - position(tick - 1));
            assert!(allowed == 0 && refused > 0, "{counts}: {allowed}");
        }
    }

    #[test]
    fn a_velocity_that_is_no_number_is_refused() {
        assert!(plan(4_096).check_standstill(f32::NAN).is_err());
    }
}

//! The steps of the commissioning, and what each finds.

use super::interface::{Reason, Report, Values, progress, request};
use super::rest::{Means, Rest};
use super::turn::Turn;
use super::{Failure, length};
use crate::estimate::ellipse::Ellipse;
use crate::math::{atan2, max, sin_cos, sqrt, to_i32};
use crate::sensing::mounting::Mounting;
use crate::sensors::BodySensors;
use crate::units::Angle;

/// Duration of a rest, s.
const REST: f32 = 4.0;
/// Maximum duration of a turn, s.
const LONGEST_TURN: f32 = 180.0;
/// Angle of a turn, rad: a little more than once around.
const WHOLE_TURN: f32 = 6.6;
/// Largest mean of a gyroscope at rest, rad/s.
const RATE_LIMIT: f32 = 0.35;
/// Smallest angle by which a side must be raised, rad: 8 degrees.
const RAISED: f32 = 0.14;
/// Allowed difference of an angle that two sensors measure: rad, and as a fraction of the angle.
const DIFFERENCE: f32 = 0.03;
const RELATIVE_DIFFERENCE: f32 = 0.2;
/// Smallest number of readings of the magnetometer in a turn.
const FEWEST_FIELDS: u32 = 24;
/// Horizontal strength of the earth's field, uT, with a tolerance.
const HORIZONTAL: [f32; 2] = [5.0, 60.0];
/// Largest factor of the correction for soft iron.
const SOFTEST: f32 = 2.0;

#[derive(Clone, Copy, Debug, Default)]
#[allow(clippy::large_enum_variant)] // there is one, and no allocator
enum Step {
    #[default]
    None,
    Rest(u8, Rest),
    Turn(Turn),
}

/// Commissioning of the sensors of one guard.
#[derive(Clone, Copy, Debug, Default)]
pub struct Commissioning {
    step: Step,
    /// Angles of the mounting about x, y and z, rad.
    angles: Option<[f32; 3]>,
    /// Angular rate and inclination of the level rest, in the axes of the board, rad/s and rad.
    rate: [f32; 3],
    inclination: [f32; 2],
    /// Rotation since the end of the level rest, in the axes of the board, rad.
    turned: [f32; 3],
    /// Field of the level rest, and field and pitch with the nose up.
    level_field: Option<[f32; 3]>,
    raised_field: Option<([f32; 3], f32)>,
    report: Report,
}

impl Commissioning {
    /// Starts the step of this request, or ends the one under way. Resting steps need a disarmed
    /// robot.
    pub fn request(&mut self, request: u8, disarmed: bool) {
        self.step = Step::None;
        self.report.progress = request;
        (self.report.reason, self.report.refused) = (0, 0);
        let resting = matches!(request, request::LEVEL..=request::LEFT_UP);
        let failure = match request {
            _ if resting && !disarmed => Some(Reason::NotDisarmed),
            request::NOSE_UP | request::LEFT_UP | request::TURN if self.angles.is_none() => {
                Some(Reason::Order)
            }
            request::NONE..=request::TURN => None,
            _ => Some(Reason::Unknown),
        };
        if let Some(reason) = failure {
            self.end(Err((reason, 0.0)));
            return;
        }
        self.step = match request {
            request::NONE => Step::None,
            request::TURN => Step::Turn(Turn::default()),
            _ => Step::Rest(request, Rest::default()),
        };
    }

    /// Returns progress and results.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Takes the readings of one control period, in the axes of the sensor board and with their
    /// constant errors.
    pub fn sense(&mut self, sensors: &BodySensors, period: f32) {
        let Some(angles) = self.angles else {
            return self.advance(sensors, period);
        };
        let rate: [f32; 3] =
            core::array::from_fn(|axis| sensors.angular_rate[axis] - self.rate[axis]);
        for (turned, rate) in self.turned.iter_mut().zip(rate) {
            *turned += rate * period;
        }
        if let Step::Turn(turn) = &mut self.step {
            let mounting = mounting(angles);
            turn.angle += mounting.turn(rate)[2] * period;
            if sensors.fresh.magnetometer {
                turn.add(mounting.turn(sensors.magnetic_field));
            }
        }
        self.advance(sensors, period);
    }

    fn advance(&mut self, sensors: &BodySensors, period: f32) {
        let ended = match &mut self.step {
            Step::None => return,
            Step::Rest(request, rest) => {
                rest.add(sensors, period);
                let (request, rest) = (*request, *rest);
                (rest.time >= REST).then(|| self.rested(request, &rest))
            }
            Step::Turn(turn) => {
                turn.time += period;
                let turn = *turn;
                if turn.angle.abs() >= WHOLE_TURN {
                    Some(self.turned_once(&turn))
                } else {
                    (turn.time > LONGEST_TURN).then_some(Err((Reason::Timeout, turn.angle)))
                }
            }
        };
        if let Some(result) = ended {
            self.end(result);
        }
    }

    fn end(&mut self, result: Result<(), Failure>) {
        self.step = Step::None;
        self.report.progress = match result {
            Ok(()) => progress::DONE,
            Err((reason, value)) => {
                (self.report.reason, self.report.refused) = (reason as u8, to_i32(value * 1e3));
                progress::REFUSED
            }
        };
    }

    fn rested(&mut self, request: u8, rest: &Rest) -> Result<(), Failure> {
        match request {
            request::LEVEL => self.level(rest),
            request::NOSE_UP => self.nose_up(rest),
            _ => self.left_up(rest),
        }
    }

    fn level(&mut self, rest: &Rest) -> Result<(), Failure> {
        let Means {
            force,
            rate,
            inclination,
        } = rest.means()?;
        if !(length(rate) <= RATE_LIMIT) {
            return Err((Reason::RateAtRest, length(rate)));
        }
        let [x, y, z] = force;
        // The rotation about x makes y zero, the one about y makes x zero.
        let about_x = atan2(y, z);
        let about_y = atan2(-x, sqrt(y * y + z * z));
        self.angles = Some([about_x, about_y, 0.0]);
        (self.rate, self.inclination, self.turned) = (rate, inclination, [0.0; 3]);
        (self.level_field, self.raised_field) = (rest.field.get(), None);
        self.report.axes = 0;
        self.report.values = Values::default();
        self.publish();
        Ok(())
    }

    fn nose_up(&mut self, rest: &Rest) -> Result<(), Failure> {
        let Means {
            force, inclination, ..
        } = rest.means()?;
        let [about_x, about_y, _] = self.angles.unwrap_or_default();
        let [x, y, up] = mounting([about_x, about_y, 0.0]).turn(force);
        let pitch = atan2(sqrt(x * x + y * y), up);
        if !(pitch >= RAISED) {
            return Err((Reason::NotRaised, pitch));
        }
        // The direction in which the force leans is forward.
        let angles = [about_x, about_y, -atan2(y, x)];
        let mounting = mounting(angles);
        let turned = mounting.turn(self.turned);
        agree(turned[1], -pitch)?;
        agree(turned[0], 0.0)?;
        let zero = mounting.inclination(self.inclination);
        let shown = mounting.inclination(inclination);
        agree(shown[0] - zero[0], pitch).map_err(|(_, error)| (Reason::Inclinometer, error))?;
        agree(shown[1] - zero[1], 0.0).map_err(|(_, error)| (Reason::Inclinometer, error))?;
        self.angles = Some(angles);
        self.publish();
        self.raised_field = rest.field.get().map(|field| (field, pitch));
        self.report.axes |= 2;
        Ok(())
    }

    fn left_up(&mut self, rest: &Rest) -> Result<(), Failure> {
        let Means { force, .. } = rest.means()?;
        let mounting = mounting(self.angles.unwrap_or_default());
        let [_, left, up] = mounting.turn(force);
        let roll = atan2(left, up);
        if !(roll >= RAISED) {
            return Err((Reason::NotRaised, roll));
        }
        agree(mounting.turn(self.turned)[0], roll)?;
        self.report.axes |= 1;
        Ok(())
    }

    fn turned_once(&mut self, turn: &Turn) -> Result<(), Failure> {
        if turn.fit.count() < FEWEST_FIELDS {
            return Err((Reason::TooFewFields, turn.fit.count() as f32 * 1e-3));
        }
        let ellipse = turn.fit.solve().ok_or((Reason::NoEllipse, 0.0))?;
        let Ellipse {
            centre,
            radius,
            correction: [xx, yy, xy],
        } = ellipse;
        let soft = max(xx, yy);
        if !((HORIZONTAL[0]..=HORIZONTAL[1]).contains(&radius) && soft <= SOFTEST) {
            return Err((Reason::NoEllipse, radius));
        }
        // Seen from a robot that turns counter-clockwise, the earth's field turns clockwise.
        if !(turn.by_field * turn.angle < 0.0) {
            return Err((Reason::MagnetometerSign, turn.by_field));
        }
        let values = &mut self.report.values;
        values.soft_iron = [xx, yy, xy].map(|factor| rounded(factor * 1e4));
        let microtesla = |field: f32| rounded(field * 1e3);
        values.hard_iron = [microtesla(centre[0]), microtesla(centre[1]), 0];
        if let (Some(level), Some((raised, pitch)), Some(angles)) =
            (self.level_field, self.raised_field, self.angles)
        {
            let mounting = mounting(angles);
            let (level, raised) = (mounting.turn(level), mounting.turn(raised));
            let forward =
                |field: [f32; 3]| xx * (field[0] - centre[0]) + xy * (field[1] - centre[1]);
            // The horizontal field ahead is the same level and with the nose up.
            let (sine, cosine) = sin_cos(Angle::from_radians(pitch));
            let up = raised[2] - (cosine * forward(raised) - forward(level)) / sine;
            values.hard_iron[2] = microtesla(up);
        }
        self.report.axes |= 4;
        Ok(())
    }

    /// Writes mounting, rate at rest and zero of the inclinometer into the report.
    fn publish(&mut self) {
        let angles = self.angles.unwrap_or_default();
        let mounting = mounting(angles);
        let millidegrees = |radians: f32| rounded(radians.to_degrees() * 1e3);
        let values = &mut self.report.values;
        values.mounting = angles.map(millidegrees);
        values.rate_at_rest = mounting.turn(self.rate).map(millidegrees);
        values.level = mounting.inclination(self.inclination).map(millidegrees);
    }
}

/// Mounting with these angles about x, y and z, rad, and no other error.
fn mounting(angles: [f32; 3]) -> Mounting {
    Mounting::new(angles.map(Angle::from_radians), [0.0; 3], [0.0; 2])
}

/// Checks that an angle by the gyroscope is the one by the accelerometer.
fn agree(found: f32, expected: f32) -> Result<(), Failure> {
    let error = (found - expected).abs();
    if error <= DIFFERENCE + RELATIVE_DIFFERENCE * expected.abs() {
        Ok(())
    } else {
        Err((Reason::GyroscopeSign, error))
    }
}

fn rounded(value: f32) -> i32 {
    to_i32(value + if value < 0.0 { -0.5 } else { 0.5 })
}

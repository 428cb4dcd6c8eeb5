//! Supervises the robot's balance, and decides how much of a command reaches the body.
//!
//! In every control period, [`Supervision::receive`] takes the sensors. Once per SYNC, three steps
//! follow: [`Supervision::evaluate`] evaluates the stance, `admission` decides by the trip's latch
//! what may be commanded at all, and in `passing` the filter decides how much of that passes.
//! [`Telemetry`] publishes the result.

mod admission;
mod passing;
mod telemetry;
#[cfg(test)]
mod tests;

pub(super) use admission::Moment;
pub use telemetry::Telemetry;

use crate::constants::CONTROL_PERIOD;
use crate::estimate::mounting::Mounting;
use crate::math::max;
use crate::math::vector::Vector;
use crate::robots::{Body, Stop};
use crate::sensors::BodySensors;
use crate::settings::{Setting, Settings};
use crate::stability::attitude::Attitude;
use crate::stability::bands::{Band, Bands};
use crate::stability::criterion::{Criterion, Evaluation};
use crate::stability::filter::{Margins, Tracker};
use crate::stability::limits::MotionLimits;
use crate::stability::parameters::{Parameters, Refusal};
use crate::stability::specific_force::SpecificForce;
use crate::stability::support::{Stance, narrowest};
use crate::stability::trip::{Mode, Trip};
use crate::stability::trust::{Reason, Trust};
use crate::stability::watch::{Expectations, Watch};

/// Returns the narrowest of the `margins`, and the refusal that names it.
fn least(margins: [f32; 4]) -> (f32, Refusal) {
    let edge = narrowest(&margins);
    let margin = margins[edge as usize];
    (margin, Refusal::Margin { edge, margin })
}

/// Largest pitch and roll on level ground, rad.
const LEVEL: f32 = 0.1;
/// Axes whose signs must be checked before the robot is armed, as in `Setting::SensorAxes`.
const ALL_AXES: u8 = 7;

#[derive(Clone, Debug)]
pub(super) struct Supervision {
    parameters: Parameters,
    filter_active: bool,
    settings_doubted: bool,
    watch: Watch,
    trust: Trust,
    force: SpecificForce,
    level_force: Vector<f32>,
    criterion: Criterion,
    bands: Bands,
    trip: Trip,
    tracker: Tracker,
    mounting: Mounting,
    /// Newest readings in the axes of the sensor board, and those in body axes.
    raw: BodySensors,
    sensors: BodySensors,
    axes: u8,
    found: Evaluation,
    stance: Stance,
    margins: Margins,
    limits: MotionLimits,
    mode: Mode,
    /// How the robot must stop, if it must not move at all.
    stop: Option<Stop>,
}

impl Supervision {
    /// Creates the supervision of a robot with body `B`.
    pub fn new<B: Body>(settings: &Settings) -> Self {
        let mut parameters = Parameters::new(settings);
        parameters.uncertainty.robot_mass = B::mass(settings);
        parameters.step_behind = B::step_behind(settings);
        parameters.half_width = B::half_width(settings);
        Self {
            parameters,
            filter_active: settings.get(Setting::FilterActive) == 1,
            settings_doubted: false,
            watch: Watch::new(&Expectations::new(settings)),
            trust: Trust::None(Reason::Silent),
            force: SpecificForce::default(),
            level_force: [0.0; 3],
            criterion: Criterion::default(),
            bands: Bands::default(),
            trip: Trip::default(),
            tracker: Tracker::default(),
            mounting: Mounting::with_settings(settings),
            raw: BodySensors::default(),
            sensors: BodySensors::default(),
            axes: settings.get(Setting::SensorAxes) as u8,
            found: Evaluation::default(),
            stance: Stance::default(),
            margins: Margins::default(),
            limits: MotionLimits::default(),
            mode: Mode::default(),
            stop: None,
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
                self.force
                    .receive(self.mounting.turn(sensors.specific_force));
            }
            if fresh.gyroscope {
                kept.angular_rate = sensors.angular_rate;
            }
            if fresh.magnetometer {
                kept.magnetic_field = sensors.magnetic_field;
            }
        }
        self.raw.fresh = fresh;
        self.sensors = self.mounting.apply(&self.raw);
        &self.sensors
    }

    /// Returns the newest readings in the axes of the sensor board.
    pub fn raw(&self) -> &BodySensors {
        &self.raw
    }

    /// Evaluates how the robot stands, `period` s after the previous call. `kept_shape` is how it
    /// would stand now with its shape at the previous call, if that is known. If the sensors are
    /// not believed, the margins are NaN.
    pub fn evaluate(
        &mut self,
        stance: &Stance,
        kept_shape: Option<&Stance>,
        attitude: &Attitude,
        speed: f32,
        period: f32,
    ) {
        let rotation = self.watch.unseen_rotation();
        self.parameters.uncertainty.attitude = if rotation > 0.0 {
            rotation * stance.height()
        } else {
            0.0
        };
        self.level_force = self.force.advance(&attitude.level_axes(), period);
        self.found = self
            .criterion
            .evaluate(stance, self.level_force, speed, &self.parameters);
        self.watch
            .compare(self.level_force, attitude, !self.found.quick, period);
        self.trust = self.watch.trust();
        if matches!(self.trust, Trust::None(_)) {
            self.found.margins = [f32::NAN; 4];
        }
        if matches!(self.trust, Trust::None(_)) || !attitude.settled() {
            // The steps to an attitude that is believed are no rates of a margin.
            self.tracker = Tracker::default();
        }
        self.stance = *stance;
        let widening = self.parameters.uncertainty.widening();
        let kept = kept_shape.map_or(self.found.gravity, |stance| {
            stance.margins().map(|margin| margin - widening)
        });
        self.margins = self
            .tracker
            .update(stance, &self.found, &kept, speed, period);
        self.limits = MotionLimits::of(&self.found, &self.parameters);
        self.bands
            .update(&self.found.margins, period, &self.parameters);
    }

    /// Checks whether a robot with this stance on level ground may be armed.
    pub fn check(&self, level: &Stance) -> Result<(), Refusal> {
        if self.axes != ALL_AXES {
            return Err(Refusal::SensorAxes { checked: self.axes });
        }
        self.parameters.check(level)
    }

    /// Refuses to arm the robot from now on, because the guard's own settings are not whole.
    pub fn doubt_settings(&mut self) {
        self.settings_doubted = true;
    }

    /// Returns why the start must not begin or go on. `homes`: drives are homed, which changes the
    /// robot's shape and takes it through the stances `homing`. `confirmed`: the operator confirms
    /// that this happens off level ground.
    pub fn start_refusal(
        &self,
        attitude: &Attitude,
        homes: bool,
        confirmed: bool,
        homing: impl Iterator<Item = Stance>,
    ) -> Option<Refusal> {
        if self.settings_doubted {
            return Some(Refusal::Settings);
        }
        if let Trust::None(reason) = self.trust {
            return Some(Refusal::Sensors { reason });
        }
        if !(homes && self.filter_active) {
            return None;
        }
        if self.bands.band() == Band::Stop {
            return Some(least(self.margins.now).1);
        }
        let tilt = max(
            attitude.pitch().radians().abs(),
            attitude.roll().radians().abs(),
        );
        if tilt > LEVEL && !confirmed {
            return Some(Refusal::OffLevel { tilt });
        }
        let widening = self.parameters.uncertainty.widening();
        homing
            .map(|stance| least(stance.margins().map(|margin| margin - widening)))
            .find(|(margin, _)| !(*margin >= self.parameters.trip))
            .map(|(_, refusal)| refusal)
    }

    /// Returns the monitor of the sensors.
    pub fn watch(&self) -> &Watch {
        &self.watch
    }

    pub fn horizon(&self) -> f32 {
        self.parameters.horizon
    }

    pub fn margins(&self) -> &Margins {
        &self.margins
    }

    /// Returns whether a trip or an emergency stop is latched.
    pub fn tripped(&self) -> bool {
        self.trip.latched()
    }
}

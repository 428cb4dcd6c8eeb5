//! The balance of a robot: its margins, and how much of a command they let pass.
//!
//! Once per SYNC, three steps follow each other: [`Balance::evaluate`] evaluates the stance,
//! `admission` decides by the trip's latch what may be commanded at all, and in `passing` the
//! filter decides how much of that passes. [`Telemetry`] publishes the result.

mod admission;
mod passing;
mod telemetry;
#[cfg(test)]
mod tests;

pub use admission::Inputs;
pub use passing::Motion;
pub use telemetry::Telemetry;

use crate::estimate::attitude::Attitude;
use crate::math::max;
use crate::sensing::Sensing;
use crate::sensing::rest::RATE_BOUND;
use crate::sensing::trust::{Reason, Trust};
use crate::settings::{Setting, Settings};
use crate::stability::allowed::Stop;
use crate::stability::bands::{Band, Bands};
use crate::stability::criterion::Criterion;
use crate::stability::energy::Rotation;
use crate::stability::evaluation::Evaluation;
use crate::stability::filter::{Margins, Recovery, Tracker};
use crate::stability::limits::MotionLimits;
use crate::stability::parameters::{Parameters, Refusal};
use crate::stability::support::{Stance, narrowest};
use crate::stability::trip::{Mode, Trip};

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

/// Balance of one robot.
#[derive(Clone, Debug)]
pub struct Balance {
    parameters: Parameters,
    filter_active: bool,
    settings_doubted: bool,
    trust: Trust,
    /// Constant error of the gyroscope, rad/s.
    rate_at_rest: f32,
    criterion: Criterion,
    bands: Bands,
    trip: Trip,
    tracker: Tracker,
    axes: u8,
    found: Evaluation,
    stance: Stance,
    margins: Margins,
    rotation: Rotation,
    recovery: Recovery,
    /// Time between the last two evaluations, s.
    period: f32,
    /// Forward speed that is passed on, m/s.
    speed: f32,
    limits: MotionLimits,
    mode: Mode,
    /// How the robot must stop, if it must not move at all.
    stop: Option<Stop>,
}

impl Balance {
    /// Creates the balance of a robot with these parameters, before the first evaluation.
    pub fn new(settings: &Settings, parameters: Parameters) -> Self {
        Self {
            parameters,
            filter_active: settings.get(Setting::FilterActive) == 1,
            settings_doubted: false,
            trust: Trust::None(Reason::Silent),
            rate_at_rest: 0.0,
            criterion: Criterion::default(),
            bands: Bands::default(),
            trip: Trip::default(),
            tracker: Tracker::default(),
            axes: settings.get(Setting::SensorAxes) as u8,
            found: Evaluation::default(),
            stance: Stance::default(),
            margins: Margins::default(),
            rotation: Rotation::default(),
            recovery: Recovery::default(),
            period: 0.0,
            speed: 0.0,
            limits: MotionLimits::default(),
            mode: Mode::default(),
            stop: None,
        }
    }

    /// Evaluates how the robot stands, `period` s after the previous call. `kept_shape` is how it
    /// would stand now with its shape at the previous call, if that is known. If the sensors are
    /// not believed, the margins are NaN.
    pub fn evaluate(
        &mut self,
        sensing: &mut Sensing,
        stance: &Stance,
        kept_shape: Option<&Stance>,
        attitude: &Attitude,
        speed: f32,
        period: f32,
    ) {
        let tilt = sensing.uncertain_tilt(attitude);
        self.parameters.uncertainty.attitude = tilt * stance.height();
        self.rate_at_rest = sensing.rest().largest_rate();
        let force = sensing.level_force(&attitude.level_axes(), period);
        self.found = self
            .criterion
            .evaluate(stance, force, speed, &self.parameters);
        self.trust = sensing.compare(force, attitude, !self.found.stop_would_tip, period);
        if matches!(self.trust, Trust::None(_)) {
            self.found.margins = [f32::NAN; 4];
        }
        if matches!(self.trust, Trust::None(_)) || !attitude.settled() {
            // The steps to an attitude that is believed are no rates of a margin.
            self.forget_rates();
        }
        (self.stance, self.speed, self.period) = (*stance, speed, period);
        let rate = attitude.level(sensing.body().angular_rate);
        self.rotation.update(stance, rate, period);
        let deduction = self.parameters.uncertainty.deduction();
        let kept = kept_shape.map_or(self.found.gravity, |stance| {
            stance.margins().map(|margin| margin - deduction)
        });
        self.margins = self
            .tracker
            .update(stance, &self.found, &kept, speed, period);
        self.limits = MotionLimits::of(&self.found, &self.parameters);
        self.bands
            .update(&self.found.margins, period, &self.parameters);
    }

    /// Forgets the rates of the margins, because the attitude has made a step that is no motion.
    pub fn forget_rates(&mut self) {
        self.tracker = Tracker::default();
    }

    /// Checks whether a robot with this stance on level ground may be armed.
    ///
    /// # Errors
    /// The reason why not.
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
        let (rate, bound) = (self.rate_at_rest, RATE_BOUND);
        if !(rate <= bound) {
            return Some(Refusal::RateAtRest { rate, bound });
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
        let deduction = self.parameters.uncertainty.deduction();
        homing
            .map(|stance| least(stance.margins().map(|margin| margin - deduction)))
            .find(|(margin, _)| !(*margin >= self.parameters.trip))
            .map(|(_, refusal)| refusal)
    }

    /// Time ahead at which the stance of a posture motion is predicted, s.
    pub fn horizon(&self) -> f32 {
        self.parameters.horizon
    }

    /// Returns the margins with their rates.
    pub fn margins(&self) -> &Margins {
        &self.margins
    }

    /// Returns whether a trip or an emergency stop is latched.
    pub fn tripped(&self) -> bool {
        self.trip.latched()
    }
}

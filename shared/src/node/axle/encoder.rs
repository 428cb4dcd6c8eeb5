//! Position and velocity of the shaft by its encoder, and whether the encoder is disturbed.

use crate::constants::{CONTROL_PERIOD, OBSERVER_BANDWIDTH};
use crate::math::Turns;
use crate::motor::encoder_steps::EncoderSteps;
use crate::motor::halls::SECTOR;
use crate::motor::observer::Observer;
use crate::motor::rotor::RotorSensor;
use crate::settings::{Setting, Settings};

/// Travel in a control period that no shaft makes, as time at the velocity limit, s.
const IMPOSSIBLE_SPEED: f32 = 2.0 * CONTROL_PERIOD;

/// Returns the largest step in a control period that the shaft can make, counts.
#[inline(never)] // an inlined copy is longer than a call
fn largest_step(settings: &Settings) -> f32 {
    let velocity_limit = settings.si(Setting::VelocityLimit);
    let gear = settings.si(Setting::GearRatio);
    let counts = settings.get(Setting::EncoderCounts) as f32;
    let counts_per_radian = counts * gear / core::f32::consts::TAU;
    let halls = RotorSensor::of(settings).is_some_and(RotorSensor::has_halls);
    IMPOSSIBLE_SPEED * velocity_limit * counts_per_radian + if halls { SECTOR as f32 } else { 0.0 }
}

/// The encoder of one axle.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    observer: Observer,
    steps: EncoderSteps,
    /// A first reading has come.
    started: bool,
}

impl Encoder {
    /// Encoder of these settings, before its first reading.
    pub fn new(settings: &Settings) -> Self {
        let mut observer = Observer::new(
            settings.get(Setting::EncoderCounts),
            settings.get(Setting::GearRatio),
            OBSERVER_BANDWIDTH,
            0,
        );
        if settings.get(Setting::CountTiming) != 0 {
            observer = observer.timing_counts();
        }
        Self {
            observer,
            steps: EncoderSteps::new(largest_step(settings)),
            started: false,
        }
    }

    /// Takes over the velocity limit of these settings.
    pub fn retune(&mut self, settings: &Settings) {
        self.steps.set_largest(largest_step(settings));
    }

    /// Takes the reading of one control period, counts.
    pub fn update(&mut self, counts: i32) {
        if !self.started {
            self.observer.start(counts);
            self.steps.start(counts);
            self.started = true;
        }
        self.observer.update(counts, CONTROL_PERIOD);
        self.steps.update(counts);
    }

    /// Position of the output shaft.
    pub fn position(&self) -> Turns {
        self.observer.position()
    }

    /// Velocity of the output shaft, rad/s.
    pub fn velocity(&self) -> f32 {
        self.observer.velocity()
    }

    /// Calls the present position `position`.
    pub fn set_position(&mut self, position: Turns) {
        self.observer.set_position(position);
    }

    /// Whether a step of the last ten control periods was impossible.
    pub fn is_doubtful(&self) -> bool {
        self.steps.is_doubtful()
    }

    /// Whether impossible steps are frequent.
    pub fn is_noisy(&self) -> bool {
        self.steps.is_noisy()
    }
}

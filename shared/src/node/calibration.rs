//! Calibration in a drive's node: starts it on request, ends it when the drive may no longer be
//! calibrated, reports its progress, and puts the values into use.

use crate::math::to_i32;
use crate::motor::board_limits;
use crate::motor::bridge::Ratings;
use crate::motor::calibration::{self, Calibration, Plan, Progress, Record, Refusal, SETTINGS};
use crate::motor::current::{Config, CurrentLoop, Excitation};
use crate::settings::{Setting, Settings};

pub use crate::motor::calibration::Inputs;

/// Requests of object 0x2050.
pub mod request {
    /// No calibration; ends one that is under way.
    pub const NONE: u8 = 0;
    /// Calibrate everything but the torque constant. The shaft moves little.
    pub const STANDING: u8 = 1;
    /// Calibrate everything. The shaft is free to turn as far as it likes.
    pub const FREE_SHAFT: u8 = 2;
}

/// Values of object 0x2051 besides the numbers of the steps
/// ([`Step`](crate::motor::calibration::Step)).
pub mod progress {
    /// No calibration was requested since power-up.
    pub const NONE: u8 = 0;
    /// The last calibration is done, and its values are in use.
    pub const DONE: u8 = 100;
    /// The last calibration was refused. The values before it stay in use.
    pub const REFUSED: u8 = 101;
}

/// Progress and results, as the objects 0x2051 to 0x205F show them.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Report {
    /// Step under way, or how the last calibration ended (object 0x2051).
    pub progress: u8,
    /// Why it was refused; 0 if it was not (object 0x2052).
    pub reason: u8,
    /// Refused value, and the bound that it violates, in 1e-6 of its SI unit; saturated (objects
    /// 0x2053 and 0x2054).
    pub refused: [i32; 2],
    /// Values of the settings in the order of [`Record::settings`], 0 if a value was not measured
    /// (objects 0x2055 to 0x205E).
    pub values: [i32; SETTINGS],
    /// Residual of the resistance, 1e-6 (object 0x205F).
    pub residual: i32,
}

/// What the node does after a tick.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // a node has one of them, on its stack
pub enum Action {
    /// No calibration is under way: the axle commands the bridge.
    None,
    /// The excitation replaces the axle's command to the bridge.
    Excite(Excitation),
    /// The calibration is done: this loop replaces the present one, and the axle takes over the
    /// torque constant of [`Calibrator::settings`].
    Install(CurrentLoop),
}

/// Calibration of one node.
#[derive(Clone, Debug)]
pub struct Calibrator {
    settings: Settings,
    ratings: Ratings,
    periods_per_control: u32,
    running: Option<Calibration>,
    report: Report,
}

/// Numbers of object 0x2052 beyond those of the quantities.
const TIMEOUT: u8 = 100;
const NO_SETTING: u8 = 120;
const NO_LOOP: u8 = 121;
const ENDED: u8 = 122;

impl Calibrator {
    /// Creates the calibrator of a node with these settings.
    pub fn new(settings: &Settings, ratings: &Ratings) -> Self {
        Self {
            settings: settings.clone(),
            ratings: *ratings,
            periods_per_control: 0,
            running: None,
            report: Report::default(),
        }
    }

    /// Returns the settings in use: with the values that calibrations have found since power-up,
    /// and with what clients have changed that takes effect at once.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Changes a setting that takes effect at once.
    pub fn set(&mut self, setting: Setting, value: i32) {
        // Cannot fail: the value is one of the node's settings.
        let _ = self.settings.set(setting.bounds().key, value);
    }

    /// Returns progress and results.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// Returns whether a calibration is under way.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Runs one control period. `request` is one of [`request`]. `allowed`: the drive is in bench
    /// mode, disarmed and without a fault. `velocity` of the output shaft: observed, rad/s.
    pub fn tick(&mut self, request: u8, allowed: bool, velocity: f32, inputs: &Inputs) -> Action {
        let wanted = matches!(request, request::STANDING | request::FREE_SHAFT);
        if self.running.is_none() {
            if !wanted {
                return Action::None;
            }
            let free_shaft = request == request::FREE_SHAFT;
            let plan = Plan::from_settings(&self.settings, &self.ratings, free_shaft);
            let start = if allowed {
                plan.check_standstill(velocity)
            } else {
                Err(Refusal::Ended)
            };
            if let Err(refusal) = start {
                // The loop stays: it may drive a motor, and knows more than the settings.
                self.report = Report {
                    progress: progress::REFUSED,
                    ..Report::default()
                };
                self.refuse(refusal);
                return Action::None;
            }
            self.periods_per_control = plan.periods_per_control();
            self.running = Some(Calibration::new(&plan));
            self.report = Report::default();
        }
        let Some(running) = &mut self.running else {
            return Action::None;
        };
        let progress = if wanted && allowed {
            running.tick(inputs)
        } else {
            Progress::Refused(Refusal::Ended)
        };
        let result = match progress {
            Progress::Excite(excitation) => {
                self.report.progress = running.step().map_or(0, |step| step as u8);
                return Action::Excite(excitation);
            }
            Progress::Done(record) => self.adopt(&record),
            Progress::Refused(refusal) => Err(refusal),
        };
        self.running = None;
        match result {
            Ok(current_loop) => {
                self.report.progress = progress::DONE;
                Action::Install(current_loop)
            }
            Err(refusal) => {
                self.report.progress = progress::REFUSED;
                self.refuse(refusal);
                // The loop of the settings: the calibration has changed the sensing.
                match self.make_loop(&self.settings) {
                    Ok(current_loop) => Action::Install(current_loop),
                    Err(_) => Action::None,
                }
            }
        }
    }

    /// Takes over the values, unless the motor could not be controlled with them.
    fn adopt(&mut self, record: &Record) -> Result<CurrentLoop, Refusal> {
        let mut settings = self.settings.clone();
        record.store(&mut settings)?;
        let current_loop = self.make_loop(&settings)?;
        self.settings = settings;
        self.report.values = record
            .settings()
            .map(|found| found.map_or(0, |found| found.1));
        self.report.residual = micro(record.residuals.resistance);
        Ok(current_loop)
    }

    fn make_loop(&self, settings: &Settings) -> Result<CurrentLoop, Refusal> {
        let config = Config::from_settings(settings, self.periods_per_control);
        board_limits::check_velocity(settings, self.ratings.highest_supply)
            .map_err(|_| Refusal::NoLoop)?;
        let mut current_loop =
            CurrentLoop::new(&config, &self.ratings).map_err(|_| Refusal::NoLoop)?;
        current_loop.set_sensing(calibration::sensing(settings));
        Ok(current_loop)
    }

    fn refuse(&mut self, refusal: Refusal) {
        let (reason, refused) = match refusal {
            Refusal::OutOfBounds {
                quantity,
                got,
                bound,
            } => (quantity as u8, [got, bound]),
            Refusal::Timeout { step, bound } => (TIMEOUT + step as u8, [bound, bound]),
            Refusal::NoSetting { setting, got } => {
                self.report.refused = [got, i32::from(setting.bounds().key)];
                self.report.reason = NO_SETTING;
                return;
            }
            Refusal::NoLoop => (NO_LOOP, [0.0; 2]),
            Refusal::Ended => (ENDED, [0.0; 2]),
        };
        self.report.reason = reason;
        self.report.refused = refused.map(micro);
    }
}

fn micro(value: f32) -> i32 {
    to_i32(value * 1e6)
}

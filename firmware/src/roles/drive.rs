//! What a drive's node needs of its board: the PWM interrupt, the readings and the brake.

use super::{Node, Role, send};
use crate::boards::{Board, Selected};
use crate::refusal::{Refusal, refuse};
use crate::storage::Storage;
use crate::watchdog::{self, Party};
use crate::{check, current_loop, log_lines};
use static_cell::StaticCell;
use tautrack::bus::network::NmtState;
use tautrack::bus::node::Condition;
use tautrack::can::Frame;
use tautrack::fault_log::FaultLog;
use tautrack::motor::capture::{Capture, Request};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{BridgeDemand, Config, CurrentLoop, Excitation, Measurement};
use tautrack::motor::shaft_sensor;
use tautrack::roles::drive::{self, Control, Measurements, Motor, Readings};
use tautrack::roles::settings::Found;
use tautrack::settings::Settings;

/// The motor on the board.
pub struct BoardMotor;

impl Motor for BoardMotor {
    fn readings(&mut self) -> Readings {
        let means = current_loop::take_means(Selected::index);
        if means.is_some() {
            watchdog::ran(Party::Pwm);
        }
        // The current loop follows the zeros, and a calibration changes them.
        if let Some((limit, zeros)) = current_loop::over_current() {
            Selected::set_over_current(limit, zeros);
        }
        Readings {
            encoder: Selected::encoder(),
            encoder_broken: Selected::encoder_broken(),
            bridge_stop: Selected::bridge_stop(),
            means,
            supply_voltage: Selected::supply_voltage(),
            temperatures: Selected::temperatures(),
            switches: Selected::switches(),
        }
    }

    fn shaft_sensor(&mut self) -> shaft_sensor::Reading {
        Selected::shaft_sensor()
    }

    fn install(&mut self, current_loop: CurrentLoop) {
        current_loop::install(current_loop);
    }

    fn set_limits(&mut self, settings: &Settings) {
        current_loop::set_limits(&Config::from_settings(settings, 0));
    }

    fn set_cogging(&mut self, periods: i32, wave: Wave) {
        current_loop::set_cogging(periods, wave);
    }

    fn demand(&mut self, demand: BridgeDemand, supply_voltage: f32, velocity: f32) {
        current_loop::demand(demand, supply_voltage, velocity);
    }

    fn excite(&mut self, excitation: &Excitation, supply_voltage: f32) {
        current_loop::excite(excitation, supply_voltage);
    }

    fn take_measurement(&mut self, supply_voltage: f32) -> Option<Measurement> {
        current_loop::take_measurement(supply_voltage)
    }

    fn set_brake(&mut self, released: bool) {
        Selected::set_brake(released);
    }

    fn capture<R>(&mut self, use_it: impl FnOnce(&mut Capture) -> R) -> Option<R> {
        current_loop::capture(use_it)
    }

    fn request_capture(&mut self, request: Request) {
        current_loop::request_capture(request);
    }
}

/// A drive with its large parts in static variables: so they are neither copied into the task nor
/// through the stack.
pub type Drive<C> = drive::Drive<&'static mut C, &'static mut Measurements, Flash>;

/// Settings of a drive in the flash of its board.
type Flash = Storage<<Selected as Board>::Storage>;

/// What the node of a drive is made of.
pub type Parts<'a, C> = drive::Parts<'a, &'static mut C, &'static mut Measurements, Flash>;

/// Returns what the node is made of besides its control core. Returns a [`Refusal`] if it was made
/// before.
pub fn parts<'a, C>(
    role: &Role,
    settings: &'a Settings,
    found: Found,
    control: &'static mut C,
) -> Result<Parts<'a, C>, Refusal> {
    static MEASUREMENTS: StaticCell<Measurements> = StaticCell::new();
    let ratings = &Selected::POWER_STAGE;
    let measurements = MEASUREMENTS
        .try_init_with(|| Measurements::new(settings, ratings))
        .ok_or_else(|| refuse("measurements", "they were created before"))?;
    Ok(Parts {
        settings,
        control,
        measurements,
        store: Storage::new(settings, found, role.check, Selected::storage()),
        serial: Selected::serial_number(),
        ratings,
    })
}

impl<C: Control + Send> Node for Drive<C> {
    fn boot(&mut self, now_us: u64) {
        Self::boot(self, now_us, &mut send);
    }

    fn receive(&mut self, frame: &Frame, now_us: u64) {
        Self::receive(self, frame, now_us, &mut send);
    }

    fn note_bus(&mut self, condition: Condition) {
        Self::note_bus(self, condition, &mut send);
    }

    fn tick(&mut self, now_us: u64) -> bool {
        let ticked = Self::tick(self, now_us, &mut BoardMotor, &mut send);
        log_lines::drive(ticked);
        ticked.restart
    }

    fn state(&self) -> NmtState {
        Self::state(self)
    }

    fn errors(&mut self) -> &mut FaultLog {
        Self::errors(self)
    }
}

/// Installs the current loop for the motor in the settings. Returns a [`Refusal`] if the loop
/// cannot be computed from them.
pub fn install_current_loop(settings: &Settings) -> Result<(), Refusal> {
    current_loop::install(check::current_loop(settings)?);
    watchdog::require(Party::Pwm);
    Ok(())
}

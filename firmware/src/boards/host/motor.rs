//! The board of a drive: its motor, the PWM interrupt and the inputs.

use crate::boards::lockstep::AttachedMotor;
use std::boxed::Box;
use tautrack::link::{Sensors, Shaft};
use tautrack::motor::bridge::PowerStage;
use tautrack::motor::capture::{Capture, Request};
use tautrack::motor::cogging::Wave;
use tautrack::motor::current::{BridgeDemand, Config, CurrentLoop, Excitation, Measurement};
use tautrack::roles::drive::{self, Readings};
use tautrack::sensors::Temperatures;
use tautrack::settings::Settings;

/// Board of a drive. A guard's has no motor.
#[derive(Default)]
pub(super) struct Motor {
    attached: Option<AttachedMotor>,
    current_loop: Option<CurrentLoop>,
    capture: Box<Capture>,
    /// The recording needs samples.
    capturing: bool,
    brake_released: bool,
    sensors: Sensors,
    /// The encoder's index gave a pulse.
    index: bool,
}

impl Motor {
    pub fn attach(&mut self, motor: AttachedMotor) {
        self.attached = Some(motor);
    }

    /// Reads the rotor sensor of these settings from now on.
    pub fn choose_sensor(&mut self, settings: &Settings) {
        if let Some(motor) = &mut self.attached {
            motor.choose_sensor(settings);
        }
    }

    /// Runs the PWM periods of one step. Returns the motion of the output shaft.
    pub fn step(&mut self, sensors: &Sensors) -> Shaft {
        self.sensors = *sensors;
        let Some(motor) = &mut self.attached else {
            return Shaft::default();
        };
        let shaft = motor.step(sensors, self.brake_released, |readings| {
            let Some(current_loop) = &mut self.current_loop else {
                return PowerStage::default();
            };
            let stage = current_loop.period(readings);
            if self.capturing {
                self.capture.record(&current_loop.signals(readings, stage));
                self.capturing = self.capture.is_active();
            }
            stage
        });
        self.index |= motor.take_index();
        shaft
    }
}

impl drive::Motor for Motor {
    fn readings(&mut self) -> Readings {
        let means = self.current_loop.as_mut().and_then(|current_loop| {
            if std::mem::take(&mut self.index) {
                // The simulated sensor counts within a turn, which begins at the index.
                current_loop.index_pulse(0);
            }
            current_loop.take_means()
        });
        let motor = self.attached.as_ref();
        Readings {
            encoder: motor.map_or(0, AttachedMotor::encoder),
            encoder_broken: motor.is_some_and(AttachedMotor::encoder_broken),
            bridge_stop: None,
            means,
            supply_voltage: self.sensors.supply_voltage,
            temperatures: Temperatures::default(),
            switches: self.sensors.switches,
        }
    }

    fn install(&mut self, current_loop: CurrentLoop) {
        self.current_loop = Some(current_loop);
    }

    fn set_limits(&mut self, settings: &Settings) {
        if let Some(current_loop) = &mut self.current_loop {
            current_loop.set_limits(&Config::from_settings(settings, 0));
        }
    }

    fn set_cogging(&mut self, periods: i32, wave: Wave) {
        if let Some(current_loop) = &mut self.current_loop {
            current_loop.set_cogging(periods, wave);
        }
    }

    fn demand(&mut self, demand: BridgeDemand, supply_voltage: f32, velocity: f32) {
        if let Some(current_loop) = &mut self.current_loop {
            current_loop.demand(demand, supply_voltage, velocity);
        }
    }

    fn excite(&mut self, excitation: &Excitation, supply_voltage: f32) {
        if let Some(current_loop) = &mut self.current_loop {
            current_loop.excite(excitation, supply_voltage);
        }
    }

    fn take_measurement(&mut self, supply_voltage: f32) -> Option<Measurement> {
        self.current_loop.as_mut()?.take_measurement(supply_voltage)
    }

    fn set_brake(&mut self, released: bool) {
        self.brake_released = released;
    }

    fn capture<R>(&mut self, use_it: impl FnOnce(&mut Capture) -> R) -> Option<R> {
        let result = use_it(&mut self.capture);
        self.capturing = self.capture.is_active();
        Some(result)
    }

    fn request_capture(&mut self, request: Request) {
        self.capture(|capture| capture.request(request));
    }
}

//! A drive's node: the roles axle and screw. `objects` are its objects, `heard` is what the bus has
//! brought since the last tick, `targets` says which targets count, `bench` how long a
//! request for bench mode stands, `leaving` how it leaves operation before a restart, and `tuning`
//! which settings take effect at once.

mod bench;
mod heard;
mod leaving;
mod objects;
mod targets;
mod tuning;

use super::settings::Store;
use super::{axle, screw};
use crate::bus::cia402::State;
use crate::bus::network::NmtState;
use crate::bus::node::{Condition, Configuration, Core, Table, Values};
use crate::bus::pdo::{DriveMotion, transmit};
use crate::can::Frame;
use crate::constants::CONTROL_HZ;
use crate::fault_log::{Circumstances, FaultLog};
use crate::motor::board_limits;
use crate::motor::bridge::{BridgeStop, Ratings};
use crate::motor::calibration;
use crate::motor::capture::{Capture, Request};
use crate::motor::cogging::Wave;
use crate::motor::current::{
    Config, CurrentLoop, CurrentLoopError, Excitation, Means, Measurement,
};
use crate::motor::shaft_sensor;
use crate::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use crate::node::calibration::{self as calibrator, Action, Calibrator};
use crate::node::cogging::{self, CoggingSearch};
use crate::node::screw::{self as screw_control, Screw};
use crate::screw::Geometry;
use crate::sensors::{Switches, Temperatures};
use crate::settings::{Setting, Settings};
use bench::Bench;
use core::borrow::{Borrow, BorrowMut};
use heard::Heard;
use leaving::{Leaving, Next};
use objects::Objects;
use targets::Memory;
use tuning::Tuning;

/// What a board measures in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Readings {
    /// Counts of the rotor sensor.
    pub encoder: i32,
    /// The rotor sensor is broken.
    pub encoder_broken: bool,
    /// What has opened the bridge without software.
    pub bridge_stop: Option<BridgeStop>,
    /// Means of the current samples since the last tick; `None` without a sample.
    pub means: Option<Means>,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Temperatures of bridge and motor.
    pub temperatures: Temperatures,
    /// The axle's switches.
    pub switches: Switches,
}

/// The current loop, its recording and the brake, which run on the board.
pub trait Motor {
    /// Returns what the board has measured.
    fn readings(&mut self) -> Readings;
    /// Returns what is known of the sensor at the output shaft. A board without one keeps this
    /// method.
    fn shaft_sensor(&mut self) -> shaft_sensor::Reading {
        shaft_sensor::Reading::default()
    }
    /// Installs a current loop.
    fn install(&mut self, current_loop: CurrentLoop);
    /// Takes over the current limit of these settings ([`CurrentLoop::set_limits`]).
    fn set_limits(&mut self, settings: &Settings);
    /// Sets the current that cancels the cogging torque ([`CurrentLoop::set_cogging`]).
    fn set_cogging(&mut self, periods: i32, wave: Wave);
    /// Sets the demand of the bridge ([`CurrentLoop::demand`]).
    fn demand(&mut self, demand: BridgeDemand, supply_voltage: f32, velocity: f32);
    /// Excites the motor ([`CurrentLoop::excite`]).
    fn excite(&mut self, excitation: &Excitation, supply_voltage: f32);
    /// Returns what the excitation has measured since the last call; `None` without a sample.
    fn take_measurement(&mut self, supply_voltage: f32) -> Option<Measurement>;
    /// Releases the holding brake, or lets it engage.
    fn set_brake(&mut self, released: bool);
    /// Calls `use_it` with the recording.
    fn capture<R>(&mut self, use_it: impl FnOnce(&mut Capture) -> R) -> Option<R>;
    /// Follows a client's request for a recording ([`Capture::request`]).
    fn request_capture(&mut self, request: Request);
}

/// Control core of a drive.
pub trait Control {
    /// Returns the axle.
    fn axle(&mut self) -> &mut Axle;
    /// Runs a tick. A screw also gets the motion of its joint with the time of its measurement, us.
    fn tick(&mut self, inputs: Inputs, joint: Option<(DriveMotion, u64)>) -> Outputs;
    /// Takes over the gains and limits of these settings, which take effect at once.
    fn retune(&mut self, settings: &Settings);
    /// Takes the newest reading of the sensor at the output shaft. A screw has none, and keeps this
    /// method.
    fn locate(&mut self, _: shaft_sensor::Reading) {}
}

impl Control for Axle {
    fn axle(&mut self) -> &mut Axle {
        self
    }

    fn tick(&mut self, inputs: Inputs, _: Option<(DriveMotion, u64)>) -> Outputs {
        Axle::tick(self, &inputs)
    }

    fn retune(&mut self, settings: &Settings) {
        Axle::retune(self, settings);
    }

    fn locate(&mut self, shaft: shaft_sensor::Reading) {
        Axle::locate(self, shaft);
    }
}

impl<G: Borrow<Geometry>> Control for Screw<G> {
    fn axle(&mut self) -> &mut Axle {
        self.axle_mut()
    }

    fn tick(&mut self, axle: Inputs, joint: Option<(DriveMotion, u64)>) -> Outputs {
        Screw::tick(self, &screw_control::Inputs { axle, joint })
    }

    fn retune(&mut self, settings: &Settings) {
        Screw::retune(self, settings);
    }
}

impl<C: Control> Control for &mut C {
    fn axle(&mut self) -> &mut Axle {
        C::axle(self)
    }

    fn tick(&mut self, inputs: Inputs, joint: Option<(DriveMotion, u64)>) -> Outputs {
        C::tick(self, inputs, joint)
    }

    fn retune(&mut self, settings: &Settings) {
        C::retune(self, settings);
    }

    fn locate(&mut self, shaft: shaft_sensor::Reading) {
        C::locate(self, shaft);
    }
}

/// What a drive measures on request: its motor, and the current that cancels the cogging torque.
pub struct Measurements {
    calibrator: Calibrator,
    cogging: CoggingSearch,
}

impl Measurements {
    /// Creates the measurements of a drive with these settings.
    pub fn new(settings: &Settings, ratings: &Ratings) -> Self {
        Self {
            calibrator: Calibrator::new(settings, ratings),
            cogging: CoggingSearch::new(settings),
        }
    }
}

/// Node of a drive with the control core `C`, its measurements at `M`, and the flash `S`. What is
/// large may be a reference.
pub struct Drive<C, M, S> {
    core: Core,
    objects: Objects<S>,
    control: C,
    measurements: M,
    leaving: Leaving,
}

/// What a tick of a drive has found.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Ticked {
    /// Code of the fault that it reports, if any.
    pub fault: Option<u16>,
    /// The node is to restart: the network management has reset it, and it has left operation.
    pub restart: bool,
}

/// What a node is made of.
pub struct Parts<'a, C, M, S> {
    /// Settings at start.
    pub settings: &'a Settings,
    /// Control core.
    pub control: C,
    /// Measurements.
    pub measurements: M,
    /// Flash.
    pub store: S,
    /// Serial number of the board.
    pub serial: u32,
    /// Ratings of the board's bridge.
    pub ratings: &'static Ratings,
}

/// Receive PDO of the joint's motion, counted from 0.
const JOINT_PDO: usize = 3;

impl<C: Control, M: BorrowMut<Measurements>, S: Store> Drive<C, M, S> {
    /// Creates the node of an axle.
    pub fn axle(parts: Parts<'_, C, M, S>) -> Self {
        Self::new(parts, &axle::TABLE, None)
    }

    /// Creates the node of a screw, which listens to its joint.
    pub fn screw(parts: Parts<'_, C, M, S>) -> Self {
        let joint = transmit(1) + u16::from(parts.settings.id(Setting::JointId));
        Self::new(parts, &screw::TABLE, Some(joint))
    }

    fn new(parts: Parts<'_, C, M, S>, table: &'static Table, joint: Option<u16>) -> Self {
        let configuration = Configuration {
            listens: joint.map(|id| (JOINT_PDO, id)),
            ..super::configuration(parts.settings)
        };
        Self {
            core: Core::new(configuration),
            objects: Objects {
                values: Values([0; screw::BYTES]),
                table,
                heard: Heard::new(parts.settings, joint),
                targets: Memory::default(),
                bench: Bench::new(parts.settings.get(Setting::CommandTimeout) as u32),
                tuning: Tuning::new(parts.settings, parts.ratings),
                retuned: false,
                store: parts.store,
                serial: parts.serial,
                ratings: parts.ratings,
            },
            control: parts.control,
            measurements: parts.measurements,
            leaving: Leaving::default(),
        }
    }

    /// Returns the state of the network management.
    pub fn state(&self) -> NmtState {
        self.core.state()
    }

    /// Returns the history of faults.
    pub fn errors(&mut self) -> &mut FaultLog {
        self.core.errors()
    }

    /// Gives the objects their values at start, and sends the boot-up message.
    pub fn boot(&mut self, now_us: u64, send: &mut impl FnMut(Frame)) {
        self.objects.start(self.control.axle());
        self.core.boot(now_us, self.objects.table, send);
    }

    /// Follows a frame from the bus.
    pub fn receive(&mut self, frame: &Frame, now_us: u64, send: &mut impl FnMut(Frame)) {
        self.objects.heard.note(frame, now_us);
        self.core.receive(frame, now_us, &mut self.objects, send);
    }

    /// Takes the condition of the CAN controller, before a tick.
    pub fn note_bus(&mut self, condition: Condition, send: &mut impl FnMut(Frame)) {
        self.core.note_bus(condition, send);
    }

    /// Runs one control tick.
    pub fn tick(
        &mut self,
        now_us: u64,
        motor: &mut impl Motor,
        send: &mut impl FnMut(Frame),
    ) -> Ticked {
        self.core.tick(now_us, &mut self.objects, send);
        if core::mem::take(&mut self.objects.retuned) {
            self.retune(motor);
        }
        let axle = self.control.axle();
        if core::mem::take(&mut self.objects.heard.parameters) {
            axle.configure(&self.objects.parameters());
        }
        axle.report(core::mem::take(&mut self.objects.heard.found));
        self.objects.renew_targets();
        let shaft = motor.shaft_sensor();
        self.control.locate(shaft);
        self.objects.publish_shaft(shaft);
        let readings = motor.readings();
        let mut inputs = self.objects.inputs(&readings, now_us);
        let restart = self.core.restarts() && self.leave(&mut inputs);
        let joint = self.objects.heard.joint.take();
        let outputs = self.control.tick(inputs, joint);
        self.finish(&inputs, &outputs, motor);
        if let Some(code) = outputs.emergency {
            let measured = Circumstances {
                supply_voltage: inputs.supply_voltage,
                current: inputs.current,
                velocity: outputs.velocity,
            };
            self.core.report(code, &measured, send);
        }
        Ticked {
            fault: outputs.emergency,
            restart,
        }
    }

    /// Puts the settings into use that take effect at once.
    #[inline(never)] // its stack is not that of the tick
    fn retune(&mut self, motor: &mut impl Motor) {
        let calibrator = &mut self.measurements.borrow_mut().calibrator;
        for setting in Setting::live() {
            let value = self.objects.store.value(setting.bounds().key);
            let waits = |value: &i32| self.objects.tuning.waits(setting, *value);
            if let Some(value) = value.filter(|value| !waits(value)) {
                calibrator.set(setting, value);
            }
        }
        self.control.retune(calibrator.settings());
        motor.set_limits(calibrator.settings());
    }

    /// Commands a drive that is to restart to leave operation. Returns whether it has.
    fn leave(&mut self, inputs: &mut Inputs) -> bool {
        self.objects
            .values
            .set(axle::OBJECT2050, calibrator::request::NONE);
        let stands = self.control.axle().stands();
        let operates = self.objects.targets.operating();
        let next = self
            .leaving
            .next(stands, self.objects.tuning.armed, operates);
        inputs.set_point = match next {
            Next::Command(controlword) => Some(SetPoint {
                controlword,
                mode: self.objects.values.get(axle::OBJECT6060),
                target: self.objects.values.get(axle::OBJECT607A),
            }),
            Next::Wait | Next::Restart => None,
        };
        next == Next::Restart
    }

    /// Runs the measurements on request, lets the motor follow the outputs of a tick, and publishes
    /// them.
    #[inline(never)] // its stack is not that of the tick
    fn finish(&mut self, inputs: &Inputs, outputs: &Outputs, motor: &mut impl Motor) {
        let excitation = self.calibrate(inputs, outputs, motor);
        self.compensate(inputs, outputs, motor);
        let supply_voltage = inputs.supply_voltage;
        match &excitation {
            Some(excitation) => motor.excite(excitation, supply_voltage),
            None => motor.demand(outputs.bridge, supply_voltage, outputs.velocity),
        }
        // A calibration turns the motor, so it releases the brake.
        let calibrates = excitation.is_some();
        self.objects.tuning.update(inputs, outputs, calibrates);
        motor.set_brake(calibrates || outputs.brake_released);
        if outputs.emergency.is_some_and(|code| code != 0) {
            motor.capture(Capture::fault);
        }
        let guarded = self.core.is_guarded(inputs.now_us);
        self.objects.publish(inputs, outputs, guarded);
        if inputs.guard_received {
            // The guard's first heartbeat has restored them.
            let parameters = self.control.axle().parameters();
            axle::publish_parameters(&mut self.objects.values, &parameters);
        }
        self.objects.serve_capture(motor);
    }

    /// Runs a tick of the calibration, if one is under way or requested. Returns how it excites the
    /// motor.
    fn calibrate(
        &mut self,
        inputs: &Inputs,
        outputs: &Outputs,
        motor: &mut impl Motor,
    ) -> Option<Excitation> {
        use calibrator::request::NONE;
        let requested = self.objects.values.get(axle::OBJECT2050);
        let calibrator = &self.measurements.borrow().calibrator;
        if requested == NONE && !calibrator.is_running() {
            return None;
        }
        let excitation = self.excitation(requested, inputs, outputs, motor);
        let calibrator = &self.measurements.borrow().calibrator;
        axle::publish_calibration(&mut self.objects.values, calibrator.report());
        if excitation.is_none() {
            let Objects {
                tuning, ratings, ..
            } = &mut self.objects;
            tuning.fit(calibrator.settings(), ratings);
            self.objects.values.set(axle::OBJECT2050, NONE);
        }
        excitation
    }

    #[inline(never)] // a new current loop takes stack that the other ticks do not need
    fn excitation(
        &mut self,
        request: u8,
        inputs: &Inputs,
        outputs: &Outputs,
        motor: &mut impl Motor,
    ) -> Option<Excitation> {
        let disarmed =
            State::from_statusword(outputs.status.statusword) == Some(State::SwitchOnDisabled);
        let allowed = outputs.bench_mode && disarmed && outputs.faults.is_empty();
        let calibrator = &mut self.measurements.borrow_mut().calibrator;
        let action = calibrator.tick(
            request,
            allowed,
            outputs.velocity,
            &calibrator::Inputs {
                encoder: inputs.encoder,
                supply_voltage: inputs.supply_voltage,
                measured: motor.take_measurement(inputs.supply_voltage),
            },
        );
        match action {
            Action::Excite(excitation) => Some(excitation),
            Action::Install(current_loop) => {
                motor.install(current_loop);
                let settings = calibrator.settings();
                self.control.axle().use_torque_constant(settings);
                None
            }
            Action::None => None,
        }
    }

    /// Runs a tick of the search for the current that cancels the cogging torque, if one is under
    /// way or requested.
    fn compensate(&mut self, inputs: &Inputs, outputs: &Outputs, motor: &mut impl Motor) {
        let requested = self.objects.values.get(axle::OBJECT2065) != 0;
        let cogging = &mut self.measurements.borrow_mut().cogging;
        if !(requested || cogging.is_running()) {
            return;
        }
        let position = self.control.axle().position();
        let found = cogging.tick(requested, inputs, outputs, position);
        if let Some((periods, wave)) = found {
            motor.set_cogging(periods, wave);
        }
        axle::publish_cogging(&mut self.objects.values, cogging.report());
        if !cogging.is_running() {
            self.objects.values.set(axle::OBJECT2065, 0);
        }
    }
}

/// Computes the current loop for the motor in the settings.
///
/// # Errors
/// The loop cannot be computed from them.
pub fn current_loop(settings: &Settings, stage: &Ratings) -> Result<CurrentLoop, CurrentLoopError> {
    let config = Config::from_settings(settings, stage.pwm_hz / CONTROL_HZ);
    let sensing = calibration::sensing(settings);
    let mut current_loop = CurrentLoop::new(&config, stage)?;
    config.check_range(&sensing, stage)?;
    board_limits::check_velocity(settings, stage.highest_supply)
        .map_err(CurrentLoopError::SupplyTooHigh)?;
    current_loop.set_sensing(sensing);
    let (periods, wave) = cogging::stored(settings);
    current_loop.set_cogging(periods, wave);
    Ok(current_loop)
}

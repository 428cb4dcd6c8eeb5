//! A drive's node: the roles axle and screw.

use super::axle as objects;
use super::screw::BYTES;
use super::settings::{self, Store};
use super::{axle, screw};
use crate::bus::cia402::{State, mode};
use crate::bus::drive_parameters::{self, DriveParameters};
use crate::bus::network::{self, Emergency, NmtState, OFFSET_SYNCS};
use crate::bus::node::{Abort, Address, Configuration, Core, Dictionary, Table, Value, Values};
use crate::bus::pace::Pace;
use crate::bus::pdo::{DriveMotion, receive, transmit};
use crate::bus::scale::UNCONFIGURED;
use crate::can::Frame;
use crate::constants::{CONTROL_HZ, CONTROL_PERIOD};
use crate::faults::{Fault, Faults};
use crate::motor::bridge::Ratings;
use crate::motor::calibration;
use crate::motor::capture::{CHANNELS, Capture, Request, WINDOW};
use crate::motor::cogging::Wave;
use crate::motor::current::{
    Config, CurrentLoop, CurrentLoopError, Electrical, Excitation, Means, Measurement,
};
use crate::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use crate::node::calibration::{self as calibrator, Action, Calibrator};
use crate::node::cogging::{self, CoggingSearch};
use crate::node::screw::{self as screw_control, Screw};
use crate::screw::Geometry;
use crate::sensors::{Switches, Temperatures};
use crate::settings::{Setting, Settings};
use core::borrow::{Borrow, BorrowMut};

/// What a board measures in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Readings {
    /// Counts of the rotor sensor.
    pub encoder: i32,
    /// The rotor sensor is broken.
    pub encoder_broken: bool,
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
    /// Installs a current loop.
    fn install(&mut self, current_loop: CurrentLoop);
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
    /// Runs a tick. A screw also gets the motion of its joint with the time of its measurement, us,
    /// and the commanded slack, 2^-24 m.
    fn tick(&mut self, inputs: Inputs, joint: Option<(DriveMotion, u64)>, slack: i32) -> Outputs;
}

impl Control for Axle {
    fn axle(&mut self) -> &mut Axle {
        self
    }

    fn tick(&mut self, inputs: Inputs, _: Option<(DriveMotion, u64)>, _: i32) -> Outputs {
        Axle::tick(self, &inputs)
    }
}

impl<G: Borrow<Geometry>> Control for Screw<G> {
    fn axle(&mut self) -> &mut Axle {
        self.axle_mut()
    }

    fn tick(&mut self, axle: Inputs, joint: Option<(DriveMotion, u64)>, slack: i32) -> Outputs {
        Screw::tick(self, &screw_control::Inputs { axle, joint, slack })
    }
}

impl<C: Control> Control for &mut C {
    fn axle(&mut self) -> &mut Axle {
        C::axle(self)
    }

    fn tick(&mut self, inputs: Inputs, joint: Option<(DriveMotion, u64)>, slack: i32) -> Outputs {
        C::tick(self, inputs, joint, slack)
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

/// Index of the torque feed-forward (CiA 402 calls it "torque offset"). It is sent less often than
/// set-points, and writing it does not count as a set-point.
const TORQUE_OFFSET: u16 = 0x60b2;

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
                values: Values([0; BYTES]),
                table,
                heard: Heard::new(parts.settings, joint),
                armed: false,
                store: parts.store,
                serial: parts.serial,
                ratings: parts.ratings,
            },
            control: parts.control,
            measurements: parts.measurements,
        }
    }

    /// Returns the state of the network management.
    pub fn state(&self) -> NmtState {
        self.core.state()
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

    /// Runs one control tick. Returns the code of the fault that it reports, if any.
    pub fn tick(
        &mut self,
        now_us: u64,
        motor: &mut impl Motor,
        send: &mut impl FnMut(Frame),
    ) -> Option<u16> {
        self.core.tick(now_us, &mut self.objects, send);
        let axle = self.control.axle();
        if core::mem::take(&mut self.objects.heard.parameters) {
            axle.configure(&self.objects.parameters());
        }
        axle.report(core::mem::take(&mut self.objects.heard.found));
        let readings = motor.readings();
        let inputs = self.objects.inputs(&readings, now_us);
        let joint = self.objects.heard.joint.take();
        let slack = self.objects.values.get(screw::OBJECT2101);
        if inputs.guard_received {
            // A slack is for bench mode.
            self.objects.values.set(screw::OBJECT2101, 0);
        }
        let outputs = self.control.tick(inputs, joint, slack);
        self.finish(&inputs, &outputs, motor);
        if let Some(code) = outputs.emergency {
            let node = self.objects.heard.own;
            send(network::emergency(Emergency { node, code }));
        }
        outputs.emergency
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
        self.objects.armed = calibrates || outputs.bridge != BridgeDemand::Off;
        motor.set_brake(calibrates || outputs.brake_released);
        if outputs.emergency.is_some_and(|code| code != 0) {
            motor.capture(Capture::fault);
        }
        self.objects.publish(outputs, inputs.bench_mode);
        if inputs.guard_received {
            // The guard's first heartbeat has restored them.
            let parameters = self.control.axle().parameters();
            objects::publish_parameters(&mut self.objects.values, &parameters);
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
        let requested = self.objects.values.get(objects::OBJECT2050);
        let calibrator = &self.measurements.borrow().calibrator;
        if requested == NONE && !calibrator.is_running() {
            return None;
        }
        let excitation = self.excitation(requested, inputs, outputs, motor);
        let calibrator = &self.measurements.borrow().calibrator;
        objects::publish_calibration(&mut self.objects.values, calibrator.report());
        if excitation.is_none() {
            self.objects.values.set(objects::OBJECT2050, NONE);
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
        let requested = self.objects.values.get(objects::OBJECT2065) != 0;
        let cogging = &mut self.measurements.borrow_mut().cogging;
        if !(requested || cogging.is_running()) {
            return;
        }
        let position = self.control.axle().position();
        let found = cogging.tick(requested, inputs, outputs, position);
        if let Some((periods, wave)) = found {
            motor.set_cogging(periods, wave);
        }
        objects::publish_cogging(&mut self.objects.values, cogging.report());
        if !cogging.is_running() {
            self.objects.values.set(objects::OBJECT2065, 0);
        }
    }
}

/// Computes the current loop for the motor in the settings.
///
/// # Errors
/// The loop cannot be computed from them.
pub fn current_loop(settings: &Settings, stage: &Ratings) -> Result<CurrentLoop, CurrentLoopError> {
    let config = Config::from_settings(settings, stage.pwm_hz / CONTROL_HZ);
    let mut current_loop = CurrentLoop::new(&config, stage)?;
    current_loop.set_sensing(calibration::sensing(settings));
    let (periods, wave) = cogging::stored(settings);
    current_loop.set_cogging(periods, wave);
    Ok(current_loop)
}

/// The objects of a drive. Those of an axle have the same places in a screw, which has a few more.
struct Objects<S> {
    values: Values<BYTES>,
    table: &'static Table,
    heard: Heard,
    /// The motor has current.
    armed: bool,
    store: S,
    serial: u32,
    ratings: &'static Ratings,
}

impl<S: Store> Dictionary for Objects<S> {
    fn table(&self) -> &'static Table {
        self.table
    }

    fn values(&self) -> &[u8] {
        &self.values.0
    }

    fn values_mut(&mut self) -> &mut [u8] {
        &mut self.values.0
    }

    fn read(&self, address: Address) -> Result<Value, Abort> {
        settings::read(&self.store, address)
    }

    fn write(&mut self, address: Address, value: &[u8]) -> Result<(), Abort> {
        settings::write(&mut self.store, address, value, self.armed)
    }

    fn serves(&self, index: u16) -> bool {
        settings::serves(index)
    }

    fn moves(&self, index: u16) -> bool {
        let stays = is_capture(index) || settings::serves(index);
        matches!(index, 0x1400..=0x17ff | 0x2000..) && !stays
    }

    fn check(&self, address: Address, value: &[u8]) -> Result<(), Abort> {
        let signed = match *value {
            [byte] => i32::from(byte as i8),
            [low, high] => i16::from_le_bytes([low, high]).into(),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
            _ => return Ok(()),
        };
        if drive_parameters::supports(address.index, signed) {
            Ok(())
        } else {
            Err(Abort::Range)
        }
    }

    fn written(&mut self, address: Address) {
        let flag = match address.index {
            TORQUE_OFFSET => &mut self.heard.offset,
            index if drive_parameters::is_parameter(index) => &mut self.heard.parameters,
            index if is_capture(index) => &mut self.heard.capture,
            // A client may write single objects of the drive profile instead of process data.
            0x6000.. => &mut self.heard.set_point,
            _ => return,
        };
        *flag = true;
    }

    fn received(&mut self, id: u16, now_us: u64) {
        let motion = DriveMotion {
            position: self.values.get(screw::OBJECT2100_POSITION),
            velocity: self.values.get(screw::OBJECT2100_VELOCITY),
        };
        self.heard.received(id, motion, now_us);
    }
}

/// Whether the object belongs to the recording of signals, which moves nothing.
fn is_capture(index: u16) -> bool {
    matches!(index, 0x2060..=0x2063)
}

/// Number of bytes in object 0x2063: the number of the window, and its samples.
const WINDOW_BYTES: usize = 2 + WINDOW * CHANNELS * 2;

impl<S: Store> Objects<S> {
    /// Writes the values at start.
    fn start(&mut self, axle: &Axle) {
        let (values, ratings) = (&mut self.values, self.ratings);
        for (place, byte) in values.0.iter_mut().zip(&screw::START) {
            *place = *byte;
        }
        values.set(objects::OBJECT1018_SERIAL, self.serial);
        let mark = if self.store.unconfigured() {
            UNCONFIGURED
        } else {
            0
        };
        values.set(objects::OBJECT2010, axle.scale().code() | mark);
        objects::publish_parameters(values, &axle.parameters());
        values.set(objects::OBJECT2061_RATE, ratings.pwm_hz);
        let full_scale = (ratings.full_scale * 1e3) as u32;
        values.set(objects::OBJECT2061_FULL_SCALE, full_scale);
        values.set(objects::OBJECT2061_PERIOD, ratings.period);
    }

    /// Collects the inputs of one tick.
    fn inputs(&mut self, readings: &Readings, now_us: u64) -> Inputs {
        let set_point = core::mem::take(&mut self.heard.set_point);
        let offset = core::mem::take(&mut self.heard.offset);
        let means = readings.means;
        Inputs {
            now_us,
            encoder: readings.encoder,
            encoder_broken: readings.encoder_broken,
            // NaN: without a sample the current is not known.
            current: means.map_or(f32::NAN, |means| means.current),
            electrical: means.map_or_else(Electrical::default, |means| means.electrical),
            supply_voltage: readings.supply_voltage,
            temperatures: readings.temperatures,
            switches: readings.switches,
            set_point: set_point.then(|| self.set_point()),
            torque_offset: offset.then(|| self.values.get(objects::OBJECT60B2)),
            guard_received: core::mem::take(&mut self.heard.guard),
            bench_mode: self.values.get(objects::OBJECT2001) != 0,
        }
    }

    fn set_point(&self) -> SetPoint {
        let mode = self.values.get(objects::OBJECT6060);
        SetPoint {
            controlword: self.values.get(objects::OBJECT6040),
            mode,
            target: match mode {
                mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY => {
                    self.values.get(objects::OBJECT60FF)
                }
                mode::CYCLIC_TORQUE => self.values.get(objects::OBJECT6071).into(),
                _ => self.values.get(objects::OBJECT607A),
            },
        }
    }

    fn parameters(&self) -> DriveParameters {
        let values = &self.values;
        DriveParameters {
            quick_stop: values.get(objects::OBJECT605A),
            shutdown: values.get(objects::OBJECT605B),
            disable_operation: values.get(objects::OBJECT605C),
            halt: values.get(objects::OBJECT605D),
            fault_reaction: values.get(objects::OBJECT605E),
            following_window: values.get(objects::OBJECT6065),
            following_time: values.get(objects::OBJECT6066),
            position_window: values.get(objects::OBJECT6067),
            position_time: values.get(objects::OBJECT6068),
            position_limits: [
                values.get(objects::OBJECT607D_MINIMUM),
                values.get(objects::OBJECT607D_MAXIMUM),
            ],
            torque_slope: values.get(objects::OBJECT6087),
            homing_method: values.get(objects::OBJECT6098),
        }
    }

    /// Writes the outputs of a tick, which the next SYNC sends. `bench_mode` is the request that
    /// this tick received.
    fn publish(&mut self, outputs: &Outputs, bench_mode: bool) {
        let values = &mut self.values;
        if bench_mode && !outputs.bench_mode {
            values.set(objects::OBJECT2001, 0);
        }
        let register = u8::from(outputs.status.error_code != 0);
        values.set(objects::OBJECT1001, register);
        if let Some(snapshot) = &outputs.snapshot {
            objects::publish_snapshot(values, snapshot);
        }
        objects::publish_outputs(values, outputs);
    }

    /// Follows what a client has written to the objects of the recording, and publishes its state.
    fn serve_capture(&mut self, motor: &mut impl Motor) {
        if core::mem::take(&mut self.heard.capture) {
            self.answer_capture(motor);
        }
        let state = motor.capture(|capture| (capture.state(), capture.before()));
        if let Some((state, before)) = state {
            self.values.set(objects::OBJECT2061_STATE, state as u8);
            self.values.set(objects::OBJECT2061_BEFORE, before);
        }
    }

    /// Takes a client's request, and shows it the part of the recording that it wants.
    #[inline(never)] // a window takes stack that the other ticks do not need
    fn answer_capture(&mut self, motor: &mut impl Motor) {
        let values = &mut self.values;
        let command = values.get(objects::OBJECT2060_COMMAND);
        if command != 0 {
            values.set(objects::OBJECT2060_COMMAND, 0);
            motor.request_capture(Request {
                command,
                signals: values.get(objects::OBJECT2060_SIGNALS),
                decimation: values.get(objects::OBJECT2060_DECIMATION),
                pre_trigger: values.get(objects::OBJECT2060_PRE_TRIGGER),
            });
        }
        let number = values.get(objects::OBJECT2062);
        let Some(samples) = motor.capture(|capture| capture.window(number)) else {
            return;
        };
        let mut bytes = [0; WINDOW_BYTES];
        let [low, high, places @ ..] = &mut bytes;
        [*low, *high] = number.to_le_bytes();
        let samples = samples.as_flattened();
        for (place, value) in places.chunks_exact_mut(2).zip(samples) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        values.set_bytes(objects::OBJECT2063, &bytes);
    }
}

/// What the bus has brought since the last tick.
#[allow(clippy::struct_excessive_bools)] // independent facts, not states
struct Heard {
    own: u8,
    guard_id: u8,
    /// Identifier of the joint's motion, for a screw.
    joint_id: Option<u16>,
    sync_period_us: u32,
    set_point: bool,
    offset: bool,
    parameters: bool,
    capture: bool,
    guard: bool,
    found: Faults,
    /// The joint's motion with its time of measurement, us.
    joint: Option<(DriveMotion, u64)>,
    sync_us: u64,
    set_points: Pace,
    offsets: Pace,
    motions: Pace,
}

impl Heard {
    fn new(settings: &Settings, joint_id: Option<u16>) -> Self {
        Self {
            own: settings.id(Setting::NodeId),
            guard_id: settings.id(Setting::GuardId),
            joint_id,
            sync_period_us: settings.get(Setting::SyncPeriod).unsigned_abs(),
            set_point: false,
            offset: false,
            parameters: false,
            capture: false,
            guard: false,
            found: Faults::NONE,
            joint: None,
            sync_us: 0,
            set_points: Pace::NEW,
            offsets: Pace::NEW,
            motions: Pace::NEW,
        }
    }

    /// Records what a frame means besides its objects.
    fn note(&mut self, frame: &Frame, now_us: u64) {
        if network::is_sync(frame) {
            self.sync_us = now_us;
        }
        self.found
            .insert_if(Fault::DuplicateId, network::is_of(frame, self.own));
        // A guard that waits for its drives commands none of them.
        let ready = (self.guard_id, NmtState::Operational);
        self.guard |= network::as_heartbeat(frame) == Some(ready);
    }

    /// Records that process data have come. The joint's `motion` was measured one control period
    /// before the last SYNC, which all nodes received at the same time.
    fn received(&mut self, id: u16, motion: DriveMotion, now_us: u64) {
        let period_us = self.sync_period_us;
        let (fault, twice) = if id & !0x7f == receive(3) {
            self.offset = true;
            let period_us = period_us * OFFSET_SYNCS;
            (
                Fault::SecondMaster,
                self.offsets.is_exceeded(now_us, period_us),
            )
        } else if Some(id) == self.joint_id {
            let measured_us = self.sync_us.saturating_sub((CONTROL_PERIOD * 1e6) as u64);
            self.joint = Some((motion, measured_us));
            (
                Fault::DuplicateId,
                self.motions.is_exceeded(now_us, period_us),
            )
        } else {
            self.set_point = true;
            (
                Fault::SecondMaster,
                self.set_points.is_exceeded(now_us, period_us),
            )
        };
        self.found.insert_if(fault, twice);
    }
}

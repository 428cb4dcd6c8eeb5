//! Common parts of the roles axle and screw: reads set-points from the object dictionary, writes
//! the state to it, and configures the current loop.

use super::Refusal;
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::bus::{self, Received, Written};
use crate::watchdog::{self, Party};
use crate::{current_loop, storage};
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU16, AtomicU32, Ordering};
use critical_section::Mutex;
use embassy_time::Instant;
use static_cell::StaticCell;
use tautrack::bus::cia402::State;
use tautrack::bus::drive_parameters::is_parameter;
use tautrack::bus::network::{self, Emergency, NmtState, OFFSET_SYNCS};
use tautrack::bus::pace::Pace;
use tautrack::bus::pdo::{DriveMotion, receive};
use tautrack::constants::CONTROL_PERIOD;
use tautrack::faults::{Fault, Faults};
use tautrack::motor::calibration;
use tautrack::motor::capture::{CHANNELS, Capture, WINDOW};
use tautrack::motor::current::{Config, CurrentLoop, Electrical, Excitation};
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::node::calibration::{self as calibrator, Action, Calibrator};
use tautrack::node::cogging::{self, CoggingSearch};
use tautrack::settings::{Setting, Settings};

/// Messages from the bus task that the control task has not read yet.
pub static HEARD: Mailbox = Mailbox {
    set_point: AtomicBool::new(false),
    offset: AtomicBool::new(false),
    parameters: AtomicBool::new(false),
    capture: AtomicBool::new(false),
    guard: AtomicBool::new(false),
    second_master: AtomicBool::new(false),
    duplicate_id: AtomicBool::new(false),
    joint: Mutex::new(Cell::new(None)),
    sync_us: Mutex::new(Cell::new(0)),
    ids: Ids {
        own: AtomicU8::new(0),
        guard: AtomicU8::new(0),
        joint: AtomicU16::new(0),
        sync_period_us: AtomicU32::new(0),
    },
    set_points: Mutex::new(Cell::new(Pace::NEW)),
    offsets: Mutex::new(Cell::new(Pace::NEW)),
    motions: Mutex::new(Cell::new(Pace::NEW)),
};

/// Index of the torque feed-forward (CiA 402 calls it "torque offset"). It is sent less often than
/// set-points, and writing it does not count as a set-point.
const TORQUE_OFFSET: u16 = 0x60b2;

type SharedPace = Mutex<Cell<Pace>>;

/// Mailbox from the bus task to the control task, see [`HEARD`].
pub struct Mailbox {
    set_point: AtomicBool,
    offset: AtomicBool,
    parameters: AtomicBool,
    capture: AtomicBool,
    guard: AtomicBool,
    second_master: AtomicBool,
    duplicate_id: AtomicBool,
    joint: Mutex<Cell<Option<(DriveMotion, u64)>>>,
    sync_us: Mutex<Cell<u64>>,
    ids: Ids,
    set_points: SharedPace,
    offsets: SharedPace,
    motions: SharedPace,
}

/// Identifiers of the nodes that concern a drive.
struct Ids {
    own: AtomicU8,
    guard: AtomicU8,
    /// Identifier of the joint's motion; 0 for a drive that follows no joint.
    joint: AtomicU16,
    sync_period_us: AtomicU32,
}

impl Mailbox {
    /// Takes over the identifiers of the robot. Frames with the identifier `joint`, unless it is 0,
    /// carry the joint's motion and do not count as set-points.
    pub fn start(&self, settings: &Settings, joint: u16) {
        let period_us = settings.get(Setting::SyncPeriod).unsigned_abs();
        let Ids { own, guard, .. } = &self.ids;
        own.store(settings.id(Setting::NodeId), Ordering::Relaxed);
        guard.store(settings.id(Setting::GuardId), Ordering::Relaxed);
        self.ids.joint.store(joint, Ordering::Relaxed);
        self.ids.sync_period_us.store(period_us, Ordering::Relaxed);
    }

    /// Records the meaning of a received frame.
    pub fn note(&self, received: &Received) {
        let (frame, now_us) = (&received.frame, received.now_us);
        if network::is_sync(frame) {
            critical_section::with(|cs| self.sync_us.borrow(cs).set(now_us));
        }
        if network::is_of(frame, self.ids.own.load(Ordering::Relaxed)) {
            self.duplicate_id.store(true, Ordering::Relaxed);
        }
        // A guard that waits for its drives commands none of them.
        let ready = (
            self.ids.guard.load(Ordering::Relaxed),
            NmtState::Operational,
        );
        if network::as_heartbeat(frame) == Some(ready) {
            self.guard.store(true, Ordering::Relaxed);
        }
        let flag = match received.wrote {
            Written::ProcessData => match frame.id() {
                id if id & !0x7f == receive(3) => {
                    self.watch(&self.offsets, OFFSET_SYNCS, now_us, &self.second_master);
                    &self.offset
                }
                id if id == self.ids.joint.load(Ordering::Relaxed) => {
                    self.watch(&self.motions, 1, now_us, &self.duplicate_id);
                    return;
                }
                _ => {
                    self.watch(&self.set_points, 1, now_us, &self.second_master);
                    &self.set_point
                }
            },
            Written::Object(TORQUE_OFFSET, _) => &self.offset,
            Written::Object(index, _) if is_parameter(index) => &self.parameters,
            Written::Object(index, _) if bus::is_capture(index) => &self.capture,
            // A client may write single objects of the drive profile instead of process data.
            Written::Object(0x6000.., _) => &self.set_point,
            Written::Object(..) | Written::Nothing => return,
        };
        flag.store(true, Ordering::Relaxed);
    }

    /// Sets `found` if frames of which one is due every `syncs` come from two nodes.
    fn watch(&self, pace: &SharedPace, syncs: u32, now_us: u64, found: &AtomicBool) {
        let period_us = self.ids.sync_period_us.load(Ordering::Relaxed) * syncs;
        critical_section::with(|cs| {
            let cell = pace.borrow(cs);
            let mut pace = cell.get();
            if pace.is_exceeded(now_us, period_us) {
                found.store(true, Ordering::Relaxed);
            }
            cell.set(pace);
        });
    }

    /// Returns the faults that the bus has shown since the last call.
    pub fn take_faults(&self) -> Faults {
        let mut found = Faults::NONE;
        let [master, twice] = [&self.second_master, &self.duplicate_id];
        found.insert_if(Fault::SecondMaster, take(master));
        found.insert_if(Fault::DuplicateId, take(twice));
        found
    }

    /// Returns whether a client has written a parameter since the last call.
    pub fn take_parameters(&self) -> bool {
        take(&self.parameters)
    }

    /// Returns whether a client has written an object of the recording since the last call.
    pub fn take_capture(&self) -> bool {
        take(&self.capture)
    }

    /// Stores the joint's motion with its time of measurement: one control period before the last
    /// SYNC, which all nodes received at the same time.
    pub fn note_joint(&self, motion: DriveMotion) {
        critical_section::with(|cs| {
            let measured_us = self
                .sync_us
                .borrow(cs)
                .get()
                .saturating_sub((CONTROL_PERIOD * 1e6) as u64);
            self.joint.borrow(cs).set(Some((motion, measured_us)));
        });
    }

    /// Removes and returns the joint's motion and its time of measurement (us since power-up), if a
    /// new one was received.
    pub fn take_joint(&self) -> Option<(DriveMotion, u64)> {
        critical_section::with(|cs| self.joint.borrow(cs).take())
    }
}

/// Clears a flag that the bus task sets, and returns whether it was set. The control task, which
/// calls this, interrupts the bus task and is not interrupted by it.
fn take(flag: &AtomicBool) -> bool {
    let set = flag.load(Ordering::Relaxed);
    flag.store(false, Ordering::Relaxed);
    set
}

/// Collects the inputs of one tick. `set_point` and `torque_offset` read the objects; each is
/// called only if one of its objects was written since the last tick.
pub fn inputs(set_point: fn() -> SetPoint, torque_offset: fn() -> i16, bench_mode: bool) -> Inputs {
    let means = current_loop::take_means(Selected::index);
    if means.is_some() {
        watchdog::ran(Party::Pwm);
    }
    Inputs {
        now_us: Instant::now().as_micros(),
        encoder: Selected::encoder(),
        encoder_broken: Selected::encoder_broken(),
        // NaN: without a sample the current is not known.
        current: means.map_or(f32::NAN, |means| means.current),
        electrical: means.map_or_else(Electrical::default, |means| means.electrical),
        supply_voltage: Selected::supply_voltage(),
        temperatures: Selected::temperatures(),
        switches: Selected::switches(),
        // Nothing arms a drive while its flash is being written.
        set_point: (take(&HEARD.set_point) && !storage::is_writing()).then(set_point),
        torque_offset: take(&HEARD.offset).then(torque_offset),
        guard_received: take(&HEARD.guard),
        bench_mode,
    }
}

/// Passes the tick's demand to the PWM interrupt, or the excitation of a calibration, and sends the
/// tick's emergency message on the bus. A calibration turns the motor, so it releases the brake.
pub fn act(outputs: &Outputs, node: u8, excitation: Option<&Excitation>) {
    let supply_voltage = Selected::supply_voltage();
    match excitation {
        Some(excitation) => current_loop::excite(excitation, supply_voltage),
        None => current_loop::demand(outputs.bridge, supply_voltage, outputs.velocity),
    }
    let calibrates = excitation.is_some();
    storage::set_armed(calibrates || outputs.bridge != BridgeDemand::Off);
    Selected::set_brake(calibrates || outputs.brake_released);
    watchdog::control_ran(Instant::now().as_micros());
    if let Some(code) = outputs.emergency {
        crate::logger::warn!("fault {:#06x}", code);
        bus::send(network::emergency(Emergency { node, code }));
        if code != 0 {
            current_loop::capture(Capture::fault);
        }
    }
}

/// Computes the current loop for the motor in the settings. Returns a [`Refusal`] if that cannot
/// be done.
pub fn current_loop(settings: &Settings) -> Result<CurrentLoop, Refusal> {
    let stage = Selected::POWER_STAGE;
    let config = Config::from_settings(settings, stage.pwm_hz / CONTROL_HZ);
    CurrentLoop::new(&config, &stage).map_err(|error| super::refuse("current loop", error))
}

/// Installs the current loop for the motor in the settings. Returns a [`Refusal`] if the loop
/// cannot be computed from them.
pub fn install_current_loop(settings: &Settings) -> Result<(), Refusal> {
    let mut current_loop = current_loop(settings)?;
    current_loop.set_sensing(calibration::sensing(settings));
    let (periods, wave) = cogging::stored(settings);
    current_loop.set_cogging(periods, wave);
    current_loop::install(current_loop);
    watchdog::require(Party::Pwm);
    Ok(())
}

/// What a drive measures on request: its motor, and the current that cancels the cogging torque.
pub struct Measurements {
    /// Calibration of the motor.
    pub calibrator: &'static mut Calibrator,
    /// Search for the current that cancels the cogging torque.
    pub cogging: &'static mut CoggingSearch,
}

impl Measurements {
    /// Creates the measurements in static variables: so they are neither copied into the task nor
    /// through the stack. Returns a [`Refusal`] if they were created before.
    pub fn create(settings: &Settings) -> Result<Self, Refusal> {
        static CALIBRATOR: StaticCell<Calibrator> = StaticCell::new();
        static COGGING: StaticCell<CoggingSearch> = StaticCell::new();
        let stage = &Selected::POWER_STAGE;
        let refused = || super::refuse("measurements", "they were created before");
        Ok(Self {
            calibrator: CALIBRATOR
                .try_init_with(|| Calibrator::new(settings, stage))
                .ok_or_else(refused)?,
            cogging: COGGING
                .try_init_with(|| CoggingSearch::new(settings))
                .ok_or_else(refused)?,
        })
    }

    /// Runs a tick of the calibration for the request of a client (object 0x2050). Returns how the
    /// calibration excites the motor; `None` if it has ended.
    #[inline(never)] // a new current loop takes stack that the other ticks do not need
    pub fn calibrate(
        &mut self,
        request: u8,
        axle: &mut Axle,
        inputs: &Inputs,
        outputs: &Outputs,
    ) -> Option<Excitation> {
        let disarmed =
            State::from_statusword(outputs.status.statusword) == Some(State::SwitchOnDisabled);
        let allowed =
            outputs.bench_mode && disarmed && outputs.faults.is_empty() && !storage::is_writing();
        let action = self.calibrator.tick(
            request,
            allowed,
            outputs.velocity,
            &calibrator::Inputs {
                encoder: inputs.encoder,
                supply_voltage: inputs.supply_voltage,
                measured: current_loop::take_measurement(inputs.supply_voltage),
            },
        );
        match action {
            Action::Excite(excitation) => Some(excitation),
            Action::Install(current_loop) => {
                current_loop::install(current_loop);
                axle.use_torque_constant(self.calibrator.settings());
                None
            }
            Action::None => None,
        }
    }

    /// Runs a tick of the search for the current that cancels the cogging torque.
    pub fn compensate(&mut self, requested: bool, axle: &Axle, inputs: &Inputs, outputs: &Outputs) {
        let found = self
            .cogging
            .tick(requested, inputs, outputs, axle.position());
        if let Some((periods, wave)) = found {
            current_loop::set_cogging(periods, wave);
        }
    }
}

/// Number of bytes in object 0x2063: the number of the window, and its samples.
const WINDOW_BYTES: usize = 2 + WINDOW * CHANNELS * 2;

/// Returns a window of the recording as object 0x2063 holds it.
pub fn window(number: u16) -> [u8; WINDOW_BYTES] {
    let mut bytes = [0; WINDOW_BYTES];
    let samples = current_loop::capture(|capture| capture.window(number));
    let [low, high, places @ ..] = &mut bytes;
    [*low, *high] = number.to_le_bytes();
    let values = samples.as_slice().as_flattened().as_flattened();
    for (place, value) in places.chunks_exact_mut(2).zip(values) {
        place.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// Defines the functions between one drive's generated dictionary and its tick. A drive calls
/// `publish_start` once; in each tick it calls `inputs`, runs its control core, and calls `finish`.
macro_rules! drive_objects {
    ($od:ident) => {
        use tautrack::node::axle::Axle;

        /// Writes what does not change, and the parameters at start, into the objects.
        fn publish_start(axle: &Axle) {
            use crate::boards::{Board, Selected};
            $od::OBJECT2010.set_value(axle.scale().code() | crate::storage::unconfigured_mark());
            $od::publish_parameters(&axle.parameters());
            let ratings = Selected::POWER_STAGE;
            $od::OBJECT2061.set_rate(ratings.pwm_hz);
            $od::OBJECT2061.set_full_scale((ratings.full_scale * 1e3) as u32);
            $od::OBJECT2061.set_period(ratings.period);
        }

        /// Puts the parameters in force that a client has written, and collects the inputs of one
        /// tick.
        fn inputs(axle: &mut Axle) -> tautrack::node::axle::Inputs {
            if let Some(parameters) = new_parameters() {
                axle.configure(&parameters);
            }
            axle.report(drive::HEARD.take_faults());
            drive::inputs(set_point, torque_offset, bench_mode())
        }

        /// Runs the measurements on request, lets the motor follow the outputs of a tick, and
        /// publishes them.
        #[inline(never)] // its stack is not that of the tick
        fn finish(
            measurements: &mut drive::Measurements,
            axle: &mut Axle,
            inputs: &tautrack::node::axle::Inputs,
            outputs: &tautrack::node::axle::Outputs,
            node: u8,
        ) {
            let excitation = calibrate(measurements, axle, inputs, outputs);
            compensate(measurements, axle, inputs, outputs);
            drive::act(outputs, node, excitation.as_ref());
            publish(outputs, inputs.bench_mode);
            if inputs.guard_received {
                // The guard's first heartbeat has restored them.
                $od::publish_parameters(&axle.parameters());
            }
            serve_capture();
        }

        /// Runs a tick of the calibration, if one is under way or requested. Returns how it excites
        /// the motor.
        fn calibrate(
            measurements: &mut drive::Measurements,
            axle: &mut Axle,
            inputs: &tautrack::node::axle::Inputs,
            outputs: &tautrack::node::axle::Outputs,
        ) -> Option<tautrack::motor::current::Excitation> {
            use tautrack::node::calibration::request;
            let requested = $od::OBJECT2050.get_value();
            if requested == request::NONE && !measurements.calibrator.is_running() {
                return None;
            }
            let excitation = measurements.calibrate(requested, axle, inputs, outputs);
            $od::publish_calibration(measurements.calibrator.report());
            if excitation.is_none() {
                $od::OBJECT2050.set_value(request::NONE);
            }
            excitation
        }

        /// Runs a tick of the search for the current that cancels the cogging torque, if one is
        /// under way or requested.
        fn compensate(
            measurements: &mut drive::Measurements,
            axle: &Axle,
            inputs: &tautrack::node::axle::Inputs,
            outputs: &tautrack::node::axle::Outputs,
        ) {
            let requested = $od::OBJECT2065.get_value() != 0;
            if !(requested || measurements.cogging.is_running()) {
                return;
            }
            measurements.compensate(requested, axle, inputs, outputs);
            $od::publish_cogging(measurements.cogging.report());
            if !measurements.cogging.is_running() {
                $od::OBJECT2065.set_value(0);
            }
        }

        /// Reads the set-point from the objects.
        fn set_point() -> tautrack::node::axle::SetPoint {
            use tautrack::bus::cia402::mode;
            let mode = $od::OBJECT6060.get_value();
            tautrack::node::axle::SetPoint {
                controlword: $od::OBJECT6040.get_value(),
                mode,
                target: match mode {
                    mode::CYCLIC_VELOCITY | mode::PROFILE_VELOCITY => $od::OBJECT60FF.get_value(),
                    mode::CYCLIC_TORQUE => $od::OBJECT6071.get_value().into(),
                    _ => $od::OBJECT607A.get_value(),
                },
            }
        }

        /// Reads the torque feed-forward from its object.
        fn torque_offset() -> i16 {
            $od::OBJECT60B2.get_value()
        }

        /// Reads the parameters from their objects, if a client has written one.
        fn new_parameters() -> Option<tautrack::bus::drive_parameters::DriveParameters> {
            drive::HEARD.take_parameters().then(|| {
                tautrack::bus::drive_parameters::DriveParameters {
                    quick_stop: $od::OBJECT605A.get_value(),
                    shutdown: $od::OBJECT605B.get_value(),
                    disable_operation: $od::OBJECT605C.get_value(),
                    halt: $od::OBJECT605D.get_value(),
                    fault_reaction: $od::OBJECT605E.get_value(),
                    following_window: $od::OBJECT6065.get_value(),
                    following_time: $od::OBJECT6066.get_value(),
                    position_window: $od::OBJECT6067.get_value(),
                    position_time: $od::OBJECT6068.get_value(),
                    position_limits: [$od::OBJECT607D.get_minimum(), $od::OBJECT607D.get_maximum()],
                    torque_slope: $od::OBJECT6087.get_value(),
                    homing_method: $od::OBJECT6098.get_value(),
                }
            })
        }

        /// Follows what a client has written to the objects of the recording, and publishes its
        /// state.
        fn serve_capture() {
            use crate::current_loop;
            if drive::HEARD.take_capture() {
                answer_capture();
            }
            let state = current_loop::capture(|capture| (capture.state(), capture.before()));
            if let Some((state, before)) = state {
                $od::OBJECT2061.set_state(state as u8);
                $od::OBJECT2061.set_before(before);
            }
        }

        /// Takes a client's request, and shows it the part of the recording that it wants.
        #[inline(never)] // a window takes stack that the other ticks do not need
        fn answer_capture() {
            use crate::current_loop;
            use tautrack::motor::capture::Request;
            let command = $od::OBJECT2060.get_command();
            if command != 0 {
                $od::OBJECT2060.set_command(0);
                current_loop::request_capture(Request {
                    command,
                    signals: $od::OBJECT2060.get_signals(),
                    decimation: $od::OBJECT2060.get_decimation(),
                    pre_trigger: $od::OBJECT2060.get_pre_trigger(),
                });
            }
            $od::OBJECT2063.set_value(drive::window($od::OBJECT2062.get_value()));
        }

        /// Whether a client requests bench mode.
        fn bench_mode() -> bool {
            $od::OBJECT2001.get_value() != 0
        }

        /// Writes the outputs of a tick into the objects, which the next SYNC sends. `bench_mode`
        /// is the request that this tick received.
        fn publish(outputs: &tautrack::node::axle::Outputs, bench_mode: bool) {
            if bench_mode && !outputs.bench_mode {
                $od::OBJECT2001.set_value(0);
            }
            $od::OBJECT1001.set_value(u8::from(outputs.status.error_code != 0));
            if let Some(snapshot) = &outputs.snapshot {
                $od::publish_snapshot(snapshot);
            }
            $od::publish_outputs(outputs);
        }
    };
}
pub(super) use drive_objects;

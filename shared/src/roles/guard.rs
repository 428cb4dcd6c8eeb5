//! The guard's node: the robot's body controller and stability filter, master of the CANopen
//! network, and inclinometer after CiA 410.

mod dead_man;

use super::guard_objects as objects;
use super::settings::{self, Store};
use crate::bus::network::{self, NmtState, function};
use crate::bus::node::{
    Abort, Address, Condition, Configuration, Core, Dictionary, Table, Value, Values,
};
use crate::bus::pdo::{GuardPosition, OperatorCommand};
use crate::bus::scale::{micro, milli_i32};
use crate::can::Frame;
use crate::estimate::state::{Estimator, State};
use crate::fault_log::{Circumstances, FaultLog};
use crate::node::guard::commissioning::request;
use crate::node::guard::{Guard, Inputs, ScaleMismatch};
use crate::robots::Body;
use crate::robots::b2p2::clearance::{Cause, Phase};
use crate::sensing::sensor_watch::SensorState;
use crate::sensors::{BodySensors, Sensor};
use crate::settings::Settings;
use crate::stability::balance::Telemetry;
use crate::stability::parameters::Refusal;
use crate::stability::trip::Snapshot;
use crate::units::Angle;
use core::ops::DerefMut;
use dead_man::DeadMan;
use heapless::Vec;

/// Code of the guard's highest state in which no drive is led up or holds for it.
const READY: u8 = 1;

/// Object of the operator's command, and the sub-index of its sequence number. A client that writes
/// the command's objects one by one writes the sequence number last, which completes the command.
const COMMAND: Address = Address {
    index: 0x4000,
    sub: 5,
};

/// Maximum number of frames between two ticks; a 1 Mbit/s bus carries fewer in 1 ms.
const MAX_RECEIVED: usize = 32;

/// Sensor chips on the robot's body: inertial unit, magnetometer, inclinometer.
pub const CHIPS: usize = 3;

/// What a board measures in one tick.
#[derive(Clone, Copy, Debug)]
pub struct Readings<'a> {
    /// Readings of the sensors on the robot's body, if there are new ones.
    pub body: Option<BodySensors>,
    /// Bytes from the serial line.
    pub serial: &'a [u8],
    /// The dead-man switch that is wired to the board is released.
    pub dead_man_released: bool,
    /// The emergency stop that is wired to the board is actuated.
    pub emergency_stop: bool,
    /// Code of the condition and number of errors of each sensor chip.
    pub chips: [(u8, u16); CHIPS],
}

/// What a tick has found, for the node's log.
#[derive(Clone, Copy, Debug, Default)]
pub struct Found {
    /// Error code of a fault, with the node that has it.
    pub fault: Option<(u16, u8)>,
    /// A drive whose position scale differs from the guard's.
    pub mismatch: Option<ScaleMismatch>,
    /// A trip.
    pub trip: Option<Snapshot>,
    /// Why the robot is not armed, if it has changed.
    pub refusal: Option<Refusal>,
    /// A sensor whose health has changed, with its new code.
    pub sensor: Option<(Sensor, u8)>,
    /// A new phase of an autonomous clearance, with its cause.
    pub clearance: Option<(Phase, Cause)>,
    /// The node is to restart: it has reset itself by the network management.
    pub restart: bool,
}

/// Node of a guard, which is at `G`, with the flash `S`.
pub struct Node<G, S> {
    core: Core,
    objects: Objects<S>,
    guard: G,
    id: u8,
    frames: Vec<Frame, MAX_RECEIVED>,
    /// A frame did not fit since the last tick.
    lost: bool,
    /// Sensor whose health is published next.
    sensor: usize,
    /// Step of commissioning that a client has requested last.
    step: u8,
    dead_man: DeadMan,
    serial: u32,
}

impl<B: Body, G: DerefMut<Target = Guard<B>>, S: Store> Node<G, S> {
    /// Creates the node; `serial` is the serial number of its board.
    pub fn new(settings: &Settings, mut guard: G, store: S, serial: u32) -> Self {
        if !store.found().is_whole() {
            guard.doubt_settings();
        }
        let configuration = Configuration {
            guard: None,
            ..super::configuration(settings)
        };
        Self {
            id: configuration.node_id,
            core: Core::new(configuration),
            objects: Objects {
                values: Values([0; objects::BYTES]),
                operator: false,
                armed: false,
                store,
            },
            guard,
            frames: Vec::new(),
            lost: false,
            sensor: 0,
            step: request::NONE,
            dead_man: DeadMan::default(),
            serial,
        }
    }

    /// Returns the state of the network management.
    pub fn state(&self) -> NmtState {
        self.core.state()
    }

    /// Returns the guard.
    pub fn guard(&self) -> &Guard<B> {
        &self.guard
    }

    /// Returns the history of faults.
    pub fn errors(&mut self) -> &mut FaultLog {
        self.core.errors()
    }

    /// Gives the objects their values at start, and sends the boot-up message.
    pub fn boot(&mut self, now_us: u64, send: &mut impl FnMut(Frame)) {
        let values = &mut self.objects.values;
        values.restart(objects::START);
        values.set(objects::OBJECT1018_SERIAL, self.serial);
        self.core.boot(now_us, &objects::TABLE, send);
    }

    /// Follows a frame from the bus.
    pub fn receive(&mut self, frame: &Frame, now_us: u64, send: &mut impl FnMut(Frame)) {
        self.core.receive(frame, now_us, &mut self.objects, send);
        self.keep(*frame);
    }

    /// Takes the condition of the CAN controller, before a tick.
    pub fn note_bus(&mut self, mut condition: Condition, send: &mut impl FnMut(Frame)) {
        condition.overrun |= core::mem::take(&mut self.lost);
        self.core.note_bus(condition, send);
    }

    /// Keeps a frame for the next tick. More than fit are lost: CANopen nodes repeat their values.
    fn keep(&mut self, frame: Frame) {
        self.lost |= self.frames.push(frame).is_err();
    }

    /// Runs one control tick.
    pub fn tick(
        &mut self,
        now_us: u64,
        readings: &Readings,
        send: &mut impl FnMut(Frame),
    ) -> Found {
        self.core.tick(now_us, &mut self.objects, send);
        let values = &self.objects.values;
        let came = core::mem::take(&mut self.objects.operator);
        let command = || OperatorCommand {
            forward: values.get(objects::OBJECT4000_FORWARD_SPEED),
            yaw_rate: values.get(objects::OBJECT4000_YAW_RATE),
            posture: values.get(objects::OBJECT4000_POSTURE),
            request: values.get(objects::OBJECT4000_REQUEST),
            sequence: values.get(objects::OBJECT4000_SEQUENCE),
        };
        let operator = self
            .dead_man
            .command(readings.dead_man_released, came, command);
        self.guard.tick(&Inputs {
            now_us,
            body: readings.body,
            operator,
            emergency_stop: values.get(objects::OBJECT4008) != 0 || readings.emergency_stop,
            frames: &self.frames,
            serial: readings.serial,
        });
        self.frames.clear();
        let mut found = self.publish(&readings.chips);
        self.send(now_us, send);
        found.restart = self.core.restarts();
        found
    }

    /// Writes what the tick has found into the objects, before its SYNC is sent.
    fn publish(&mut self, chips: &[(u8, u16); CHIPS]) -> Found {
        let mut found = Found::default();
        let (guard, values) = (&mut self.guard, &mut self.objects.values);
        let requested = values.get(objects::OBJECT2110);
        if requested != self.step {
            guard.commission(requested);
            self.step = requested;
        }
        if self.step != request::NONE {
            objects::publish_commissioning(values, guard.commissioning());
        }
        let outputs = guard.outputs();
        self.objects.armed = outputs.state.state > READY;
        let register = network::error_register(outputs.state.fault_code);
        values.set(objects::OBJECT1001, register);
        let clearance = &outputs.clearance;
        if clearance.transitions != values.get(objects::OBJECT4015_TRANSITIONS) {
            let phase = Phase::from_code(clearance.phase);
            found.clearance = phase.zip(Cause::from_code(clearance.cause));
        }
        objects::publish_outputs(values, outputs);
        if !outputs.frames.is_empty() {
            publish_balance(values, &guard.telemetry(), &mut found);
            // One sensor's turn comes in each SYNC period.
            if let Some(sensor) = Sensor::ALL.get(self.sensor) {
                let state = guard.sensor(*sensor);
                let changed = publish_sensor(values, *sensor, state);
                found.sensor = changed.then_some((*sensor, state.health));
            }
            self.sensor = (self.sensor + 1) % Sensor::ALL.len();
            for (chip, (condition, errors)) in chips.iter().enumerate() {
                values.set(objects::OBJECT2112.element(chip), *condition);
                values.set(objects::OBJECT2113.element(chip), *errors);
            }
        }
        if let Some((state, position)) = &outputs.robot {
            publish_robot(values, state, *position, guard.estimator());
        }
        if let Some(code) = outputs.emergency {
            found.fault = Some((code, outputs.state.fault_node));
            found.mismatch = guard.scale_mismatch();
            // Zeros if the scales agree.
            objects::publish_mismatch(values, &found.mismatch.unwrap_or_default());
        }
        found
    }

    /// Sends the frames of the tick. SYNC and commands of the network management concern the
    /// guard's node, too.
    fn send(&mut self, now_us: u64, send: &mut impl FnMut(Frame)) {
        let outputs = self.guard.outputs();
        if let Some(code) = outputs.emergency {
            self.core.report(code, &Circumstances::default(), send);
        }
        outputs.frames.iter().copied().for_each(&mut *send);
        for frame in &outputs.frames {
            match (frame.id(), frame.data()) {
                (function::NMT, &[command, node]) if node == 0 || node == self.id => {
                    self.core
                        .command(command, now_us, &objects::TABLE, &mut *send);
                }
                (function::NMT, _) => {}
                (function::SYNC_OR_EMERGENCY, _) => {
                    self.core.synchronize(now_us, &mut self.objects, send);
                }
                _ => continue,
            }
            let _ = self.frames.push(*frame);
        }
    }
}

/// The objects of the guard.
struct Objects<S> {
    values: Values<{ objects::BYTES }>,
    /// The operator's command has come since the last tick.
    operator: bool,
    /// A drive is led up or holds for the guard.
    armed: bool,
    store: S,
}

impl<S: Store> Dictionary for Objects<S> {
    fn table(&self) -> &'static Table {
        &objects::TABLE
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
        settings::write(&mut self.store, address, value, self.armed, false)
    }

    fn serves(&self, index: u16) -> bool {
        settings::serves(index)
    }

    fn moves(&self, _: u16) -> bool {
        false
    }

    fn check(&self, _: Address, _: &[u8]) -> Result<(), Abort> {
        Ok(())
    }

    fn written(&mut self, address: Address) {
        self.operator |= address == COMMAND;
    }

    fn lost_client(&mut self) {}

    fn may_restart(&self) -> bool {
        !self.armed
    }

    fn received(&mut self, _: u16, _: &[u32], _: u64) {
        self.operator = true;
    }
}

type Bytes = Values<{ objects::BYTES }>;

/// Writes the values that change once per SYNC and are read through SDO. Finds a new trip and a new
/// refusal to arm.
fn publish_balance(values: &mut Bytes, balance: &Telemetry, found: &mut Found) {
    let trips = values.get(objects::OBJECT4006_TRIPS);
    let code = values.get(objects::OBJECT4006_REFUSAL);
    objects::publish_balance(values, balance);
    found.refusal = balance.refusal.filter(|refusal| refusal.code() != code);
    found.trip = balance.snapshot.filter(|_| balance.trips != trips);
    if let Some(trip) = &found.trip {
        objects::publish_trip(values, trip);
    }
}

/// Writes health, rate and age of one sensor. Returns whether its health has changed.
fn publish_sensor(values: &mut Bytes, sensor: Sensor, state: SensorState) -> bool {
    let place = sensor as usize;
    let before = values.get(objects::OBJECT2100.element(place));
    values.set(objects::OBJECT2100.element(place), state.health);
    values.set(objects::OBJECT2101.element(place), state.rate);
    values.set(objects::OBJECT2102.element(place), state.age_ms);
    before != state.health
}

/// Writes the robot's state, once per SYNC.
fn publish_robot(
    values: &mut Bytes,
    state: &State,
    position: GuardPosition,
    estimator: &Estimator,
) {
    for (number, reading) in state.iter().enumerate() {
        let value = match number {
            // North, east and up in mm, the screw in um.
            0..=2 => milli_i32(reading.value),
            7 => micro(reading.value),
            _ => Angle::from_radians(reading.value).to_bits(),
        };
        // The arrays have as many elements as the state has coordinates.
        values.set(objects::OBJECT4010.element(number), value);
        values.set(objects::OBJECT4011.element(number), reading.validity as u8);
        values.set(objects::OBJECT4012.element(number), reading.age_ms);
    }
    objects::publish_estimator(values, estimator);
    objects::publish_position(values, &position);
}

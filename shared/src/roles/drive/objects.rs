//! The objects of a drive, between its bus and its control core.

use super::super::axle as objects;
use super::super::screw::{self, BYTES};
use super::super::settings::{self, Store};
use super::bench::Bench;
use super::heard::Heard;
use super::targets::{Circumstances, Memory, Targets};
use super::tuning::Tuning;
use super::{Motor, Readings};
use crate::bus::cia402::{CONTROL_FAULT_RESET, State, mode};
use crate::bus::drive_parameters::{self, DriveParameters};
use crate::bus::network;
use crate::bus::node::{Abort, Address, Dictionary, Table, Value, Values, number};
use crate::bus::pdo::DriveMotion;
use crate::bus::scale::UNCONFIGURED;
use crate::faults::Fault;
use crate::motor::bridge::Ratings;
use crate::motor::capture::{CHANNELS, Request, WINDOW};
use crate::motor::current::Electrical;
use crate::motor::shaft_sensor::Reading;
use crate::node::axle::{Axle, Inputs, Outputs, SetPoint};

/// Index of the torque feed-forward (CiA 402 calls it "torque offset"). It is sent less often than
/// set-points, and writing it does not count as a set-point.
const TORQUE_OFFSET: u16 = 0x60b2;

/// Interpolation time period: a number, and the power of ten of its unit.
const INTERPOLATION: u16 = 0x60c2;
const MILLISECONDS: i32 = -3;

/// The objects of a drive. Those of an axle have the same places in a screw, which has a few more.
pub(super) struct Objects<S> {
    pub values: Values<BYTES>,
    pub table: &'static Table,
    pub heard: Heard,
    pub targets: Memory,
    pub bench: Bench,
    pub tuning: Tuning,
    /// A setting was written that takes effect at once.
    pub retuned: bool,
    pub store: S,
    pub serial: u32,
    pub ratings: &'static Ratings,
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
        let live = match settings::setting(address) {
            Some(setting) => {
                let before = self.store.value(setting.bounds().key).unwrap_or_default();
                self.tuning.check(setting, before, number(value) as i32)?
            }
            None => false,
        };
        settings::write(&mut self.store, address, value, self.tuning.armed, live)?;
        self.retuned |= live;
        Ok(())
    }

    fn serves(&self, index: u16) -> bool {
        settings::serves(index)
    }

    fn moves(&self, index: u16) -> bool {
        let stays = is_capture(index) || settings::serves(index) || index == 0x2021;
        matches!(index, 0x1016 | 0x1400..=0x17ff | 0x2000..) && !stays
    }

    fn check(&self, address: Address, value: &[u8]) -> Result<(), Abort> {
        let signed = match *value {
            [byte] => i32::from(byte as i8),
            [low, high] => i16::from_le_bytes([low, high]).into(),
            [a, b, c, d] => i32::from_le_bytes([a, b, c, d]),
            _ => return Ok(()),
        };
        let period_ms = self.heard.sync_period_us / 1_000;
        let supported = match (address.index, address.sub) {
            // Set-points are interpolated over the period of SYNC.
            (INTERPOLATION, 1) => value == [period_ms as u8],
            (INTERPOLATION, _) => signed == MILLISECONDS,
            (index, _) => drive_parameters::supports(index, signed),
        };
        if supported { Ok(()) } else { Err(Abort::Range) }
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
        self.note_reset();
        self.heard.targets.add(Targets::of(address.index));
    }

    fn lost_client(&mut self) {
        self.heard.found.insert_if(Fault::GuardLost, true);
    }

    fn received(&mut self, id: u16, objects: &[u32], now_us: u64) {
        self.note_reset();
        for object in objects {
            self.heard.targets.add(Targets::of((object >> 16) as u16));
        }
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
    pub fn start(&mut self, axle: &Axle) {
        let (values, ratings) = (&mut self.values, self.ratings);
        values.restart(screw::START);
        values.set(objects::OBJECT1018_SERIAL, self.serial);
        let mark = if self.store.unconfigured() {
            UNCONFIGURED
        } else {
            0
        };
        values.set(objects::OBJECT2010, axle.scale().code() | mark);
        objects::publish_parameters(values, &axle.parameters());
        let period_ms = self.heard.sync_period_us / 1_000;
        values.set(objects::OBJECT60C2_PERIOD, period_ms as u8);
        values.set(objects::OBJECT2061_RATE, ratings.pwm_hz);
        let full_scale = (ratings.full_scale * 1e3) as u32;
        values.set(objects::OBJECT2061_FULL_SCALE, full_scale);
        values.set(objects::OBJECT2061_PERIOD, ratings.period);
    }

    /// Takes note of the bit of a fault reset. It may be gone again before the tick.
    fn note_reset(&mut self) {
        let word: u16 = self.values.get(objects::OBJECT6040);
        self.heard.reset |= word & CONTROL_FAULT_RESET != 0;
    }

    /// Forgets the targets that do not count any more.
    pub fn renew_targets(&mut self) {
        let written = core::mem::take(&mut self.heard.targets);
        self.targets.begin_tick(written, &mut self.values);
    }

    /// Collects the inputs of one tick.
    pub fn inputs(&mut self, readings: &Readings, now_us: u64) -> Inputs {
        let set_point = core::mem::take(&mut self.heard.set_point);
        let offset = core::mem::take(&mut self.heard.offset);
        let means = readings.means;
        Inputs {
            now_us,
            encoder: readings.encoder,
            encoder_broken: readings.encoder_broken,
            bridge_stop: readings.bridge_stop,
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

    fn set_point(&mut self) -> SetPoint {
        let mode = self.values.get(objects::OBJECT6060);
        let word: u16 = self.values.get(objects::OBJECT6040);
        let reset = core::mem::take(&mut self.heard.reset);
        let controlword = if reset {
            word | CONTROL_FAULT_RESET
        } else {
            word
        };
        // The bit that is gone again falls in the next tick.
        self.heard.set_point = controlword != word;
        SetPoint {
            controlword,
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

    pub fn parameters(&self) -> DriveParameters {
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
            profile_velocity: values.get(objects::OBJECT6081),
            profile_acceleration: values.get(objects::OBJECT6083),
            torque_slope: values.get(objects::OBJECT6087),
            homing_method: values.get(objects::OBJECT6098),
        }
    }

    /// Writes the outputs of a tick, which the next SYNC sends. While no guard is alive, every
    /// latched fault is the state "fault": so a client of CiA 402 sees and resets it. A living
    /// guard sees whether the axle holds.
    pub fn publish(&mut self, inputs: &Inputs, outputs: &Outputs, guarded: bool) {
        let values = &mut self.values;
        let set_point = inputs.set_point.is_some();
        let stands = self.bench.stands(outputs, set_point, guarded);
        if inputs.bench_mode && !stands {
            values.set(objects::OBJECT2001, 0);
        }
        let register = network::error_register(outputs.status.error_code);
        values.set(objects::OBJECT1001, register);
        if let Some(snapshot) = &outputs.snapshot {
            objects::publish_snapshot(values, snapshot);
        }
        objects::publish_outputs(values, outputs);
        // An axle has no such object.
        values.set(screw::OBJECT2101, outputs.belt_tension);
        if !guarded && !outputs.faults.is_empty() {
            let word = State::Fault.in_statusword(outputs.status.statusword);
            values.set(objects::OBJECT6041, word);
        }
        let state = State::from_statusword(outputs.status.statusword);
        let operating = state == Some(State::OperationEnabled);
        let circumstances = Circumstances {
            bench: outputs.bench_mode,
            guarded,
            faulty: !outputs.faults.is_empty(),
        };
        self.targets.end_tick(operating, circumstances, values);
    }

    /// Writes what is known of the sensor at the output shaft.
    pub fn publish_shaft(&mut self, reading: Reading) {
        let values = &mut self.values;
        values.set(objects::OBJECT206A, reading.condition as u8);
        values.set(objects::OBJECT206B, reading.errors);
        values.set(objects::OBJECT206C, reading.angle.to_bits());
    }

    /// Follows what a client has written to the objects of the recording, and publishes its state.
    pub fn serve_capture(&mut self, motor: &mut impl Motor) {
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

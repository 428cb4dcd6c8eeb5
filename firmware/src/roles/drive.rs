//! Common parts of the roles axle and screw: reads set-points from the object dictionary, writes
//! the state to it, and configures the current loop.

use super::Refusal;
use crate::boards::{Board, CONTROL_HZ, Selected};
use crate::bus::{self, Received};
use crate::current_loop;
use crate::watchdog::{self, Party};
use core::cell::Cell;
use core::sync::atomic::{AtomicBool, Ordering};
use critical_section::Mutex;
use embassy_time::Instant;
use tautrack::bus::network::{self, Emergency};
use tautrack::bus::pdo::{DriveMotion, receive};
use tautrack::constants::CONTROL_PERIOD;
use tautrack::motor::current::{Config, CurrentLoop, Electrical};
use tautrack::node::axle::{Inputs, Outputs, SetPoint};
use tautrack::settings::Settings;

/// Messages from the bus task that the control task has not read yet.
pub static HEARD: Mailbox = Mailbox {
    set_point: AtomicBool::new(false),
    offset: AtomicBool::new(false),
    guard: AtomicBool::new(false),
    joint: Mutex::new(Cell::new(None)),
    sync_us: Mutex::new(Cell::new(0)),
};

/// Index of the torque feed-forward (CiA 402 calls it "torque offset"). It is sent less often than
/// set-points, and writing it does not count as a set-point.
const TORQUE_OFFSET: u16 = 0x60b2;

/// Mailbox from the bus task to the control task, see [`HEARD`].
pub struct Mailbox {
    set_point: AtomicBool,
    offset: AtomicBool,
    guard: AtomicBool,
    joint: Mutex<Cell<Option<(DriveMotion, u64)>>>,
    sync_us: Mutex<Cell<u64>>,
}

impl Mailbox {
    /// Records the meaning of a received frame for a drive whose guard has the node id `guard`.
    /// Frames with the identifier `joint` carry the joint's motion and do not count as set-points.
    pub fn note(&self, received: &Received, guard: u8, joint: Option<u16>) {
        if network::is_sync(&received.frame) {
            critical_section::with(|cs| self.sync_us.borrow(cs).set(received.now_us));
        }
        if network::as_heartbeat(&received.frame).is_some_and(|(node, _)| node == guard) {
            self.guard.store(true, Ordering::Relaxed);
        }
        let offset = match received.sdo_index {
            Some(index) => index == TORQUE_OFFSET,
            None => received.frame.id() & !0x7f == receive(3),
        };
        if received.wrote && offset {
            self.offset.store(true, Ordering::Relaxed);
            return;
        }
        // Set-points come as process data, or from a client that writes single objects of the drive
        // profile (from 0x6000 on).
        if received.wrote
            && received.sdo_index.is_none_or(|index| index >= 0x6000)
            && joint != Some(received.frame.id())
        {
            self.set_point.store(true, Ordering::Relaxed);
        }
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

/// Collects the inputs of one tick. `set_point` and `torque_offset` read the objects; each is
/// called only if one of its objects was written since the last tick.
pub fn inputs(set_point: fn() -> SetPoint, torque_offset: fn() -> i16, bench_mode: bool) -> Inputs {
    let means = current_loop::take_means();
    if means.is_some() {
        watchdog::ran(Party::Pwm);
    }
    Inputs {
        now_us: Instant::now().as_micros(),
        encoder: Selected::encoder(),
        // NaN: without a sample the current is not known.
        current: means.map_or(f32::NAN, |means| means.current),
        electrical: means.map_or_else(Electrical::default, |means| means.electrical),
        supply_voltage: Selected::supply_voltage(),
        temperatures: Selected::temperatures(),
        switches: Selected::switches(),
        set_point: HEARD
            .set_point
            .swap(false, Ordering::Relaxed)
            .then(set_point),
        torque_offset: HEARD
            .offset
            .swap(false, Ordering::Relaxed)
            .then(torque_offset),
        guard_received: HEARD.guard.swap(false, Ordering::Relaxed),
        bench_mode,
    }
}

/// Passes the tick's demand to the PWM interrupt, and sends its emergency message on the bus.
pub fn act(outputs: &Outputs, node: u8) {
    current_loop::demand(outputs.bridge, Selected::supply_voltage(), outputs.velocity);
    watchdog::control_ran(Instant::now().as_micros());
    if let Some(code) = outputs.emergency {
        crate::logger::warn!("fault {:#06x}", code);
        bus::send(network::emergency(Emergency { node, code }));
    }
}

/// Installs the current loop for the motor in the settings. Returns a [`Refusal`] if the loop
/// cannot be computed from them.
pub fn install_current_loop(settings: &Settings) -> Result<(), Refusal> {
    let stage = Selected::POWER_STAGE;
    let config = Config::from_settings(settings, stage.pwm_hz / CONTROL_HZ);
    let current_loop = CurrentLoop::new(&config, &stage)
        .map_err(|error| super::refuse(format_args!("current loop: {error}")))?;
    current_loop::install(current_loop);
    watchdog::require(Party::Pwm);
    Ok(())
}

/// Defines the functions between one drive's generated dictionary and its tick: `set_point`,
/// `torque_offset`, `bench_mode` and `publish`.
macro_rules! drive_objects {
    ($od:ident) => {
        /// Reads the set-point from the objects.
        fn set_point() -> tautrack::node::axle::SetPoint {
            use tautrack::bus::cia402::mode::{CYCLIC_VELOCITY, PROFILE_VELOCITY};
            let mode = $od::OBJECT6060.get_value();
            let in_velocity = matches!(mode, CYCLIC_VELOCITY | PROFILE_VELOCITY);
            tautrack::node::axle::SetPoint {
                controlword: $od::OBJECT6040.get_value(),
                mode,
                target: if in_velocity {
                    $od::OBJECT60FF.get_value()
                } else {
                    $od::OBJECT607A.get_value()
                },
            }
        }

        /// Reads the torque feed-forward from its object.
        fn torque_offset() -> i16 {
            $od::OBJECT60B2.get_value()
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

//! What axle and screw share: settings of the motor, the set-point out of the objects, the state into them.

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
use tautrack::motor::current::{CurrentLoop, Winding};
use tautrack::node::axle::{Inputs, Outputs, SetPoint};
use tautrack::settings::{Setting, Settings};

/// What the bus task received since the control task last looked.
pub static HEARD: Mailbox = Mailbox {
    set_point: AtomicBool::new(false),
    offset: AtomicBool::new(false),
    guard: AtomicBool::new(false),
    joint: Mutex::new(Cell::new(None)),
    sync_us: Mutex::new(Cell::new(0)),
};

/// Object that does not count as a set-point: it comes more seldom, and none begins with it.
const TORQUE_OFFSET: u16 = 0x60b2;

/// See [`HEARD`].
pub struct Mailbox {
    set_point: AtomicBool,
    offset: AtomicBool,
    guard: AtomicBool,
    joint: Mutex<Cell<Option<(DriveMotion, u64)>>>,
    sync_us: Mutex<Cell<u64>>,
}

impl Mailbox {
    /// Notes what a frame means to any drive with the master `guard`; frames of the joint with identifier `joint` are
    /// not set-points.
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
        // Set-points come by process data, or from a client that writes objects of the drive profile one by one.
        if received.wrote
            && received.sdo_index.is_none_or(|index| index >= 0x6000)
            && joint != Some(received.frame.id())
        {
            self.set_point.store(true, Ordering::Relaxed);
        }
    }

    /// Keeps the joint's motion. It was measured in the control period before the SYNC that every node received at once.
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

    /// The joint's motion, if it came.
    pub fn take_joint(&self) -> Option<(DriveMotion, u64)> {
        critical_section::with(|cs| self.joint.borrow(cs).take())
    }
}

/// Inputs of one tick; `set_point` and `torque_offset` read the objects, and are asked only when one of theirs was written.
pub fn inputs(set_point: fn() -> SetPoint, torque_offset: fn() -> i16, bench_mode: bool) -> Inputs {
    let current = current_loop::take_mean();
    if current.is_some() {
        watchdog::ran(Party::Pwm);
    }
    Inputs {
        now_us: Instant::now().as_micros(),
        encoder: Selected::encoder(),
        // Without a sample nothing is known of the current.
        current: current.unwrap_or(f32::NAN),
        supply_voltage: Selected::supply_voltage(),
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

/// Hands the tick's demand to the PWM interrupt, and its emergency to the bus.
pub fn act(outputs: &Outputs, node: u8) {
    current_loop::demand(outputs.bridge);
    watchdog::control_ran(Instant::now().as_micros());
    if let Some(code) = outputs.emergency {
        crate::logger::warn!("fault {:#06x}", code);
        bus::send(network::emergency(Emergency { node, code }));
    }
}

/// Makes the current loop of the motor in the settings.
pub fn install_current_loop(settings: &Settings) -> Result<(), Refusal> {
    let winding = Winding {
        resistance: settings.scaled(Setting::Resistance, 1e-3),
        inductance: settings.scaled(Setting::Inductance, 1e-6),
        current_limit: settings.scaled(Setting::CurrentLimit, 1e-3),
    };
    let bandwidth = settings.scaled(Setting::CurrentBandwidth, 1.0);
    let current_loop = CurrentLoop::new(&winding, bandwidth, Selected::PWM_HZ as f32)
        .map_err(|error| super::refuse(format_args!("current loop: {error}")))?;
    current_loop::install(current_loop, Selected::PWM_HZ / CONTROL_HZ);
    watchdog::require(Party::Pwm);
    Ok(())
}

/// `set_point` and `publish` for the objects of one drive's generated dictionary.
macro_rules! drive_objects {
    ($od:ident) => {
        /// The set-point as the objects hold it.
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

        /// The torque offset as its object holds it.
        fn torque_offset() -> i16 {
            $od::OBJECT60B2.get_value()
        }

        /// Whether a client asks for bench mode.
        fn bench_mode() -> bool {
            $od::OBJECT2001.get_value() != 0
        }

        /// The outputs of a tick as objects; the next SYNC sends them. `bench_mode`: what was asked
        /// for in this tick.
        fn publish(outputs: &tautrack::node::axle::Outputs, bench_mode: bool) {
            if bench_mode && !outputs.bench_mode {
                $od::OBJECT2001.set_value(0);
            }
            $od::OBJECT1001.set_value(u8::from(outputs.status.error_code != 0));
            $od::publish_outputs(outputs);
        }
    };
}
pub(super) use drive_objects;

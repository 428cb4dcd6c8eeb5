//! The node of each role.

use super::{Board, Outbox};
use crate::boards::lockstep::{Flash, POWER_STAGE};
use crate::refusal::{Refusal, refuse};
use crate::sensors::Rates;
use crate::storage::{Check, Storage};
use crate::{check, log_lines};
use std::boxed::Box;
use tautrack::bus::node::Table;
use tautrack::can::Frame;
use tautrack::node::axle::Axle;
use tautrack::node::guard::Guard;
use tautrack::node::screw::Screw;
use tautrack::robots::Body;
use tautrack::roles::drive::{Control, Drive, Measurements, Motor, Parts};
use tautrack::roles::{axle, guard, guard_objects, screw};
use tautrack::settings::Settings;

/// Maximum number of bytes from the serial line in one tick.
const MAX_SERIAL: usize = 64;

/// Kind of node.
pub struct Role {
    /// Name of the role.
    pub name: &'static str,
    /// Its objects.
    pub(super) table: &'static Table,
    /// Returns a [`Refusal`] if [`Self::create`] would refuse these settings.
    pub(super) check: Check,
    /// Creates the node on its board.
    pub(super) create: Create,
}

type Create = fn(&Settings, Storage<Flash>, &mut Board) -> Result<Box<dyn Device>, Refusal>;

/// A running node.
pub(super) trait Device {
    /// Sends the boot-up message.
    fn boot(&mut self, now_us: u64, outbox: &mut Outbox);
    /// Follows a frame from the bus.
    fn receive(&mut self, frame: &Frame, now_us: u64, outbox: &mut Outbox);
    /// Runs one control tick. Returns whether the node is to restart.
    fn tick(&mut self, now_us: u64, board: &mut Board) -> bool;
}

/// The role `axle`.
pub static AXLE: Role = Role {
    name: "axle",
    table: &axle::TABLE,
    check: check::axle,
    create: |settings, storage, board| {
        let control = Axle::new(settings);
        let parts = parts(settings, control, storage, board)?;
        Ok(Box::new(Drive::axle(parts)))
    },
};

/// The role `screw`.
pub static SCREW: Role = Role {
    name: "screw",
    table: &screw::TABLE,
    check: check::screw,
    create: |settings, storage, board| {
        let control =
            Screw::new(settings).map_err(|error| refuse("geometry", format_args!("{error:?}")))?;
        let parts = parts(settings, control, storage, board)?;
        Ok(Box::new(Drive::screw(parts)))
    },
};

/// The role `guard` of a robot.
pub const fn guard<B: Body + 'static>() -> Role {
    Role {
        name: "guard",
        table: &guard_objects::TABLE,
        check: check::guard::<B>,
        create: |settings, storage, board| {
            let guard = Guard::<B>::new(settings)
                .map_err(|error| refuse("robot", format_args!("{error:?}")))?;
            board.body.start(Rates::new(settings));
            let (guard, serial) = (Box::new(guard), board.serial_number);
            Ok(Box::new(guard::Node::new(settings, guard, storage, serial)))
        },
    }
}

/// Installs the current loop. Returns what the node of a drive is made of.
fn parts<'a, C>(
    settings: &'a Settings,
    control: C,
    store: Storage<Flash>,
    board: &mut Board,
) -> Result<Parts<'a, C, Measurements, Storage<Flash>>, Refusal> {
    board.motor.install(check::current_loop(settings)?);
    Ok(Parts {
        settings,
        control,
        measurements: Measurements::new(settings, &POWER_STAGE),
        store,
        serial: board.serial_number,
        ratings: &POWER_STAGE,
    })
}

impl<C: Control> Device for Drive<C, Measurements, Storage<Flash>> {
    fn boot(&mut self, now_us: u64, outbox: &mut Outbox) {
        Self::boot(self, now_us, &mut |frame| outbox.push(frame));
    }

    fn receive(&mut self, frame: &Frame, now_us: u64, outbox: &mut Outbox) {
        Self::receive(self, frame, now_us, &mut |frame| outbox.push(frame));
    }

    fn tick(&mut self, now_us: u64, board: &mut Board) -> bool {
        let Board { motor, outbox, .. } = board;
        let ticked = Self::tick(self, now_us, motor, &mut |frame| outbox.push(frame));
        log_lines::drive(ticked);
        ticked.restart
    }
}

impl<B: Body> Device for guard::Node<Box<Guard<B>>, Storage<Flash>> {
    fn boot(&mut self, now_us: u64, outbox: &mut Outbox) {
        Self::boot(self, now_us, &mut |frame| outbox.push(frame));
    }

    fn receive(&mut self, frame: &Frame, now_us: u64, outbox: &mut Outbox) {
        Self::receive(self, frame, now_us, &mut |frame| outbox.push(frame));
    }

    fn tick(&mut self, now_us: u64, board: &mut Board) -> bool {
        let Board { body, outbox, .. } = board;
        let serial = body.take_serial(MAX_SERIAL);
        let readings = guard::Readings {
            body: body.published.newest.take(),
            serial: &serial,
            dead_man_released: false,
            emergency_stop: false,
            chips: body.published.conditions.codes(),
        };
        let send = &mut |frame| outbox.push(frame);
        let found = Self::tick(self, now_us, &readings, send);
        log_lines::guard(&found);
        found.restart
    }
}

//! Counts the instructions that a node takes for one frame, with the axle's objects.

use super::counter::Table;
use super::inputs::settings;
use crate::boards::{Board, Selected};
use crate::check;
use crate::roles::drive::BoardMotor;
use crate::storage::Storage;
use tautrack::bus::network::{NmtCommand, nmt, sync};
use tautrack::bus::pdo::{DriveMotion, Payload, transmit};
use tautrack::can::Frame;
use tautrack::node::axle::Axle;
use tautrack::roles::drive::{Drive, Measurements, Parts};
use tautrack::roles::settings::Found;
use tautrack::settings::Setting;

pub fn count(table: &mut Table) -> Option<()> {
    let settings = settings(&[])?;
    let node = settings.id(Setting::NodeId);
    let ratings = &Selected::POWER_STAGE;
    let mut drive = Drive::axle(Parts {
        settings: &settings,
        control: Axle::new(&settings),
        measurements: Measurements::new(&settings, ratings),
        store: Storage::new(
            &settings,
            Found::default(),
            check::axle,
            Selected::storage(),
        ),
        serial: 1,
        ratings,
    });
    let mut send = |_: Frame| ();
    drive.boot(0, &mut send);
    drive.receive(&nmt(NmtCommand::Start, 0), 1, &mut send);

    let motion = DriveMotion {
        position: 1_000,
        velocity: 0,
    };
    let foreign = motion.frame(transmit(1), node % 4 + 1);
    // Reads the position (object 6064h), like a client that polls it.
    let read = Frame::new(0x600 + u16::from(node), &[0x40, 0x64, 0x60, 0, 0, 0, 0, 0])?;
    for (name, frame) in [
        ("bus: SYNC", sync()),
        ("bus: another node's frame", foreign),
        ("bus: object read", read),
    ] {
        table.kernel(
            name,
            &mut (&mut drive, frame, 0),
            |(drive, _, now_us), call, _| {
                *now_us = u64::from(call + 2) * 1_000;
                // Without control ticks, the node does not answer a SYNC.
                drive.tick(*now_us, &mut BoardMotor, &mut |_| ());
            },
            |(drive, frame, now_us)| {
                drive.receive(frame, *now_us, &mut |frame| {
                    core::hint::black_box(frame);
                });
            },
        )?;
    }
    Some(())
}

//! Counts the instructions that filter and CANopen stack take for one frame, with the axle's
//! dictionary.

use super::counter::Table;
use super::inputs::settings;
use crate::bus::{Bus, TRANSMIT};
use crate::roles::axle::DICTIONARY;
use crate::watchdog;
use tautrack::bus::network::{NmtCommand, nmt, sync};
use tautrack::bus::pdo::{DriveMotion, Payload, transmit};
use tautrack::can::Frame;
use tautrack::settings::Setting;

pub fn count(table: &mut Table) -> Option<()> {
    let node = settings(&[])?.id(Setting::NodeId);
    let mut bus = Bus::new(DICTIONARY, node, 50, None, None, |_| true)?;
    bus.process(0);
    bus.receive(nmt(NmtCommand::Start, 0), 1);

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
            &mut (&mut bus, frame, 0),
            |(_, _, now_us), call, _| {
                while TRANSMIT.pop().is_some() {}
                *now_us = u64::from(call + 2) * 1_000;
                // Without a running control task, the node does not answer a SYNC.
                watchdog::control_ran(*now_us);
            },
            |(bus, frame, now_us)| {
                bus.receive(*frame, *now_us);
            },
        )?;
    }
    Some(())
}

//! Counts the instructions that filter and CANopen stack take for one frame, with the axle's
//! dictionary.

use super::counter::Table;
use super::inputs::settings;
use crate::bus::{Bus, TRANSMIT};
use crate::roles::axle::DICTIONARY;
use crate::watchdog;
use tautrack::bus::network::{NmtCommand, nmt, sync};
use tautrack::bus::pdo::{DriveMotion, Payload, PositionSetPoint, receive, transmit};
use tautrack::can::Frame;
use tautrack::settings::Setting;

const SDO_REQUEST: u16 = 0x600;

pub fn count(table: &mut Table) {
    let node = settings().id(Setting::NodeId);
    let Some(mut bus) = Bus::new(DICTIONARY, node, 50, None, None) else {
        return; // the nominal node id is valid; otherwise the host finds no entries
    };
    bus.process(0);
    bus.receive(nmt(NmtCommand::Start, 0), 1);

    let set_point = move |call: u32| {
        PositionSetPoint {
            controlword: 0x0f,
            mode: 8,
            target: call as i32 * 1_000,
        }
        .frame(receive(1), node)
    };
    let foreign = move |call: u32| {
        DriveMotion {
            position: call as i32,
            velocity: 0,
        }
        .frame(transmit(1), (call % 5) as u8 + 1)
    };
    // Reads the position (object 6064h), like a client that polls it.
    let read = move |_| {
        Frame::new(
            SDO_REQUEST + u16::from(node),
            &[0x40, 0x64, 0x60, 0, 0, 0, 0, 0],
        )
        .unwrap_or_default()
    };
    count_frames(table, &mut bus, "bus: set-point", set_point);
    count_frames(table, &mut bus, "bus: SYNC", |_| sync());
    count_frames(table, &mut bus, "bus: another node's frame", foreign);
    count_frames(table, &mut bus, "bus: object read", read);
}

fn count_frames(table: &mut Table, bus: &mut Bus, name: &str, frame: impl Fn(u32) -> Frame) {
    let mut now_us = 1_000;
    table.kernel(
        name,
        bus,
        |_, call, _| {
            while TRANSMIT.pop().is_some() {}
            now_us += 1_000;
            // Without a running control task, the node does not answer a SYNC.
            watchdog::control_ran(now_us);
            (frame(call), now_us)
        },
        |bus, (frame, now_us)| {
            bus.receive(frame, now_us);
        },
    );
}

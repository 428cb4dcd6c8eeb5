//! Errors of the bus: nobody acknowledges, a short, more frames than the receive FIFO holds.

use crate::chip::{BUS_OFF, CAN_ERRORS, CAN_STATUS, Chip, PASSIVE, Wiring};
use crate::executed::{NODE, armed_axle, frame, read, running_axle, write};
use crate::stamp;
use crate::{checks, guard};
use tautrack::can::Frame;

/// Time between two heartbeats, us.
const HEARTBEAT_US: u64 = 50_000;

/// Node ids, and the chips: an axle and a guard.
fn nodes() -> [(u16, Chip); 2] {
    [
        (NODE, running_axle()),
        (guard::NODE, guard::running_guard()),
    ]
}

/// Number of heartbeats that the chip has sent since the last call.
fn heartbeats(chip: &mut Chip, node: u16) -> usize {
    let sent = chip.take_sent();
    let heartbeats = sent.iter().filter(|(_, it)| it.id() == 0x700 + node);
    heartbeats.count()
}

#[test]
pub fn a_node_that_is_alone_on_the_bus_gets_passive_and_goes_on_running() {
    let Some(_stamp) = stamp("a_node_that_is_alone_on_the_bus_gets_passive_and_goes_on_running")
    else {
        return;
    };
    for (node, mut chip) in nodes() {
        chip.wire(Wiring::Alone);
        chip.take_sent();
        chip.run(500_000);
        assert_eq!(chip.take_sent(), []);
        assert_eq!(chip.register(CAN_ERRORS) & 0xff, 128);
        assert_eq!(chip.register(CAN_STATUS) & (PASSIVE | BUS_OFF), PASSIVE);
        chip.wire(Wiring::Good);
        chip.run(2 * HEARTBEAT_US);
        assert!(heartbeats(&mut chip, node) > 0);
        checks::read(&mut chip, node, 0x1000, 0);
        assert_eq!(chip.resets(), 0);
    }
}

#[test]
pub fn a_node_recovers_from_bus_off_by_itself() {
    let Some(_stamp) = stamp("a_node_recovers_from_bus_off_by_itself") else {
        return;
    };
    for (node, mut chip) in nodes() {
        chip.wire(Wiring::Shorted);
        let mut states = Vec::new();
        for _ in 0..2_000 {
            chip.run(250);
            states.push(chip.register(CAN_STATUS) & BUS_OFF != 0);
        }
        states.dedup();
        // Off and on again, as long as the short lasts.
        assert!(states.len() > 10, "{states:?}");
        // The short ends while the node is off. Otherwise the node may still be passive: its error
        // count falls by one for each frame that it sends.
        while chip.register(CAN_STATUS) & BUS_OFF == 0 {
            chip.run(250);
        }
        chip.wire(Wiring::Good);
        chip.run(2 * HEARTBEAT_US);
        assert_eq!(chip.register(CAN_STATUS) & (PASSIVE | BUS_OFF), 0);
        let sent = chip.take_sent();
        // CiA 301: recovered from bus-off, an error of communication.
        let recovered = [0x40, 0x81, 0x11, 0, 0, 0, 0, 0];
        let has = |id: u16, data: &[u8]| {
            sent.iter()
                .any(|(_, it)| it.id() == id && it.data() == data)
        };
        assert!(has(0x080 + node, &recovered), "node {node}");
        assert!(sent.iter().any(|(_, it)| it.id() == 0x700 + node));
        checks::read(&mut chip, node, 0x1000, 0);
        assert_eq!(chip.resets(), 0);
    }
}

#[test]
pub fn frames_that_waited_for_the_bus_for_long_are_not_sent() {
    let Some(_stamp) = stamp("frames_that_waited_for_the_bus_for_long_are_not_sent") else {
        return;
    };
    for wiring in [Wiring::Alone, Wiring::Shorted] {
        for (node, mut chip) in nodes() {
            chip.wire(wiring);
            // 20 heartbeats wait.
            chip.run(20 * HEARTBEAT_US);
            chip.take_sent();
            chip.wire(Wiring::Good);
            chip.run(HEARTBEAT_US - 5_000);
            let sent = heartbeats(&mut chip, node);
            assert!(sent <= 2, "{wiring:?}: {sent} heartbeats in one period");
            assert_eq!(chip.resets(), 0, "{wiring:?}");
        }
    }
}

#[test]
pub fn a_drive_holds_when_its_bus_is_gone_and_reports_it_afterwards() {
    let Some(_stamp) = stamp("a_drive_holds_when_its_bus_is_gone_and_reports_it_afterwards") else {
        return;
    };
    let mut chip = armed_axle();
    chip.wire(Wiring::Shorted);
    chip.run(200_000);
    chip.wire(Wiring::Good);
    chip.run(20_000);
    // The fault "command lost".
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0x8250);
    // CiA 402: the state is not "operation enabled".
    let status = read(&mut chip, 0x6041);
    println!("statusword {status:#06x}, live {}", chip.is_live());
    assert_eq!(chip.resets(), 0);
    // A fault reset clears it.
    write(&mut chip, 0x6040, 0, &[0x80, 0]);
    chip.run(5_000);
    assert_eq!(read(&mut chip, 0x603f) & 0xffff, 0);
}

#[test]
pub fn no_frame_is_lost_on_a_bus_without_a_pause() {
    let Some(_stamp) = stamp("no_frame_is_lost_on_a_bus_without_a_pause") else {
        return;
    };
    let mut chip = armed_axle();
    let others = (0..2_000).map(|n: u16| match n % 4 {
        0 => frame(0x080, &[]),
        1 => frame(0x180 + n % 100, &n.to_le_bytes().repeat(4)),
        2 => frame(0x280 + n % 100, &n.to_le_bytes().repeat(2)),
        _ => frame(0x700 + n % 100, &[5]),
    });
    let others: Vec<Frame> = others.collect();
    chip.burst(others);
    chip.run(200_000);
    assert_eq!(chip.lost_frames(), 0);
    assert_eq!(chip.resets(), 0);
    read(&mut chip, 0x6041);
}

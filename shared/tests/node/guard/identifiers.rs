//! Tests with a program that sends frames of a drive besides the drive itself.

use super::bench::{Bench, DRIVES, JOINT, SCREW};
use tautrack::bus::cia402::State as DriveState;
use tautrack::bus::pdo::{DriveMotion, Payload, transmit};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::node::guard::State;

/// Returns in which of 100 ticks the guard reports a second node with the id of this drive.
fn reported(bench: &mut Bench, id: u8, mut forge: impl FnMut(&mut Bench, u64)) -> Option<u64> {
    (0..100).find(|tick| {
        forge(bench, *tick);
        let outputs = bench.tick();
        let named = (outputs.state.fault_node, outputs.state.fault_code);
        named == (id, Fault::DuplicateNode.code())
    })
}

/// Whatever the forger's position and phase, also if it says what the drive says.
#[test]
fn forged_motions_of_any_drive_are_reported_within_20_ms() {
    for id in DRIVES {
        for phase in 0..4 {
            for position in [0, 700_000_000] {
                let mut bench = Bench::armed();
                let found = reported(&mut bench, id, |bench, tick| {
                    if tick % 4 == phase {
                        let velocity = if position == 0 { 0 } else { i32::MAX };
                        let forged = DriveMotion { position, velocity };
                        bench.extra.push(forged.frame(transmit(1), id));
                    }
                });
                assert!(
                    found.is_some_and(|tick| tick <= 20),
                    "{id} {phase} {position}: {found:?}"
                );
            }
        }
    }
}

/// The drive is silent, and another node sends its motion instead, from another place.
#[test]
fn a_position_that_jumps_is_reported_at_once() {
    for (id, step) in [
        (2, 4_000),
        (3, -4_000),
        (JOINT, 200_000_000),
        (SCREW, 100_000),
    ] {
        let mut bench = Bench::armed();
        bench.run(100);
        let at = if id == SCREW { bench.screw } else { 0 };
        bench.silent = Some(id);
        let found = reported(&mut bench, id, |bench, _| {
            if bench.next_is(4_000) {
                let position = at + step;
                let forged = DriveMotion {
                    position,
                    velocity: 0,
                };
                bench.extra.push(forged.frame(transmit(1), id));
            }
        });
        assert!(found.is_some_and(|tick| tick < 8), "{id}: {found:?}");
    }
}

#[test]
fn forged_heartbeats_of_any_drive_are_reported_within_20_ms_whatever_their_phase_is() {
    for id in DRIVES {
        for phase in 0..50 {
            let mut bench = Bench::armed();
            while !bench.next_is(50_000) {
                bench.tick();
            }
            bench.run(1 + phase);
            let found = reported(&mut bench, id, |bench, tick| {
                if tick % 50 == 0 {
                    bench.extra.extend(Frame::new(0x700 + u16::from(id), &[5]));
                }
            });
            assert!(
                found.is_some_and(|tick| tick <= 20),
                "{id} {phase}: {found:?}"
            );
        }
    }
}

/// Motions that come late by up to two SYNC periods, and then together.
#[test]
fn motions_that_come_late_are_those_of_one_drive() {
    for late in 1..=2_usize {
        let mut bench = Bench::armed();
        bench.silent = Some(2);
        let mut kept = Vec::new();
        for turn in 0..200 {
            if bench.next_is(50_000) {
                bench.extra.extend(Frame::new(0x702, &[5]));
            }
            if bench.next_is(4_000) {
                kept.push(DriveMotion::default().frame(transmit(1), 2));
                let statusword = DriveState::OperationEnabled.statusword();
                let status = tautrack::bus::pdo::DriveStatus {
                    statusword,
                    ..Default::default()
                };
                bench.extra.push(status.frame(transmit(2), 2));
            }
            if turn % 40 == 0 || kept.len() >= late {
                bench.extra.append(&mut kept);
            }
            bench.tick();
        }
        let state = State::from_code(bench.guard.outputs().state.state);
        assert_eq!(state, Some(State::Armed), "late by {late}");
    }
}

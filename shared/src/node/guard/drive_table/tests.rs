//! Tests of the drives of B2P2 together: who is complete, who has a fault, who else is a master.

use super::*;
use crate::bus::network::{NmtCommand, nmt, sync};
use crate::bus::pdo::Payload;
use crate::bus::pdo::{DriveMotion, DriveStatus, transmit};
use crate::robots::b2p2::B2p2;

/// Node ids of the default settings: two tracks, joint, screw; and the guard's.
const IDS: [u8; 4] = [2, 3, 4, 5];

fn drives() -> Drives {
    let mut settings = Settings::default();
    let key = Setting::NodeId.description().key;
    settings.set(key, 1).unwrap();
    Drives::new::<B2p2>(&settings)
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).expect("a frame")
}

/// Answer of a drive with its scale.
fn scale(drives: &Drives, index: usize) -> Frame {
    let [low, high] = drives.expected_scales[index].to_le_bytes();
    let id = SDO_RESPONSE + u16::from(IDS[index]);
    let [object_low, object_high] = super::super::POSITION_SCALE.to_le_bytes();
    frame(id, &[0x4b, object_low, object_high, 0, low, high, 0, 0])
}

#[test]
fn the_drives_are_complete_with_every_heartbeat_and_every_scale() {
    for missing in 0..9 {
        let mut drives = drives();
        assert!(!drives.complete() && !drives.have_status());
        // The guard takes an answer only to its own request.
        assert_eq!(drives.scale_requests(0).count(), 4);
        for (index, id) in IDS.into_iter().enumerate() {
            if missing != index {
                let heartbeat = frame(0x700 + u16::from(id), &[5]);
                drives.receive(&heartbeat, 1_000);
            }
            if missing != index + 4 {
                let answer = scale(&drives, index);
                drives.receive(&answer, 1_000);
            }
        }
        assert_eq!(drives.complete(), missing == 8, "{missing}");
        assert_eq!(drives.mismatch(), None);
    }
}

#[test]
fn the_status_of_every_drive_is_needed() {
    let mut drives = drives();
    for id in IDS {
        assert!(!drives.have_status());
        drives.receive(&DriveStatus::default().frame(transmit(2), id), 1_000);
    }
    assert!(drives.have_status());
}

#[test]
fn odometry_is_as_old_as_its_oldest_track() {
    for (left, right) in [(1_000, 2_000), (2_000, 1_000), (1_500, 1_500)] {
        let mut drives = drives();
        assert_eq!(drives.odometry_us::<B2p2>(), None);
        for (id, now_us) in [(2, left), (3, right), (4, 10)] {
            drives.receive(&DriveMotion::default().frame(transmit(1), id), now_us);
            if id == 2 {
                assert_eq!(drives.odometry_us::<B2p2>(), None);
            }
        }
        assert_eq!(drives.odometry_us::<B2p2>(), Some(left.min(right)));
    }
}

/// Identifiers of CiA 301 that the guard (node 1) or a master uses.
#[test]
fn a_frame_that_only_the_guard_may_send_names_a_second_master() {
    let node = |id: u16| {
        let mut drives = drives();
        drives.receive(&frame(id, &[]), 1_000);
        drives.fault(1_000, false).map(|report| {
            assert_eq!(report.code, Fault::SecondMaster.code());
            report.node
        })
    };
    for id in [0x000, 0x080] {
        assert_eq!(node(id), Some(0), "{id:#x}: SYNC or network management");
    }
    for id in [0x081, 0x181, 0x281, 0x381, 0x481, 0x701] {
        assert_eq!(node(id), Some(1), "{id:#x}: the guard's own");
    }
    for drive in IDS {
        for function in [0x200, 0x300, 0x400, 0x500] {
            let id = function + u16::from(drive);
            assert_eq!(node(id), Some(drive), "{id:#x}: a set-point");
        }
        for function in [0x080, 0x180, 0x280, 0x580, 0x600, 0x700] {
            // An emergency without content is none.
            let id = function + u16::from(drive);
            assert_eq!(node(id), None, "{id:#x}: the drive's own");
        }
    }
    for id in [0x201, 0x301, 0x581, 0x601, 0x209, 0x189, 0x709] {
        assert_eq!(node(id), None, "{id:#x}");
    }
}

#[test]
fn the_guard_s_own_frames_come_back_once_each() {
    let (own_sync, own_start) = (sync(), nmt(NmtCommand::Start, 0));
    // Two may be on their way back, and no more.
    for (sent, with_start, received, foreign) in [
        (1, false, 1, false),
        (1, false, 2, true),
        (2, false, 2, false),
        (2, true, 2, false),
        (5, true, 2, false),
        (5, true, 3, true),
    ] {
        for frame in [&own_sync, &own_start] {
            let mut drives = drives();
            for _ in 0..sent {
                drives.note_sent(with_start);
            }
            for _ in 0..received {
                drives.receive(frame, 1_000);
            }
            let expected = foreign || (frame == &own_start && !with_start);
            assert_eq!(
                drives.fault(1_000, false).is_some(),
                expected,
                "{sent} sent, {received} received"
            );
            drives.begin_reset();
            assert_eq!(drives.fault(1_000, false), None);
        }
    }
}

#[test]
fn every_drive_that_waits_for_the_start_command_counts_once() {
    for id in IDS {
        let mut drives = drives();
        assert!(!drives.take_start());
        drives.receive(&frame(0x700 + u16::from(id), &[0x7f]), 1_000);
        drives.receive(&frame(0x702, &[0x7f]), 1_000);
        assert!(drives.take_start());
        assert!(!drives.take_start(), "both are taken");
    }
}

#[test]
fn a_drive_that_restarted_is_asked_for_its_scale_again() {
    let mut drives = drives();
    assert_eq!(drives.scale_requests(0).count(), 4);
    for (index, id) in IDS.into_iter().enumerate() {
        drives.receive(&frame(0x700 + u16::from(id), &[5]), 1_000);
        let answer = scale(&drives, index);
        drives.receive(&answer, 1_000);
    }
    assert!(drives.complete());
    // The scale is kept over a reset without a restart.
    drives.begin_reset();
    assert!(drives.complete());
    drives.receive(&frame(0x704, &[0]), 2_000);
    drives.check_restarts(false);
    assert!(!drives.complete());
    let requests = drives.scale_requests(2_000_000);
    assert!(requests.map(|frame| frame.id()).eq([0x604]));
}

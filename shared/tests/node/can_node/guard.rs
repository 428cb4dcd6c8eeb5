//! What the node of a guard sends by CiA 301, as a table like that of the drives.

use super::{Memory, NODE, SERIAL, Subject, exchange, settings};
use crate::conformance::{NO_HEARTBEAT, Row};
use tautrack::bus::node::Condition;
use tautrack::can::Frame;
use tautrack::node::guard::Guard;
use tautrack::robots::b2p2::B2p2;
use tautrack::roles::guard::{Node, Readings};

/// A guard's node without sensors, and the time.
struct Rig {
    node: Node<Box<Guard<B2p2>>, Memory>,
    now_us: u64,
}

impl Rig {
    fn new(now_us: u64) -> (Self, Vec<Frame>) {
        let settings = settings();
        let guard = Guard::new(&settings).expect("a robot");
        let store = Memory(settings.clone(), false);
        let mut node = Node::new(&settings, Box::new(guard), store, SERIAL);
        let mut sent = Vec::new();
        node.boot(now_us, &mut |frame| sent.push(frame));
        (Self { node, now_us }, sent)
    }
}

impl Subject for Rig {
    fn run(&mut self, tick: bool) -> Vec<Frame> {
        let mut sent = Vec::new();
        self.now_us += 1_000;
        if tick {
            let readings = Readings {
                body: None,
                serial: &[],
                dead_man_released: false,
                emergency_stop: false,
                chips: [(0, 0); 3],
            };
            let mut send = |frame| sent.push(frame);
            let found = self.node.tick(self.now_us, &readings, &mut send);
            if found.restart {
                let (rig, boot) = Self::new(self.now_us);
                *self = rig;
                sent.extend(boot);
            }
        }
        sent
    }

    fn receive(&mut self, id: u16, data: &[u8]) -> Vec<Frame> {
        let mut sent = Vec::new();
        let frame = Frame::new(id, data).expect("a frame");
        self.node
            .receive(&frame, self.now_us, &mut |frame| sent.push(frame));
        sent
    }

    fn turn(&mut self) {}
}

/// Clause of the standard, and exchange. The guard waits for its drives.
type Entry = (&'static str, &'static str);

#[rustfmt::skip] // a row is a line, or a line and its exchange
const ROWS: &[Entry] = &[
    ("1000h: CiA 410", "40 1000:00 > 43 1000:00 0002019a"),
    ("1018h: product code", "40 1018:02 > 43 1018:02 00000003"),
    ("1018h: serial number", "40 1018:04 > 43 1018:04 serial"),
    ("1005h: it sends SYNC",
        "40 1005:00 > 43 1005:00 40000080; 23 1005:00 00000080 > 80 1005:00 06010002"),
    ("1014h: emergency", "40 1014:00 > 43 1014:00 00000085"),
    ("1016h: it follows no guard", "40 1016:01 > 43 1016:01 00000000"),
    ("1029h: the network state does not change", "40 1029:01 > 4f 1029:01 01"),
    ("1003h: no error", "40 1003:00 > 4f 1003:00 00; 40 1003:01 > 80 1003:01 08000024"),
    ("pre-operational while it waits for its drives, which it asks for their position scales",
        "2b 1017:00 000a > 60 1017:00; 20ms > 080:, 602: 40 2010:00 00000000, \
         603: 40 2010:00 00000000, 604: 40 2010:00 00000000, \
         605: 40 2010:00 00000000, 080:, 080:, 705: 7f, 080:, \
         080:, 705: 7f, 080:"),
    ("06020000: no such object", "40 2fff:00 > 80 2fff:00 06020000"),
    ("06090011: no such sub-index", "40 4001:20 > 80 4001:20 06090011"),
    ("06010002: read only",
        "2b 4000:00 0000 > 80 4000:00 06010002; 2f 4001:01 00 > 80 4001:01 06010002"),
    ("06070012, 06070013: size of the operator's speed",
        "23 4000:01 00000000 > 80 4000:01 06070012; 2f 4000:01 00 > 80 4000:01 06070013"),
    ("the operator's command by SDO", "2b 4000:01 00fa > 60 4000:01; 40 4000:01 > 4b 4000:01 00fa"),
    ("no PDO before operational",
        "205: 00fa 0000 0000 00 01 >; 40 4000:01 > 4b 4000:01 0000; 080: >"),
    ("1010h: 08000020: another signature", "23 1010:01 65766174 > 80 1010:01 08000020"),
    ("1010h: saves", "23 1010:01 65766173 > 60 1010:01"),
    ("1400h: the operator's command",
        "40 1400:01 > 43 1400:01 00000205; 40 1600:00 > 4f 1600:00 05"),
    ("1800h: process data", "40 1800:01 > 43 1800:01 40000185; 40 1804:01 > 43 1804:01 40000685"),
    ("06090030: an identifier of network management",
        "23 1800:01 c0000185 > 60 1800:01; \
         23 1800:01 40000000 > 80 1800:01 06090030"),
    ("08000022: a mapping in use", "2f 1a00:00 00 > 80 1a00:00 08000022"),
    ("05040001: an unknown command", "e0 1000:00 > 80 1000:00 05040001"),
];

#[test]
fn a_guard_answers_as_the_standard_says() {
    let row = |(clause, exchange): &Entry| Row::new(clause, NO_HEARTBEAT, exchange, SERIAL);
    let rows: Vec<_> = ROWS.iter().map(row).collect();
    exchange::run_all(&rows, || {
        let (rig, boot) = Rig::new(0);
        assert_eq!(boot, [Frame::new(0x700 + NODE, &[0]).unwrap()]);
        rig
    });
}

#[test]
fn a_guard_that_loses_frames_between_two_ticks_reports_it_once() {
    let (mut rig, _) = Rig::new(0);
    let mut reported = |frames: usize| {
        for _ in 0..frames {
            rig.receive(0x182, &[0; 8]);
        }
        let mut sent = Vec::new();
        let send = &mut |frame| sent.push(frame);
        rig.node.note_bus(Condition::default(), send);
        rig.run(true);
        sent
    };
    // A bus of 1 Mbit/s carries 21 frames without data in a millisecond.
    assert_eq!(reported(21), []);
    let emergency = Frame::new(0x080 + NODE, &[0x10, 0x81, 0x11, 0, 0, 0, 0, 0]).unwrap();
    assert_eq!(reported(100), [emergency]);
    assert_eq!(reported(21), []);
    assert_eq!(reported(100), []);
}

//! Tests that no sequence of frames makes the node of a drive panic or break the rules of an SDO
//! server.

use super::{NODE, Node, Subject};
use crate::drive_faults::generator::Random;
use tautrack::bus::network::NmtState;
use tautrack::can::Frame;
use tautrack::roles::drive::Control;

/// Frames for each of two nodes.
const FRAMES: u64 = 200_000;
const REQUEST: u16 = 0x600 + NODE;
const ANSWER: u16 = 0x580 + NODE;
const OWN: u8 = NODE as u8;

/// Objects of a drive. The others that a frame names are random.
const INDICES: [u16; 28] = [
    0x1000, 0x1001, 0x1008, 0x1009, 0x100a, 0x1010, 0x1011, 0x1017, 0x1018, 0x1400, 0x1401, 0x1403,
    0x1600, 0x1603, 0x1800, 0x1801, 0x1803, 0x1a00, 0x1a02, 0x2001, 0x2020, 0x2050, 0x2063, 0x2201,
    0x6040, 0x6060, 0x607a, 0x607d,
];
/// First bytes of SDO requests.
const COMMANDS: [u8; 34] = [
    0x00, 0x01, 0x07, 0x0f, 0x10, 0x11, 0x1b, 0x20, 0x21, 0x22, 0x23, 0x27, 0x2b, 0x2f, 0x40, 0x40,
    0x40, 0x60, 0x70, 0x80, 0x81, 0x82, 0xa0, 0xa1, 0xa2, 0xa3, 0xa4, 0xc0, 0xc1, 0xc4, 0xc6, 0xcd,
    0xd5, 0xe0,
];
/// Data of SDO requests: identifiers, mapped objects, sizes and signatures.
const VALUES: [u32; 16] = [
    0,
    1,
    2,
    4,
    8,
    0xff,
    0x7f_7f7f,
    0x4000_0185,
    0x4000_0385,
    0xc000_0185,
    0x0000_0205,
    0x6041_0010,
    0x6064_0020,
    0x607a_0020,
    u32::from_le_bytes(*b"save"),
    u32::MAX,
];

/// Generates a frame of which the node may take note. Some are the next request of a transfer,
/// after the node's last `answer`.
fn known(random: &mut Random, answer: u8) -> (u16, Vec<u8>) {
    let any = random.bits().to_le_bytes();
    match random.below(16) {
        0 => {
            let command = random.pick(&[1, 1, 1, 2, 128, 129, 130, 3]);
            (0x000, vec![command, random.pick(&[0, OWN, 6])])
        }
        1 | 2 => (0x080, Vec::new()),
        3 => (0x701, vec![random.pick(&[0, 4, 5, 127])]),
        4 | 5 => {
            let id = random.pick(&[0x200, 0x300, 0x400, 0x500]) + NODE;
            (id, any[..random.below(9) as usize].to_vec())
        }
        _ => {
            let [low, high] = random.pick(&INDICES).to_le_bytes();
            let next: &[u8] = match answer {
                0x41 | 0x10 => &[0x60],
                0x00 => &[0x70],
                0x60 | 0x30 => &[0x00, 0x06, 0x07, 0x0b],
                0x20 => &[0x1f, 0x1b, 0x10],
                0xc6 => &[0xa3],
                0x01..0x20 | 0x81..0xa0 => &[0xa2],
                0xa4 => &[0x81, 0x82, 0x01],
                0xa2 => &[0xcd, 0xd5, 0xdd],
                _ => &COMMANDS,
            };
            let command = if random.once_in(4) { &COMMANDS } else { next };
            let mut data = vec![random.pick(command), low, high, random.below(4) as u8];
            data.extend(random.pick(&VALUES).to_le_bytes());
            (REQUEST, data)
        }
    }
}

/// Generates any frame.
fn unknown(random: &mut Random) -> (u16, Vec<u8>) {
    let id = match random.below(4) {
        0 => REQUEST,
        _ => random.below(0x800) as u16,
    };
    let data = random.bits().to_le_bytes();
    (id, data[..random.below(9) as usize].to_vec())
}

/// What the client of the transfers knows.
#[derive(Default)]
struct Client {
    /// First byte of the node's last answer.
    answer: u8,
    sends_block: bool,
    /// Answers in ticks, to requests that may have none, and to others.
    counts: [u32; 3],
}

impl Client {
    /// Whether a request may have no answer. Others have exactly one.
    fn may_be_silent(&self, request: &[u8]) -> bool {
        let aborts = request[0] >> 5 == 4;
        let follows_upload = request[0] >> 5 == 5 && request[0] & 3 != 0;
        self.sends_block || aborts || follows_upload
    }

    /// Checks what the node sends, and counts its answers as those of this `kind`.
    fn note(&mut self, sent: &[Frame], kind: usize) -> Vec<Frame> {
        let (answers, others): (Vec<Frame>, Vec<Frame>) =
            sent.iter().copied().partition(|it| it.id() == ANSWER);
        for frame in others {
            // The heartbeat, emergencies, and process data, whose identifiers are not restricted.
            let id = frame.id();
            let is_known = matches!(
                id,
                0x81..=0x100 | 0x181..=0x580 | 0x600 | 0x680..=0x6df | 0x700 | 0x705
            );
            assert!(is_known, "{frame:?}");
        }
        for answer in &answers {
            let &[command, acknowledged, _, ..] = answer.data() else {
                panic!("{answer:?}");
            };
            assert_eq!(answer.data().len(), 8);
            self.answer = command;
            self.sends_block = match command {
                0xa4 => true,
                0xa2 => acknowledged == 0,
                _ => false,
            };
            self.counts[kind] += 1;
        }
        answers
    }

    fn forget(&mut self) {
        (self.answer, self.sends_block) = (0x80, false);
    }
}

fn run<C: Control>(mut node: Node<C>, seed: u64) {
    let mut random = Random::new(seed);
    let mut client = Client::default();
    for number in 0..FRAMES {
        let (id, data) = if random.once_in(2) {
            unknown(&mut random)
        } else {
            known(&mut random, client.answer)
        };
        let served = id == REQUEST && data.len() == 8 && node.state() != NmtState::Stopped;
        let silent = served && client.may_be_silent(&data);
        let sent = node.receive(id, &data);
        let answers = client.note(&sent, if silent { 1 } else { 2 });
        let fits = match (served, silent) {
            (false, _) => answers.is_empty(),
            (true, true) => answers.len() <= 1,
            (true, false) => answers.len() == 1,
        };
        let context = format!("seed {seed}, frame {number}: {id:03x} {data:02x?}");
        assert!(fits, "{context} -> {answers:02x?}");
        match (id, &*data) {
            (REQUEST, [0x80, ..]) if served => client.forget(),
            (0x000, [2 | 129 | 130, 0 | OWN]) => client.forget(),
            _ => {}
        }
        let time_ms = if random.once_in(200) {
            600
        } else {
            random.pick(&[0, 0, 0, 0, 0, 0, 1, 1, 2])
        };
        for _ in 0..time_ms {
            let sent = node.run(true);
            client.note(&sent, 0);
        }
        if random.once_in(8) {
            node.rotor.0 = node.rotor.0.wrapping_add(random.below(9) as i32 - 4);
        }
    }
    let counts = client.counts;
    assert!(counts.iter().all(|it| *it > 100), "{counts:?}");
}

#[test]
fn any_frames_get_the_answers_of_an_sdo_server() {
    std::thread::scope(|scope| {
        scope.spawn(|| run(Node::axle(), 1));
        scope.spawn(|| run(Node::screw(), 2));
    });
}

//! Layer setting services (LSS, CiA 305) of a node that has no node id yet.
//!
//! The node is mute until a master addresses it, by switching all nodes to configuration, by its
//! identity, or by a fast scan. Then the master gives it a node id. The node refuses an id with
//! which another one has sent.

use super::network::is_of;
use crate::can::Frame;

/// Identifier of the master's requests.
pub const REQUEST: u16 = 0x7e5;
/// Identifier of the answers.
pub const RESPONSE: u16 = 0x7e4;

/// Node id of a node that has none.
const NO_ID: u8 = 0xff;
/// Fast scan: the value of "bit check" that begins a scan.
const BEGIN_SCAN: u8 = 0x80;
/// Errors of the answer to a node id: out of range, or specific to the device, here an id in use.
const OUT_OF_RANGE: u8 = 1;
const IN_USE: u8 = 0xff;
/// Numbers in the request "identify remote slave": vendor, product code, least and largest
/// revision, least and largest serial number.
const RANGE: usize = 6;

/// What a request asks of the node, besides the answer of [`Slave::receive`].
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Action {
    /// Answer with this frame.
    Answer(Frame),
    /// Save this node id; answer with [`stored`].
    Store(u8),
    /// Start with this node id.
    Start(u8),
}

/// State of an unconfigured node.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Slave {
    /// Vendor, product code, revision and serial number (object 0x1018).
    identity: [u32; 4],
    configuring: bool,
    /// Numbers of the identity that the master has matched, in order.
    matched: usize,
    /// Numbers of the request "identify remote slave" that this node has matched, in order.
    within: usize,
    scanned: usize,
    node_id: Option<u8>,
    /// Bits of the node ids with which others have sent.
    in_use: u128,
}

impl Slave {
    /// A node with this identity: vendor, product code, revision and serial number.
    pub const fn new(identity: [u32; 4]) -> Self {
        Self {
            identity,
            configuring: false,
            matched: 0,
            within: 0,
            scanned: 0,
            node_id: None,
            in_use: 0,
        }
    }

    /// Processes a frame from the bus. Returns `None` for a frame that asks nothing of this node.
    pub fn receive(&mut self, frame: &Frame) -> Option<Action> {
        let sender = (frame.id() & 0x7f) as u8;
        if is_of(frame, sender) {
            self.in_use |= 1 << sender;
        }
        let &[command, a, b, c, d, bit_check, sub, next] = frame.data() else {
            return None;
        };
        if frame.id() != REQUEST {
            return None;
        }
        let number = u32::from_le_bytes([a, b, c, d]);
        match command {
            0x04 => self.switch(a == 1),
            0x40..=0x43 => self.select(usize::from(command - 0x40), number),
            0x46..=0x4b => self.identify(usize::from(command - 0x46), number),
            0x4c if self.node_id.is_none() => answer([0x50]),
            0x51 => self.scan(number, bit_check, sub, next),
            _ if !self.configuring => None,
            0x11 => {
                let error = match a {
                    NO_ID => {
                        self.node_id = None;
                        0
                    }
                    1..=127 if self.in_use >> a & 1 != 0 => IN_USE,
                    1..=127 => {
                        self.node_id = Some(a);
                        0
                    }
                    _ => OUT_OF_RANGE,
                };
                answer([0x11, error])
            }
            // The bit rate is that of the project.
            0x13 => answer([0x13, 1]),
            0x17 => match self.node_id {
                Some(id) => Some(Action::Store(id)),
                None => Some(Action::Answer(stored(false)?)),
            },
            0x5a..=0x5d => {
                let number = self.identity.get(usize::from(command - 0x5a))?;
                let [a, b, c, d] = number.to_le_bytes();
                answer([command, a, b, c, d])
            }
            0x5e => answer([0x5e, self.node_id.unwrap_or(NO_ID)]),
            _ => None,
        }
    }

    /// Switches to configuration, or back. The node starts when it goes back with a node id.
    fn switch(&mut self, configuring: bool) -> Option<Action> {
        let ends = self.configuring && !configuring;
        self.configuring = configuring;
        self.matched = 0;
        self.node_id.filter(|_| ends).map(Action::Start)
    }

    /// Compares the identity, number by number.
    fn select(&mut self, place: usize, number: u32) -> Option<Action> {
        let next = place == 0 || place == self.matched;
        let equal = self.identity.get(place) == Some(&number);
        self.matched = if next && equal { place + 1 } else { 0 };
        if self.matched < self.identity.len() {
            return None;
        }
        self.configuring = true;
        self.matched = 0;
        answer([0x44])
    }

    /// Compares the identity with ranges, number by number. Answers if it is within all.
    fn identify(&mut self, place: usize, number: u32) -> Option<Action> {
        let [vendor, product, revision, serial] = self.identity;
        let within = match place {
            0 => vendor == number,
            1 => product == number,
            2 => revision >= number,
            3 => revision <= number,
            4 => serial >= number,
            _ => serial <= number,
        };
        let next = place == 0 || place == self.within;
        self.within = if next && within { place + 1 } else { 0 };
        if self.within < RANGE {
            return None;
        }
        self.within = 0;
        answer([0x4f])
    }

    /// Answers if the upper bits of a number of the identity, from `bit_check` on, are those of
    /// `number`.
    fn scan(&mut self, number: u32, bit_check: u8, sub: u8, next: u8) -> Option<Action> {
        if self.configuring || self.node_id.is_some() {
            return None;
        }
        if bit_check == BEGIN_SCAN {
            self.scanned = 0;
            return answer([0x4f]);
        }
        let own = self.identity.get(usize::from(sub))?;
        let differing = (own ^ number).checked_shr(u32::from(bit_check))?;
        if usize::from(sub) != self.scanned || differing != 0 {
            return None;
        }
        if bit_check == 0 && next != sub {
            // A scan that leaves out a number could find two nodes.
            let last = self.scanned + 1 == self.identity.len();
            if usize::from(next) != if last { 0 } else { self.scanned + 1 } {
                return None;
            }
            self.scanned = next.into();
            // After the last number, the master has found this node.
            self.configuring = last;
        }
        answer([0x4f])
    }
}

/// Answer to [`Action::Store`]: whether the node id was saved.
pub fn stored(success: bool) -> Option<Frame> {
    response([0x17, if success { 0 } else { 2 }])
}

fn answer<const N: usize>(bytes: [u8; N]) -> Option<Action> {
    response(bytes).map(Action::Answer)
}

fn response<const N: usize>(bytes: [u8; N]) -> Option<Frame> {
    let mut data = [0; 8];
    data.get_mut(..N)?.copy_from_slice(&bytes);
    Frame::new(RESPONSE, &data)
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: [u32; 4] = [0, 1, 1, 0xdead_beee];

    fn request(slave: &mut Slave, data: [u8; 8]) -> Option<Action> {
        slave.receive(&Frame::new(REQUEST, &data).unwrap())
    }

    fn number(slave: &mut Slave, command: u8, number: u32, rest: [u8; 3]) -> Option<u8> {
        let [a, b, c, d] = number.to_le_bytes();
        let [e, f, g] = rest;
        match request(slave, [command, a, b, c, d, e, f, g]) {
            Some(Action::Answer(frame)) => Some(frame.data()[0]),
            None => None,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn an_unaddressed_node_is_mute() {
        let mut slave = Slave::new(IDENTITY);
        for command in [0x11, 0x13, 0x15, 0x17, 0x5a, 0x5e] {
            assert_eq!(request(&mut slave, [command, 5, 0, 0, 0, 0, 0, 0]), None);
        }
        let other = Frame::new(0x601, &[4, 1, 0, 0, 0, 0, 0, 0]).unwrap();
        assert_eq!(slave.receive(&other), None);
        assert_eq!(slave, Slave::new(IDENTITY));
    }

    #[test]
    fn a_node_that_is_selected_gets_its_id_and_starts() {
        for wrong in 0..=4 {
            let mut slave = Slave::new(IDENTITY);
            let mut last = None;
            for (place, own) in (0..).zip(IDENTITY) {
                let told = if usize::from(place) == wrong {
                    own + 1
                } else {
                    own
                };
                last = number(&mut slave, 0x40 + place, told, [0; 3]);
            }
            let selected = wrong == 4;
            assert_eq!(last, selected.then_some(0x44));
            let answer = request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
            assert_eq!(answer.is_some(), selected);
            if selected {
                let store = request(&mut slave, [0x17, 0, 0, 0, 0, 0, 0, 0]);
                assert_eq!(store, Some(Action::Store(9)));
                let start = request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]);
                assert_eq!(start, Some(Action::Start(9)));
            }
        }
    }

    #[test]
    fn a_node_id_that_is_none_is_refused() {
        let mut slave = Slave::new(IDENTITY);
        assert_eq!(request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]), None);
        for id in [0, 128, 254] {
            let Some(Action::Answer(answer)) = request(&mut slave, [0x11, id, 0, 0, 0, 0, 0, 0])
            else {
                panic!("no answer")
            };
            assert_eq!(answer.data()[1], 1);
        }
        assert_eq!(request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]), None);
    }

    #[test]
    fn a_node_id_in_use_is_refused_and_one_can_be_taken_back() {
        let mut slave = Slave::new(IDENTITY);
        // Heartbeat of node 9, and position of node 12. Requests to a node are not of it.
        for (id, data) in [
            (0x709, &[5][..]),
            (0x18c, &[0; 8]),
            (0x60a, &[0; 8]),
            (0x20b, &[0; 8]),
        ] {
            assert_eq!(slave.receive(&Frame::new(id, data).unwrap()), None);
        }
        request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]);
        let mut give = |id: u8| match request(&mut slave, [0x11, id, 0, 0, 0, 0, 0, 0]) {
            Some(Action::Answer(answer)) => answer.data()[1],
            other => panic!("{other:?}"),
        };
        assert_eq!([9, 12, 10, 11, 255].map(&mut give), [255, 255, 0, 0, 0]);
        assert_eq!(
            request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]),
            None,
            "it has no id"
        );
    }

    #[test]
    fn a_bit_rate_cannot_be_chosen() {
        let mut slave = Slave::new(IDENTITY);
        request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]);
        let Some(Action::Answer(answer)) = request(&mut slave, [0x13, 0, 0, 0, 0, 0, 0, 0]) else {
            panic!("no answer")
        };
        assert_eq!(answer.data()[..2], [0x13, 1]);
    }

    /// CiA 305: identify remote slave, and identify non-configured remote slave.
    #[test]
    fn a_node_says_whether_its_identity_is_within_ranges() {
        let all = [0, 1, 0, 9, 0, u32::MAX];
        let ask = |ranges: [u32; 6]| {
            let mut slave = Slave::new(IDENTITY);
            let answers = (0x46..)
                .zip(ranges)
                .map(|(command, it)| number(&mut slave, command, it, [0; 3]));
            answers.last().flatten()
        };
        assert_eq!(ask(all), Some(0x4f));
        for (place, other) in [(0, 1), (1, 2), (2, 2), (3, 0), (4, u32::MAX), (5, 1)] {
            let mut ranges = all;
            ranges[place] = other;
            assert_eq!(ask(ranges), None, "{place}");
        }
        let mut slave = Slave::new(IDENTITY);
        assert_eq!(number(&mut slave, 0x4c, 0, [0; 3]), Some(0x50));
        request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]);
        request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
        assert_eq!(number(&mut slave, 0x4c, 0, [0; 3]), None, "it has an id");
    }

    /// The identities differ in the number that the scan leaves out.
    #[test]
    fn a_scan_that_leaves_out_a_number_finds_nobody() {
        for skipped in 0..4 {
            let mut slave = Slave::new(IDENTITY);
            number(&mut slave, 0x51, 0, [0x80, 0, 0]);
            for sub in (0..4).filter(|sub| *sub != skipped) {
                let next = (sub + 1..4).find(|next| *next != skipped).unwrap_or(0);
                let own = IDENTITY[usize::from(sub)];
                number(&mut slave, 0x51, own, [0, sub, next]);
            }
            let answer = request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
            assert_eq!(answer, None, "without number {skipped}");
        }
    }

    #[test]
    fn a_fast_scan_finds_the_identity_bit_by_bit() {
        let mut slave = Slave::new(IDENTITY);
        assert_eq!(number(&mut slave, 0x51, 0, [0x80, 0, 0]), Some(0x4f));
        let mut found = [0; 4];
        for (sub, found) in (0..).zip(&mut found) {
            for bit in (0..32).rev() {
                if number(&mut slave, 0x51, *found, [bit, sub, sub]).is_none() {
                    *found |= 1 << bit;
                }
            }
            let next = (sub + 1) % 4;
            let confirmed = number(&mut slave, 0x51, *found, [0, sub, next]);
            assert_eq!(confirmed, Some(0x4f));
        }
        assert_eq!(found, IDENTITY);
        assert!(request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]).is_some());
    }

    /// CiA 305: inquire identity (0x5A to 0x5D) and inquire node id (0x5E).
    #[test]
    fn a_node_in_configuration_tells_its_identity_and_its_node_id() {
        let mut slave = Slave::new(IDENTITY);
        let inquire = |slave: &mut Slave, command: u8| {
            let Some(Action::Answer(frame)) = request(slave, [command, 0, 0, 0, 0, 0, 0, 0]) else {
                panic!("no answer to {command:#x}")
            };
            assert_eq!((frame.id(), frame.data()[0]), (RESPONSE, command));
            let &[_, a, b, c, d, ..] = frame.data() else {
                panic!("a short answer")
            };
            u32::from_le_bytes([a, b, c, d])
        };
        assert_eq!(request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]), None);
        let found = [0x5a, 0x5b, 0x5c, 0x5d].map(|command| inquire(&mut slave, command));
        assert_eq!(found, IDENTITY);
        assert_eq!(inquire(&mut slave, 0x5e), 0xff, "no node id yet");
        request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
        assert_eq!(inquire(&mut slave, 0x5e), 9);
    }

    #[test]
    fn only_the_end_of_a_configuration_starts_a_node() {
        let mut slave = Slave::new(IDENTITY);
        request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]);
        request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
        assert_eq!(request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]), None);
        let start = request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(start, Some(Action::Start(9)));
        assert_eq!(request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]), None);
    }

    #[test]
    fn a_scan_finds_only_nodes_that_are_not_configured() {
        let mut slave = Slave::new(IDENTITY);
        request(&mut slave, [4, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(number(&mut slave, 0x51, 0, [0x80, 0, 0]), None);
        request(&mut slave, [0x11, 9, 0, 0, 0, 0, 0, 0]);
        request(&mut slave, [4, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(number(&mut slave, 0x51, 0, [0x80, 0, 0]), None);
    }

    /// Only the confirmation of all 32 bits goes on to the next number of the identity.
    #[test]
    fn a_scan_stays_at_a_number_until_its_last_bit() {
        let mut slave = Slave::new(IDENTITY);
        number(&mut slave, 0x51, 0, [0x80, 0, 0]);
        assert_eq!(number(&mut slave, 0x51, 0, [1, 0, 1]), Some(0x4f));
        assert_eq!(number(&mut slave, 0x51, 0, [0, 0, 0]), Some(0x4f));
        assert_eq!(number(&mut slave, 0x51, 1, [0, 1, 1]), None);
        assert_eq!(number(&mut slave, 0x51, 0, [0, 0, 1]), Some(0x4f));
        assert_eq!(number(&mut slave, 0x51, 1, [0, 1, 1]), Some(0x4f));
    }

    #[test]
    fn a_master_is_told_whether_the_node_id_was_saved() {
        let answer = |error: u8| Frame::new(RESPONSE, &[0x17, error, 0, 0, 0, 0, 0, 0]);
        assert_eq!((stored(true), stored(false)), (answer(0), answer(2)));
    }
}

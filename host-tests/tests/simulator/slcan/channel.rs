//! Tests of the protocol, against the manuals of Lawicel's CAN232 and CANUSB.

use super::frame;
use proptest::collection::vec;
use proptest::prelude::*;
use std::collections::VecDeque;
use tautrack::can::Frame;
use tautrack_host_tests::simulator::slcan::{Channel, Request, line_of};

/// Adds these bytes to a channel; returns its answers and the frames for the bus.
fn exchange(channel: &mut Channel, bytes: &[u8]) -> (String, Vec<Frame>) {
    let (mut frames, mut answers) = (Vec::new(), VecDeque::new());
    channel.receive(bytes);
    assert!(channel.answer(usize::MAX, &mut frames, &mut answers));
    let answers = String::from_utf8(answers.into()).unwrap();
    (answers, frames)
}

fn answers(channel: &mut Channel, lines: &str) -> String {
    exchange(channel, lines.as_bytes()).0
}

/// Returns a channel after these commands, all of which it accepts.
fn after(commands: &str) -> Channel {
    let mut channel = Channel::default();
    let accepted = "\r".repeat(commands.matches('\r').count());
    assert_eq!(answers(&mut channel, commands), accepted);
    channel
}

#[test]
fn lines_mean_what_the_protocol_says() {
    let transmit = |id, data: &[u8]| Request::Transmit(frame(id, data));
    let unheard = |extended| Request::TransmitUnheard { extended };
    for (line, request) in [
        ("t1232AAbB", transmit(0x123, &[0xaa, 0xbb])),
        ("t0000", transmit(0, &[])),
        (
            "t7FF80102030405060708",
            transmit(0x7ff, &[1, 2, 3, 4, 5, 6, 7, 8]),
        ),
        ("r7ff8", unheard(false)),
        ("T1FFFFFFF80102030405060708", unheard(true)),
        ("T000001230", unheard(true)),
        ("R1fffffff0", unheard(true)),
        ("O", Request::Open),
        ("L", Request::Listen),
        ("C", Request::Close),
        ("Z0", Request::TimeStamps(false)),
        ("Z1", Request::TimeStamps(true)),
    ] {
        assert_eq!(Request::parse(line.as_bytes()), request, "{line}");
    }
    for line in [
        "",
        "t8000",
        "t1232AA",
        "t12301",
        "t1239",
        "t12",
        "t123gAA",
        "t1230\n",
        "r8000",
        "r1239",
        "r12320000",
        "T200000000",
        "T0000012",
        "T000001231",
        "T000001239001122334455667788",
        "R200000000",
        "R00000123100",
        "Ox",
        "L1",
        "Z",
        "Z2",
        "V1",
        "\u{fc}",
    ] {
        assert_eq!(
            Request::parse(line.as_bytes()),
            Request::Unknown,
            "{line:?}"
        );
    }
    assert_eq!(line_of(&frame(0x1b, &[0, 0xf0]), None), "t01B200F0\r");
}

/// The registers are those that the manual of the SJA1000 has for a crystal of 16 MHz.
#[test]
fn only_settings_that_the_port_has_are_accepted() {
    for (line, accepted) in [
        ("S0", false),
        ("S1", false),
        ("S2", false),
        ("S3", false),
        ("S4", false),
        ("S5", false),
        ("S6", false),
        ("S7", false),
        ("S8", true),
        ("S9", false),
        ("S", false),
        ("S88", false),
        // 1 Mbit/s, with three widths of the synchronization jump, and with three samples.
        ("s0014", true),
        ("s4014", true),
        ("s8014", true),
        ("s0094", true),
        // 1 Mbit/s with a sample point of 62.5 %.
        ("s0023", true),
        ("s0016", false), // 800 kbit/s
        ("s001C", false), // 500 kbit/s
        ("s011c", false), // 250 kbit/s
        ("s031C", false), // 125 kbit/s
        ("s014", false),
        ("s00144", false),
        ("s00g4", false),
        ("M00000000", true),
        ("M00000001", false),
        ("M0000000", false),
        ("mFFFFFFFF", true),
        ("mffffffff", true),
        ("m00000000", false),
        ("mFFFFFFF", false),
    ] {
        let mut channel = Channel::default();
        let answer = if accepted { "\r" } else { "\x07" };
        assert_eq!(
            answers(&mut channel, &format!("{line}\r")),
            answer,
            "{line}"
        );
        // A client that ignores the refusal opens its channel as if it had not asked.
        assert_eq!(answers(&mut channel, "O\r"), "\r", "{line}");
    }
}

#[test]
fn commands_are_refused_in_the_states_in_which_an_adapter_refuses_them() {
    const NO: &str = "\x07";
    for (line, [closed, listening, open]) in [
        ("O", ["\r", NO, NO]),
        ("L", ["\r", NO, NO]),
        ("C", [NO, "\r", "\r"]),
        ("S8", ["\r", NO, NO]),
        ("s0014", ["\r", NO, NO]),
        ("M00000000", ["\r", NO, NO]),
        ("mFFFFFFFF", ["\r", NO, NO]),
        ("Z0", ["\r", NO, NO]),
        ("Z1", ["\r", NO, NO]),
        ("V", ["V0101\r"; 3]),
        ("N", ["N0001\r"; 3]),
        ("F", [NO, "F00\r", "F00\r"]),
        ("t12311F", [NO, NO, "z\r"]),
        ("r1231", [NO, NO, "z\r"]),
        ("T0000012311F", [NO, NO, "Z\r"]),
        ("R000001231", [NO, NO, "Z\r"]),
        ("P", [NO; 3]),
        ("A", [NO; 3]),
        ("X0", [NO; 3]),
        ("X1", [NO; 3]),
        ("U0", [NO; 3]),
        ("Q1", [NO; 3]),
        ("W0", [NO; 3]),
        ("", [NO; 3]),
        ("no such thing", [NO; 3]),
        ("a line that is longer than any of the protocol", [NO; 3]),
    ] {
        for (before, expected) in [("", closed), ("L\r", listening), ("O\r", open)] {
            let answer = answers(&mut after(before), &format!("{line}\r"));
            assert_eq!(answer, expected, "{line:?} after {before:?}");
        }
    }
}

#[test]
fn a_client_that_only_listens_receives_frames_and_sends_none() {
    let mut channel = after("L\r");
    assert!(channel.is_open() && channel.has_joined());
    let line = channel.line_of(&frame(0x701, &[5]), 0);
    assert_eq!(line.as_deref(), Some("t701105\r"));
    assert_eq!(exchange(&mut channel, b"t12311F\r").1, []);
    assert_eq!(answers(&mut channel, "C\rO\r"), "\r\r");
    assert_eq!(
        exchange(&mut channel, b"t12311F\r").1,
        [frame(0x123, &[0x1f])]
    );
}

#[test]
fn a_client_has_joined_even_if_it_leaves_at_once() {
    let channel = after("O\rC\r");
    assert!(!channel.is_open() && channel.has_joined());
    assert_eq!(channel.line_of(&frame(0x701, &[5]), 0), None);
}

#[test]
fn remote_frames_and_those_with_29_bits_do_not_reach_the_bus() {
    let lines = b"r1231\rT0000012311F\rR000001231\rt1230\r";
    let (answers, frames) = exchange(&mut after("O\r"), lines);
    assert_eq!(answers, "z\rZ\rZ\rz\r");
    assert_eq!(frames, [frame(0x123, &[])]);
}

#[test]
fn time_stamps_count_the_milliseconds_of_a_minute_of_virtual_time() {
    for (time_us, line) in [
        (0, "t7011050000\r"),
        (1_999, "t7011050001\r"),
        (59_999_999, "t701105EA5F\r"),
        (60_000_000, "t7011050000\r"),
        (3_661_234_000, "t70110504D2\r"),
    ] {
        let frame = frame(0x701, &[5]);
        let mut channel = after("Z1\rO\r");
        assert_eq!(channel.line_of(&frame, time_us).as_deref(), Some(line));
        assert_eq!(answers(&mut channel, "C\rZ0\rO\r"), "\r\r\r");
        let line = channel.line_of(&frame, time_us);
        assert_eq!(line.as_deref(), Some("t701105\r"));
    }
}

/// Bytes that a client may send: commands, and anything else.
fn script() -> impl Strategy<Value = Vec<u8>> {
    let command = "[OLCSsZMmVNFPAXQWUtTrR][0-9A-Fa-f]{0,30}\r".prop_map(String::into_bytes);
    let of_its_length = "(t[0-7][0-9A-F]{2}0|T[01][0-9A-F]{7}1[0-9A-F]{2}|O|L|C|S8|Z1|F)\r"
        .prop_map(String::into_bytes);
    let any_bytes = vec(any::<u8>(), 0..60);
    let endless = vec(Just(b't'), 0..2_000);
    let part = prop_oneof![4 => command, 4 => of_its_length, 2 => any_bytes, 1 => endless];
    vec(part, 0..40).prop_map(|parts| parts.concat())
}

proptest! {
    #[test]
    fn every_frame_survives_the_way_to_a_line_and_back(
        id in 0_u16..=0x7ff, data in vec(any::<u8>(), 0..=8),
    ) {
        let frame = frame(id, &data);
        let line = line_of(&frame, None);
        let line = line.strip_suffix('\r').unwrap();
        prop_assert_eq!(Request::parse(line.as_bytes()), Request::Transmit(frame));
    }

    /// What the channel keeps is bounded: its debug output has each byte.
    #[test]
    fn every_line_gets_one_answer_whatever_a_client_sends(
        bytes in script(), size in 1..500_usize, room in 1..4_usize,
    ) {
        let mut channel = Channel::default();
        let (mut taken, mut answers) = (Vec::new(), VecDeque::new());
        for chunk in bytes.chunks(size) {
            channel.receive(chunk);
            loop {
                let mut frames = Vec::new();
                let all = channel.answer(room, &mut frames, &mut answers);
                prop_assert!(frames.len() <= room);
                taken.extend(frames);
                if all { break }
            }
            prop_assert!(format!("{channel:?}").len() < 400, "{channel:?}");
        }
        let ends = answers.iter().filter(|byte| matches!(byte, b'\r' | b'\x07'));
        let lines = bytes.iter().filter(|byte| **byte == b'\r');
        prop_assert_eq!(ends.count(), lines.count());
        // How the bytes were divided, and how long frames waited, changes nothing.
        let whole = exchange(&mut Channel::default(), &bytes);
        prop_assert_eq!((String::from_utf8(answers.into()).unwrap(), taken), whole);
    }
}

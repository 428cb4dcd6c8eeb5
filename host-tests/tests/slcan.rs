//! A client that speaks SLCAN over TCP is a participant of the bus.

use proptest::collection::vec;
use proptest::prelude::*;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;
use tautrack_host_tests::slcan::{Request, SlcanPort, line_of};

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(id, data).unwrap()
}

/// Polls until `done` holds of all frames received so far and of the port.
fn poll_until(port: &mut SlcanPort, done: impl Fn(&SlcanPort, &[Frame]) -> bool) -> Vec<Frame> {
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut frames = Vec::new();
    while !done(port, &frames) {
        assert!(Instant::now() < deadline, "{port:?} got only {frames:?}");
        frames.extend(port.poll(64));
        std::thread::yield_now();
    }
    frames
}

fn client_of(port: &SlcanPort) -> TcpStream {
    let client = TcpStream::connect(port.address().unwrap()).unwrap();
    client
        .set_read_timeout(Some(Duration::from_secs(20)))
        .unwrap();
    client
}

/// Polls the port until the client has got exactly `expected`.
fn assert_answer(port: &mut SlcanPort, client: &mut TcpStream, request: &str, expected: &str) {
    client.write_all(request.as_bytes()).unwrap();
    client.set_nonblocking(true).unwrap();
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut answer = Vec::new();
    while answer.len() < expected.len() {
        assert!(
            Instant::now() < deadline,
            "{request:?} was answered by {answer:?}"
        );
        port.poll(64);
        let mut chunk = [0; 64];
        match client.read(&mut chunk) {
            Ok(count) => answer.extend(&chunk[..count]),
            Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::yield_now(),
            Err(error) => panic!("{error}"),
        }
    }
    client.set_nonblocking(false).unwrap();
    assert_eq!(
        String::from_utf8(answer).unwrap(),
        expected,
        "answer to {request:?}"
    );
}

#[test]
fn lines_mean_what_the_protocol_says() {
    let transmit = |id, data: &[u8]| Some(Request::Transmit(frame(id, data)));
    assert_eq!(Request::parse(b"t1232AAbB"), transmit(0x123, &[0xaa, 0xbb]));
    assert_eq!(Request::parse(b"t0000"), transmit(0, &[]));
    assert_eq!(
        Request::parse(b"t7FF80102030405060708"),
        transmit(0x7ff, &[1, 2, 3, 4, 5, 6, 7, 8])
    );
    assert_eq!(Request::parse(b""), None);
    for line in [
        "t8000",
        "t1232AA",
        "t1239",
        "t12",
        "t123gAA",
        "T0000012300",
        "r1230",
        "R000001230",
        "S9",
        "Ox",
        "?",
    ] {
        assert_eq!(
            Request::parse(line.as_bytes()),
            Some(Request::Unsupported),
            "{line}"
        );
    }
    assert_eq!(line_of(&frame(0x1b, &[0, 0xf0])), "t01B200F0\r");
}

proptest! {
    #[test]
    fn every_frame_survives_the_way_to_a_line_and_back(id in 0_u16..=0x7ff, data in vec(any::<u8>(), 0..=8)) {
        let frame = frame(id, &data);
        let line = line_of(&frame);
        let line = line.strip_suffix('\r').unwrap();
        prop_assert_eq!(Request::parse(line.as_bytes()), Some(Request::Transmit(frame)));
    }

    #[test]
    fn no_line_can_break_the_parser(line in vec(any::<u8>(), 0..40)) {
        Request::parse(&line);
    }
}

#[test]
fn commands_are_answered_as_by_an_adapter() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    for (request, expected) in [
        ("\r\r", ""),
        ("C\r", "\r"),
        ("S8\r", "\r"),
        ("V\r", "V0101\r"),
        ("N\r", "N0001\r"),
        ("F\r", "F00\r"),
        ("t0000\r", "\x07"),
        ("O\r", "\r"),
        ("t0000\r", "z\r"),
        ("T000000010\r", "\x07"),
        ("no such thing\r", "\x07"),
        ("thirty bytes without any end of line at all", "\x07"),
        ("\rC\rt0000\r", "\r\x07"),
    ] {
        assert_answer(&mut port, &mut client, request, expected);
    }
}

#[test]
fn frames_pass_both_ways_while_the_channel_is_open() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    port.send(&frame(0x1, &[]));
    assert!(!port.attached());
    assert_answer(&mut port, &mut client, "O\r", "\r");
    assert!(port.attached());

    client.write_all(b"t6014402").unwrap();
    client.write_all(b"F1000\rt0802").unwrap();
    client.write_all(b"0102\r").unwrap();
    let frames = poll_until(&mut port, |_, frames| frames.len() == 2);
    assert_eq!(
        frames,
        [
            frame(0x601, &[0x40, 0x2f, 0x10, 0x00]),
            frame(0x080, &[1, 2])
        ]
    );

    port.send(&frame(0x581, &[0x4f]));
    let mut heard = [0; 14];
    client.read_exact(&mut heard[..4]).unwrap();
    assert_eq!(&heard[..4], b"z\rz\r");
    client.read_exact(&mut heard[..8]).unwrap();
    assert_eq!(&heard[..8], b"t58114F\r");
}

#[test]
fn no_more_frames_are_taken_than_there_is_room_and_none_is_lost() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    assert_answer(&mut port, &mut client, "O\r", "\r");
    let sent: Vec<Frame> = (0..100).map(|number| frame(0x123, &[number])).collect();
    let lines: String = sent.iter().map(line_of).collect();
    client.write_all(lines.as_bytes()).unwrap();
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut frames = Vec::new();
    while frames.len() < 100 {
        assert!(Instant::now() < deadline);
        let taken = port.poll(7);
        assert!(taken.len() <= 7);
        frames.extend(taken);
    }
    assert_eq!(frames, sent);
    assert_eq!(port.poll(0), []);
}

#[test]
fn a_second_client_is_served_when_the_first_has_left() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut first = client_of(&port);
    assert_answer(&mut port, &mut first, "O\r", "\r");
    let mut second = client_of(&port);
    second.write_all(b"O\rt0010\r").unwrap();
    drop(first);
    let frames = poll_until(&mut port, |_, frames| !frames.is_empty());
    assert_eq!(frames, [frame(1, &[])]);
    assert!(port.attached());
    drop(second);
    poll_until(&mut port, |port, _| !port.attached());
}

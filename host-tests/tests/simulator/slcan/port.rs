//! Tests of the connections of clients over TCP.

use super::frame;
use rustix::net::sockopt::set_socket_recv_buffer_size;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tautrack::can::Frame;
use tautrack_host_tests::simulator::slcan::{MAX_CLIENTS, SlcanPort, line_of};

/// Polls the port; returns the frames of all clients, at most `room` of each.
fn poll(port: &mut SlcanPort, room: usize) -> Vec<Frame> {
    let frames = port.poll(|_| room);
    frames.into_iter().map(|(_, frame)| frame).collect()
}

/// Polls until `done` is true for the port and all frames received so far; returns the frames.
fn poll_until(port: &mut SlcanPort, done: impl Fn(&SlcanPort, &[Frame]) -> bool) -> Vec<Frame> {
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut frames = Vec::new();
    while !done(port, &frames) {
        assert!(Instant::now() < deadline, "{port:?} got only {frames:?}");
        frames.extend(poll(port, 64));
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

/// Sends `request` and polls the port until the client has received exactly `expected`.
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
        poll(port, 64);
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
fn frames_pass_both_ways_while_the_channel_is_open() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    port.send(&frame(0x1, &[]), None, 0);
    assert_eq!(port.attached(), 0);
    assert_answer(&mut port, &mut client, "O\r", "\r");
    assert_eq!(port.attached(), 1);

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

    port.send(&frame(0x581, &[0x4f]), None, 0);
    let mut received = [0; 14];
    client.read_exact(&mut received[..4]).unwrap();
    assert_eq!(&received[..4], b"z\rz\r");
    client.read_exact(&mut received[..8]).unwrap();
    assert_eq!(&received[..8], b"t58114F\r");
}

#[test]
fn no_more_frames_are_taken_than_there_is_room_and_none_is_lost() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    assert_answer(&mut port, &mut client, "O\r", "\r");
    let sent: Vec<Frame> = (0..100).map(|number| frame(0x123, &[number])).collect();
    let lines: String = sent.iter().map(|frame| line_of(frame, None)).collect();
    client.write_all(lines.as_bytes()).unwrap();
    let deadline = Instant::now() + Duration::from_secs(20);
    let mut frames = Vec::new();
    while frames.len() < 100 {
        assert!(Instant::now() < deadline);
        let taken = poll(&mut port, 7);
        assert!(taken.len() <= 7);
        frames.extend(taken);
    }
    assert_eq!(frames, sent);
    assert_eq!(poll(&mut port, 0), []);
}

#[test]
fn the_first_client_that_joins_starts_a_run_even_if_it_only_listens() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    client.write_all(b"L\r").unwrap();
    assert!(port.wait_for_client(Some(Duration::from_secs(20)), &|| false));
    assert_eq!((port.attached(), port.joined()), (1, 1));
    port.send(&frame(0x701, &[5]), None, 0);
    assert_answer(&mut port, &mut client, "t12311F\r", "\rt701105\r\x07");
}

/// About the number of bytes that the port keeps: its debug output has each of them, in four or
/// five characters.
fn kept(port: &SlcanPort) -> usize {
    format!("{port:?}").len() / 5
}

#[test]
fn a_line_without_end_is_answered_when_it_ends_and_takes_no_memory() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    let sending = std::thread::spawn(move || {
        client.write_all(&b"t".repeat(1 << 20)).unwrap();
        client.write_all(b"\rV\r").unwrap();
        let mut answers = [0; 7];
        client.read_exact(&mut answers).unwrap();
        answers
    });
    while !sending.is_finished() {
        assert_eq!(poll(&mut port, 64), []);
        assert!(kept(&port) < 2_000, "{port:?}");
    }
    assert_eq!(&sending.join().unwrap(), b"\x07V0101\r");
}

/// While a run waits for its first client, nothing disconnects a client that reads nothing.
#[test]
fn a_client_that_does_not_read_its_answers_takes_no_memory_and_misses_none() {
    const LINES: usize = 1 << 15;
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    set_socket_recv_buffer_size(&client, 4096).unwrap();
    let mut sender = client.try_clone().unwrap();
    let sending = std::thread::spawn(move || sender.write_all(&b"V\r".repeat(LINES)).unwrap());
    let began = Instant::now();
    let mut most = 0;
    while began.elapsed() < Duration::from_millis(500) {
        poll(&mut port, 64);
        most = most.max(kept(&port));
    }
    assert!((4_000..40_000).contains(&most), "{most} bytes");
    let reading = std::thread::spawn(move || {
        let mut answers = vec![0; 6 * LINES];
        client.read_exact(&mut answers).unwrap();
        answers
    });
    while !reading.is_finished() {
        poll(&mut port, 64);
    }
    sending.join().unwrap();
    assert!(reading.join().unwrap() == b"V0101\r".repeat(LINES));
}

#[test]
fn a_client_without_room_for_its_frames_is_answered_all_the_same() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    client.write_all(b"O\rV\rt0010\rV\r").unwrap();
    assert!(port.wait_for_client(Some(Duration::from_secs(20)), &|| false));
    let mut answer = [0; 7];
    client.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"\rV0101\r");
    // The frame and the order of the lines after it are kept.
    let frames = poll_until(&mut port, |_, frames| !frames.is_empty());
    assert_eq!(frames, [frame(1, &[])]);
    let mut answer = [0; 8];
    client.read_exact(&mut answer).unwrap();
    assert_eq!(&answer, b"z\rV0101\r");
}

#[test]
fn clients_at_once_receive_every_frame_but_their_own() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut clients: Vec<TcpStream> = (0..3).map(|_| client_of(&port)).collect();
    for (count, client) in clients.iter_mut().enumerate() {
        assert_answer(&mut port, client, "O\r", "\r");
        assert_eq!((port.attached(), port.joined()), (count + 1, count + 1));
    }
    port.send(&frame(0x701, &[5]), None, 0);
    clients[1].write_all(b"t20110A\r").unwrap();
    let mut sent = Vec::new();
    while sent.is_empty() {
        sent = port.poll(|_| 64);
    }
    let [(sender, sent)] = sent[..] else {
        panic!("{sent:?}")
    };
    assert_eq!(sent, frame(0x201, &[0x0a]));
    port.send(&sent, Some(sender), 0);
    port.send(&frame(0x702, &[5]), None, 0);
    for (number, client) in clients.iter_mut().enumerate() {
        let expected: &[u8] = if number == 1 {
            b"t701105\rz\rt702105\r"
        } else {
            b"t701105\rt20110A\rt702105\r"
        };
        let mut received = vec![0; expected.len()];
        client.read_exact(&mut received).unwrap();
        assert_eq!(received, expected, "client {number}");
    }
    drop(clients);
    poll_until(&mut port, |port, _| port.attached() == 0);
    assert_eq!(port.joined(), 3);
}

#[test]
fn a_client_too_many_is_disconnected_and_a_place_that_is_left_is_taken_again() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut clients: Vec<TcpStream> = (0..MAX_CLIENTS).map(|_| client_of(&port)).collect();
    for client in &mut clients {
        assert_answer(&mut port, client, "O\r", "\r");
    }
    let mut refused = client_of(&port);
    poll(&mut port, 64);
    assert_eq!(refused.read(&mut [0; 8]).unwrap(), 0);
    clients.pop();
    poll_until(&mut port, |port, _| port.attached() == MAX_CLIENTS - 1);
    let mut last = client_of(&port);
    assert_answer(&mut port, &mut last, "O\r", "\r");
    assert_eq!(port.attached(), MAX_CLIENTS);
}

#[test]
fn waiting_for_a_client_ends_at_its_time_limit_and_when_it_is_told_to() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let _silent = client_of(&port);
    let began = Instant::now();
    assert!(!port.wait_for_client(Some(Duration::from_millis(300)), &|| false));
    assert!(began.elapsed() >= Duration::from_millis(300));
    assert!(!port.wait_for_client(None, &|| began.elapsed() > Duration::from_millis(500)));
}

/// Sends this many numbered frames, and waits for the readers after each.
fn flood(port: &mut SlcanPort, frames: u32) {
    for number in 0..frames {
        port.send(&frame(0x181, &number.to_le_bytes()), None, 0);
        port.wait_for_readers();
    }
}

#[test]
fn the_port_waits_for_a_slow_reader_and_loses_no_frame() {
    const FRAMES: u32 = 20_000;
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut client = client_of(&port);
    assert_answer(&mut port, &mut client, "O\r", "\r");
    let reading = std::thread::spawn(move || {
        let mut text = Vec::new();
        let mut chunk = [0; 16 * 1024];
        while text.len() < FRAMES as usize * 14 {
            std::thread::sleep(Duration::from_millis(10));
            let count = client
                .read(&mut chunk)
                .expect("frames within the time limit");
            assert!(count > 0, "disconnected after {} bytes", text.len());
            text.extend(&chunk[..count]);
        }
        text
    });
    flood(&mut port, FRAMES);
    while !reading.is_finished() {
        poll(&mut port, 0);
    }
    let text = String::from_utf8(reading.join().unwrap()).unwrap();
    let expected: Vec<String> = (0..FRAMES)
        .map(|number| line_of(&frame(0x181, &number.to_le_bytes()), None))
        .collect();
    assert!(text == expected.concat(), "frames are missing or mixed up");
}

#[test]
fn a_client_that_reads_nothing_is_disconnected() {
    let mut port = SlcanPort::bind("127.0.0.1:0").unwrap();
    let mut dead = client_of(&port);
    assert_answer(&mut port, &mut dead, "O\r", "\r");
    let began = Instant::now();
    // The limit is more than any socket accepts before it must be read.
    let mut number = 0;
    while port.attached() == 1 {
        port.send(&frame(0x181, &[0; 8]), None, 0);
        port.wait_for_readers();
        number += 1;
        assert!(number < 4_000_000, "nothing held the port back");
    }
    assert!(began.elapsed() >= Duration::from_secs(5));
}

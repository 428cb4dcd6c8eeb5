//! Tests of CAN clients that communicate with the nodes through the TCP port.

use super::{programs, scenario, with};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::thread::{self, JoinHandle, sleep};
use std::time::{Duration, Instant};
use tautrack_host_tests::programs::Board;
use tautrack_host_tests::scenario::{Expect, Scenario};
use tautrack_host_tests::simulator::run::{Options, RunError, record};
use tautrack_host_tests::simulator::slcan::SlcanPort;

/// Opens a port; returns it with its address.
fn port() -> (SlcanPort, SocketAddr) {
    // The programs are built first, so that the time does not count for the clients' timeouts.
    programs(Board::Host);
    let port = SlcanPort::bind("127.0.0.1:0").expect("a free port");
    let address = port.address().expect("bound");
    (port, address)
}

/// Returns a shipped scenario that ends earlier, without the operator's events.
fn short(name: &str, duration_s: f64) -> Scenario {
    scenario(name, |description| {
        description.duration_s = duration_s;
        description.operator.events.clear();
        description.expect = Expect::default();
    })
}

/// Starts a client that opens its channel after `delay` and reads until the port closes. Returns
/// what it received, and for how long.
fn listener(address: SocketAddr, delay: Duration) -> JoinHandle<(String, Duration)> {
    thread::spawn(move || {
        sleep(delay);
        let mut client = TcpStream::connect(address).expect("the port listens");
        client.write_all(b"O\r").expect("sent");
        let began = Instant::now();
        let mut bytes = Vec::new();
        // If the port closes while bytes are unread, the connection is reset.
        let _ = client.read_to_end(&mut bytes);
        let text = String::from_utf8(bytes).expect("text");
        (text, began.elapsed())
    })
}

#[test]
fn a_run_waits_for_its_first_client_and_keeps_to_real_time() {
    let (port, address) = port();
    let client = listener(address, Duration::from_millis(1_500));
    let options = Options {
        slcan: Some(port),
        ..Options::default()
    };
    let (summary, _) = with(&short("flat", 2.0), Board::Host, options);
    let (text, listened) = client.join().expect("the client is done");
    assert!(
        text.contains("t701100"),
        "the guard's boot-up is not received"
    );
    // The run lasts 2 s, of which 0.1 s may be made up.
    assert!(listened > Duration::from_millis(1_800), "{listened:?}");
    assert!(summary.wall_s > 1.8, "{} s", summary.wall_s);
    // SYNC is sent 250 times per second.
    let syncs = text.matches("t0800\r").count();
    assert!((450..=505).contains(&syncs), "{syncs} SYNCs");
}

#[test]
fn a_speed_replaces_real_time_for_a_run_with_clients() {
    let (port, address) = port();
    let client = listener(address, Duration::ZERO);
    let options = Options {
        slcan: Some(port),
        speed: Some(0.5),
        ..Options::default()
    };
    let (summary, _) = with(&short("flat", 1.0), Board::Host, options);
    client.join().expect("the client is done");
    assert!(summary.wall_s > 1.8, "{} s", summary.wall_s);
}

#[test]
fn a_client_that_joins_a_run_that_did_not_wait_is_answered_at_once() {
    let (port, address) = port();
    let asking = thread::spawn(move || {
        sleep(Duration::from_millis(1_500));
        let mut client = TcpStream::connect(address).expect("the port listens");
        let limit = Some(Duration::from_secs(20));
        client.set_read_timeout(limit).expect("a time limit");
        let began = Instant::now();
        client
            .write_all(b"O\rt60484000100000000000\r")
            .expect("sent");
        let mut text = String::new();
        let mut bytes = [0; 4096];
        while !text.contains("t5848") {
            let count = client.read(&mut bytes).expect("an answer in time");
            assert!(count > 0, "the run ended before the answer");
            text.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
        began.elapsed()
    });
    let options = Options {
        slcan: Some(port),
        slcan_wait: Some(Duration::ZERO),
        ..Options::default()
    };
    with(&short("flat", 6.0), Board::Host, options);
    let took = asking.join().expect("the client is answered");
    // The answer takes milliseconds, or longer on a loaded computer. If the run were ahead of the
    // wall clock, it would sleep longer.
    assert!(took < Duration::from_secs(3), "{took:?}");
}

#[test]
fn nobody_commands_the_robot_where_a_client_is_the_operator() {
    for (name, commands) in [("client", false), ("flat", true)] {
        let (port, address) = port();
        let client = listener(address, Duration::ZERO);
        let options = Options {
            slcan: Some(port),
            speed: Some(20.0),
            ..Options::default()
        };
        let (_, samples) = with(&short(name, 4.0), Board::Host, options);
        let (text, _) = client.join().expect("the client is done");
        assert_eq!(text.contains("t2018"), commands, "{name}");
        let state = &samples.last().expect("samples").received.guard_state;
        assert_eq!(state == "ready", !commands, "{name}: {state}");
    }
}

#[test]
fn a_run_with_a_client_as_operator_ends_soon_after_the_last_one_left() {
    let (port, address) = port();
    let client = thread::spawn(move || {
        let mut client = TcpStream::connect(address).expect("the port listens");
        client.write_all(b"O\r").expect("sent");
        sleep(Duration::from_millis(500));
    });
    let options = Options {
        slcan: Some(port),
        speed: Some(10.0),
        ..Options::default()
    };
    let scenario = scenario("client", |_| {});
    let mut samples = Vec::new();
    let ending =
        record(&scenario, programs(Board::Host), options, &mut samples).expect("the nodes start");
    client.join().expect("the client is done");
    assert!(ending.error.is_none(), "{:?}", ending.error);
    assert_eq!(ending.clients, 1);
    let end = samples.last().expect("samples").time_s;
    assert!((5.0..60.0).contains(&end), "{end} s");
}

#[test]
fn a_run_whose_operator_never_comes_says_so_after_the_wait() {
    let (port, _) = port();
    let options = Options {
        slcan: Some(port),
        slcan_wait: Some(Duration::from_millis(200)),
        ..Options::default()
    };
    let scenario = scenario("client", |_| {});
    let mut samples = Vec::new();
    let ending =
        record(&scenario, programs(Board::Host), options, &mut samples).expect("the nodes start");
    assert!(matches!(ending.error, Some(RunError::NoClient)));
    assert!(samples.is_empty());
}

#[test]
fn a_client_reads_the_device_type_of_the_chassis_joint_while_the_robot_runs() {
    // Built first, so that the time does not count for the client's timeout.
    super::programs(Board::Host);
    let port = SlcanPort::bind("127.0.0.1:0").expect("a free port");
    let mut client = TcpStream::connect(port.address().expect("bound")).expect("the port listens");
    client
        .set_read_timeout(Some(Duration::from_mins(1)))
        .expect("a time limit");
    let asking = std::thread::spawn(move || {
        // Opens the channel and uploads object 0x1000:0 of node 4.
        client
            .write_all(b"O\rt60484000100000000000\r")
            .expect("sent");
        let mut text = String::new();
        let mut bytes = [0; 4096];
        while !text.contains("t5848") {
            let count = client
                .read(&mut bytes)
                .expect("an answer within the time limit");
            assert!(count > 0, "the port closed before the answer: {text}");
            text.push_str(&String::from_utf8_lossy(&bytes[..count]));
        }
        let answer = text.split("t5848").nth(1).unwrap_or_default().to_string();
        (text, answer)
    });
    let short = scenario("flat", |description| {
        description.duration_s = 3.0;
        description.expect = tautrack_host_tests::scenario::Expect::default();
    });
    with(
        &short,
        Board::Host,
        Options {
            slcan: Some(port),
            ..Options::default()
        },
    );
    let (text, answer) = asking.join().expect("the client is done");
    // 43: expedited transfer of four bytes; 0x00020192: servo drive of CiA 402.
    assert!(answer.starts_with("4300100092010200"), "{answer}");
    assert!(
        text.contains("t701100"),
        "the guard's boot-up is received: {text}"
    );
}

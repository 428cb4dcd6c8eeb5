//! A CAN client from elsewhere, through the TCP port, talking to the real nodes.

use super::{scenario, with};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;
use tautrack_host_tests::nodes::Board;
use tautrack_host_tests::run::Options;
use tautrack_host_tests::slcan::SlcanPort;

#[test]
fn a_client_reads_the_device_type_of_the_chassis_joint_while_the_robot_runs() {
    // Not within the client's time limit.
    super::programs(Board::Native);
    let port = SlcanPort::bind("127.0.0.1:0").expect("a free port");
    let mut client = TcpStream::connect(port.address().expect("bound")).expect("the port listens");
    client
        .set_read_timeout(Some(Duration::from_secs(60)))
        .expect("a time limit");
    let asking = std::thread::spawn(move || {
        // Open the channel; upload object 0x1000:0 of node 4.
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
        Board::Native,
        Options {
            slcan: Some(port),
            ..Options::default()
        },
    );
    let (text, answer) = asking.join().expect("the client is done");
    // 43: four bytes expedited; 0x00020192: servo drive of CiA 402.
    assert!(answer.starts_with("4300100092010200"), "{answer}");
    assert!(
        text.contains("t701100"),
        "the guard's boot-up is heard: {text}"
    );
}

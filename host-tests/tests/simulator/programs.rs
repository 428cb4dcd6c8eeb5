//! Tests that the nodes are built and start.

use std::io::{Read, Write};
use std::process::{Command, Stdio};
use tautrack::link::{FromNode, PREFIX, Start, ToNode, VERSION};
use tautrack_host_tests::programs::setup::QEMU;
use tautrack_host_tests::programs::{Board, changes_a_build};
use tautrack_host_tests::robots::Kind;

#[test]
fn surroundings_of_cargo_do_not_reach_the_build_of_the_nodes() {
    for name in [
        "CARGO_ENCODED_RUSTFLAGS",
        "CARGO_PROFILE_FIRMWARE_LTO",
        "RUSTFLAGS",
        "RUSTC_WRAPPER",
        "DEFMT_LOG",
    ] {
        assert!(changes_a_build(name.as_ref()), "{name}");
    }
    for name in [
        "PATH",
        "CARGO_HOME",
        "CARGO_HTTP_CAINFO",
        "CARGO_NET_OFFLINE",
        "RUSTUP_TOOLCHAIN",
        "HTTPS_PROXY",
    ] {
        assert!(!changes_a_build(name.as_ref()), "{name}");
    }
}

#[test]
fn nodes_are_built_and_answer_in_qemu() {
    let programs = Kind::B2p2
        .programs(Board::Qemu)
        .unwrap_or_else(|error| panic!("{error}"));
    let program = &programs.nodes;
    assert_eq!(program.sha256.len(), 64);
    for role in ["axle", "screw", "guard"] {
        let mut node = Command::new(QEMU)
            .args([
                "-M",
                "mps2-an386",
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "none",
            ])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&program.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let start = Start {
            version: VERSION,
            seed: 1,
            flash: heapless::String::new(),
            settings: heapless::Vec::new(),
            motor: None,
            role: role.try_into().unwrap(),
        };
        let body = postcard::to_allocvec(&ToNode::Start(start)).unwrap();
        let mut input = node.stdin.take().unwrap();
        let length = body.len() as u16;
        input.write_all(&length.to_le_bytes()).unwrap();
        input.write_all(&body).unwrap();
        let mut output = node.stdout.take().unwrap();
        let mut prefix = [0; PREFIX];
        output.read_exact(&mut prefix).unwrap();
        let mut body = vec![0; usize::from(u16::from_le_bytes(prefix))];
        output.read_exact(&mut body).unwrap();
        let FromNode::Ready(ready) = postcard::from_bytes(&body).unwrap() else {
            panic!("{role} does not begin with Ready");
        };
        assert_eq!(
            (ready.version, ready.role.as_str(), ready.board.as_str()),
            (VERSION, role, "mps2")
        );
        drop(input);
        node.kill().unwrap();
        node.wait().unwrap();
    }
}

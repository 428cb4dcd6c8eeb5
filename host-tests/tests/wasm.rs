//! Tests that nodes in the simulator's process behave like those that are processes.
//! `--test simulator hash` and `--test robots` compare processes of the host with emulated nodes.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use tautrack::link::{STEP_US, Sensors, Start, Step, VERSION};
use tautrack::settings::Setting;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::programs::{Board, Program};
use tautrack_host_tests::robots::{Kind, NodeName};
use tautrack_host_tests::scenario::{Description, Event, Expect, Fault, FaultKind, Scenario};
use tautrack_host_tests::simulator::record::Sample;
use tautrack_host_tests::simulator::run::Machines;
use tautrack_host_tests::simulator::run::node::Node;
use tautrack_host_tests::simulator::run::{Options, Sink, Unwritten, record};

/// Virtual time of the compared runs, s. It includes homing, arming and a part of each robot's
/// task.
const COMPARED_S: f64 = 25.0;

fn root() -> &'static Path {
    checkout::root().unwrap_or_else(|error| panic!("{error}"))
}

/// Loads the beginning of a shipped scenario and changes it.
fn beginning(file: &str, change: impl FnOnce(&mut Description)) -> Scenario {
    let path = root().join("host-tests/scenarios").join(file);
    let mut description = Scenario::load(&path)
        .unwrap_or_else(|error| panic!("{error}"))
        .description();
    description.duration_s = COMPARED_S;
    description.expect = Expect::default();
    let late = |event: &Event| event.when.after_s.is_some_and(|after| after > COMPARED_S);
    let events = &mut description.operator.events;
    events.truncate(events.iter().position(late).unwrap_or(events.len()));
    change(&mut description);
    Scenario::checked(description).unwrap_or_else(|error| panic!("{error}"))
}

/// Log lines of a run's nodes.
#[derive(Default)]
struct Log(Vec<String>);

impl Sink for Log {
    fn sample(&mut self, _sample: Sample) -> Result<(), Unwritten> {
        Ok(())
    }

    fn log(&mut self, line: &str) -> Result<(), Unwritten> {
        self.0.push(line.to_owned());
        Ok(())
    }
}

/// Runs `scenario` to its end. Returns its hash and the lines that its nodes log.
fn outcome(scenario: &Scenario, board: Board, options: Options) -> (String, Vec<String>) {
    let programs = scenario
        .kind()
        .programs(board)
        .unwrap_or_else(|error| panic!("{error}"));
    let mut log = Log::default();
    let ending =
        record(scenario, &programs, options, &mut log).unwrap_or_else(|error| panic!("{error}"));
    assert!(ending.error.is_none(), "{:?}", ending.error);
    (ending.facts.state_hash, log.0)
}

/// Asserts that a run with nodes in this process is bit-identical with one of processes, and that
/// its nodes log the same. Returns its hash.
fn runs_alike(scenario: &Scenario, options: impl Fn() -> Options) -> String {
    let [native, wasm] =
        [Board::Native, Board::Wasm].map(|board| outcome(scenario, board, options()));
    assert!(!native.1.is_empty(), "no node logs anything");
    assert_eq!(wasm, native);
    wasm.0
}

#[test]
fn nodes_of_every_robot_end_in_the_bits_of_processes() {
    for kind in [Kind::B2p2, Kind::Crawler, Kind::RtMover, Kind::Hylos] {
        let file = kind.facts().scenario_file;
        println!("{file}");
        runs_alike(&beginning(file, |_| {}), Options::default);
    }
}

#[test]
fn a_node_restarts_as_a_process_does() {
    let restarting = beginning("flat.toml", |description| {
        description.duration_s = 8.0;
        description.faults = vec![Fault {
            what: FaultKind::Restart(NodeName::GUARD),
            at_s: 6.0,
            until_s: Some(6.5),
            notice_within_ms: None,
        }];
    });
    let hash = runs_alike(&restarting, Options::default);
    let healthy = beginning("flat.toml", |description| description.duration_s = 8.0);
    assert_ne!(hash, runs_alike(&healthy, Options::default));
}

#[test]
fn single_nodes_can_be_processes() {
    let healthy = beginning("flat.toml", |description| description.duration_s = 8.0);
    let program = Program {
        path: PathBuf::from(env!("CARGO_BIN_EXE_constant_axle")),
        sha256: String::new(),
    };
    runs_alike(&healthy, || Options {
        exchanged: vec![(NodeName::RIGHT_TRACK, Board::Native, program.clone())],
        ..Options::default()
    });
}

/// Builds the node that fails, and returns its program.
fn faulty() -> PathBuf {
    let target = root().join("target/nodes");
    let status = Command::new(env!("CARGO"))
        .current_dir(root())
        .args(["build", "--locked", "--package", "tautrack-firmware"])
        .args(["--example", "faulty", "--profile", "firmware"])
        .args(["--target", "wasm32-unknown-unknown", "--target-dir"])
        .arg(&target)
        .status();
    assert!(status.expect("cargo starts").success(), "it does not build");
    target.join("wasm32-unknown-unknown/firmware/examples/faulty.wasm")
}

/// Runs a node until it fails, at most ten steps that begin `late_us` after its start. Returns the
/// error.
fn failure(program: &Path, node_id: i32, late_us: u64) -> String {
    let start = Start {
        version: VERSION,
        seed: 1,
        flash: heapless::String::new(),
        settings: std::iter::once((Setting::NodeId.description().key, node_id)).collect(),
        motor: None,
        role: heapless::String::new(), // its own
    };
    let (mut node, _) = Node::start(
        NodeName::SCREW,
        Board::Wasm,
        program,
        start,
        &mut Machines::default(),
    )
    .unwrap_or_else(|error| panic!("{error}"));
    node.set_timeout(Duration::from_millis(200));
    for step in 1..=10 {
        let step = Step {
            time_us: late_us + step * STEP_US,
            sensors: Sensors::default(),
            frames: heapless::Vec::new(),
            serial: heapless::Vec::new(),
        };
        if let Err(error) = node.send(step).and_then(|()| node.receive()) {
            return error.to_string();
        }
    }
    panic!("the node does not fail");
}

#[test]
fn a_failed_node_is_reported_with_its_reason_and_ends_alone() {
    let program = faulty();
    let panicked = failure(&program, 1, 0);
    assert!(panicked.contains("this node always panics"), "{panicked}");
    assert!(panicked.contains("faulty.rs"), "{panicked}");
    let silent = failure(&program, 2, 0);
    assert!(silent.contains("no answer for 0.2 s"), "{silent}");
    let programs = Kind::B2p2
        .programs(Board::Wasm)
        .unwrap_or_else(|error| panic!("{error}"));
    let starved = failure(&programs.nodes.path, 5, 1_000_000);
    assert!(starved.contains("watchdog: not fed"), "{starved}");
}
